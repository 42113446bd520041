// From the values of a grid to what they mean: density, emission, a share of either.
#pragma once

#include <array>
#include <optional>

#include "pvol/math/ramp.h"

namespace pvol {

/// y = ramp(clamp(scale v + offset) ^ power), at least 0; each step that is not asked for is left
/// out. Powers are of what is at least 0. Each step but the ramp never falls, or never rises, as
/// its argument rises: the range of the map over a range of values is known exactly (THEORY.md,
/// T1.5).
struct FieldMap {
  double scale = 1, offset = 0;
  std::optional<std::array<double, 2>> clamp{};  ///< least and most
  double power = 1;                              ///< above 0
  Ramp ramp{};                                   ///< none: without points
  friend bool operator==(const FieldMap&, const FieldMap&) = default;

  [[nodiscard]] bool is_identity() const { return *this == FieldMap{}; }
};

/// Of a finite v. Not negative; infinite where it is more than a float holds.
[[nodiscard]] float value_at(const FieldMap& map, float v);

/// Bounds on all values over [from.lo, from.hi]: the exact range, but for a factor of 1 + 2^-20 for
/// the rounding of a power and of a smooth ramp.
[[nodiscard]] ValueRange range_over(const FieldMap& map, ValueRange from);

}  // namespace pvol
