// Interval arithmetic with outward rounding, for bounds that must hold.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace pvol {

/// The smallest double above x, and the largest below: one step past a correctly rounded result
/// encloses the exact one, also where the result overflowed (below infinity is the largest finite
/// number). As std::nextafter, which takes several times as long: bounds take millions of steps.
[[nodiscard]] inline double round_up(double x) {
  constexpr auto kInfinity = std::bit_cast<std::int64_t>(std::numeric_limits<double>::infinity());
  const auto bits = std::bit_cast<std::int64_t>(x);
  const std::int64_t magnitude = bits & std::numeric_limits<std::int64_t>::max();
  if (magnitude == 0) return std::numeric_limits<double>::denorm_min();
  if (bits == kInfinity || magnitude > kInfinity) return x;  // nothing is above it, or it is NaN
  return std::bit_cast<double>(bits < 0 ? bits - 1 : bits + 1);
}
[[nodiscard]] inline double round_down(double x) { return -round_up(-x); }

/// All reals in [lo, hi]. Each operation encloses the exact result for every choice of operands
/// (Moore. Interval Analysis. 1966): results are widened by one ulp instead of switching the
/// rounding mode, so at most one ulp per operation is lost and no global state is touched.
struct Interval {
  double lo = 0, hi = 0;

  constexpr Interval() = default;
  constexpr Interval(double v) : lo(v), hi(v) {}  // NOLINT: a number is an interval
  constexpr Interval(double lo_, double hi_) : lo(lo_), hi(hi_) {}

  [[nodiscard]] constexpr bool contains(double v) const { return lo <= v && v <= hi; }
  [[nodiscard]] constexpr double width() const { return hi - lo; }
  friend constexpr bool operator==(const Interval&, const Interval&) = default;
};

[[nodiscard]] inline Interval operator-(Interval a) { return {-a.hi, -a.lo}; }
[[nodiscard]] inline Interval operator+(Interval a, Interval b) {
  return {round_down(a.lo + b.lo), round_up(a.hi + b.hi)};
}
[[nodiscard]] inline Interval operator-(Interval a, Interval b) {
  return {round_down(a.lo - b.hi), round_up(a.hi - b.lo)};
}
[[nodiscard]] inline Interval operator*(Interval a, Interval b) {
  // An infinite end stands for reals without limit, and 0 times any of them is 0.
  const auto times = [](double x, double y) { return x == 0 || y == 0 ? 0 : x * y; };
  const double p[4] = {times(a.lo, b.lo), times(a.lo, b.hi), times(a.hi, b.lo), times(a.hi, b.hi)};
  return {round_down(*std::min_element(p, p + 4)), round_up(*std::max_element(p, p + 4))};
}

/// x^2, tighter than x * x where x holds 0.
[[nodiscard]] inline Interval square(Interval a) {
  const double l = a.lo * a.lo, h = a.hi * a.hi;
  const double least = a.lo <= 0 && a.hi >= 0 ? 0 : std::max(0.0, round_down(std::min(l, h)));
  return {least, round_up(std::max(l, h))};
}

/// sqrt of the non-negative part.
[[nodiscard]] inline Interval sqrt(Interval a) {
  return {std::max(0.0, round_down(std::sqrt(std::max(0.0, a.lo)))),
          round_up(std::sqrt(std::max(0.0, a.hi)))};
}

[[nodiscard]] inline Interval min(Interval a, Interval b) {
  return {std::min(a.lo, b.lo), std::min(a.hi, b.hi)};
}
[[nodiscard]] inline Interval max(Interval a, Interval b) {
  return {std::max(a.lo, b.lo), std::max(a.hi, b.hi)};
}
[[nodiscard]] inline Interval hull(Interval a, Interval b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

}  // namespace pvol
