// Where polynomials of low degree change their sign.
#pragma once

#include <array>
#include <span>

namespace pvol {

/// c[0] + c[1] s + ... + c[4] s^4.
using Quartic = std::array<double, 5>;

[[nodiscard]] inline double value(const Quartic& c, double s) {
  return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * c[4])));
}

/// Up to four places, ascending.
struct Roots {
  std::array<double, 4> at{};
  int count = 0;

  void add(double s) { at[static_cast<std::size_t>(count++)] = s; }
  [[nodiscard]] std::span<const double> all() const& {
    return {at.data(), static_cast<std::size_t>(count)};
  }
  std::span<const double> all() && = delete;  // it would refer to what is gone
};

/// Every s in [lo, hi] at which the polynomial, as `value` computes it, passes from one sign to the
/// other, to the last digit: the roots of the derivative cut the interval into pieces on which it
/// is monotone, and bracketed Newton steps find the one root of each (THEORY.md, T7.7).
[[nodiscard]] Roots sign_changes(const Quartic& c, double lo, double hi);

}  // namespace pvol
