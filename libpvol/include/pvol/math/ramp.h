// Functions of one number through given points.
#pragma once

#include <vector>

namespace pvol {

struct RampPoint {
  float x = 0, y = 0;
  friend bool operator==(const RampPoint&, const RampPoint&) = default;
};

/// Goes through its points, by straight lines or, where `smooth`, by a cubic that has no extremes
/// but at points; constant before the first and after the last. Points ascend strictly in x and are
/// finite; without any it is 0. Based on: Fritsch, Butland. A method for constructing local
/// monotone piecewise cubic interpolants. 1984 (THEORY.md, T1.5).
struct Ramp {
  std::vector<RampPoint> points;
  bool smooth = false;
  friend bool operator==(const Ramp&, const Ramp&) = default;
};

/// Of any x that is no NaN. Between two points the result is between theirs, whatever the rounding.
[[nodiscard]] float value_at(const Ramp& ramp, float x);

/// Least and largest value; this factor more or less makes up for rounding that nobody promises.
inline constexpr float kRangeSlack = 0x1p-20f;
struct ValueRange {
  float lo = 0, hi = 0;
  friend bool operator==(const ValueRange&, const ValueRange&) = default;
};

/// Bounds on all values over [from.lo, from.hi]: their range, but for a factor of 1 + 2^-20 for the
/// rounding of smooth ramps.
[[nodiscard]] ValueRange range_over(const Ramp& ramp, ValueRange from);

}  // namespace pvol
