#include "pvol/volume/rayleigh.h"

namespace pvol {

// The share within c is u where c^3 - 3 c^2 + 6 c = 8 u: with x = 1 - c it is x^3 + 3 x = 4 - 8 u,
// whose root is a hyperbolic sine. A step of Newton brings back the digits that 1 - x lost.
float one_minus_cos_of_share(const Rayleigh&, float u) {
  const double target = 8 * double(u);
  const double c = 1 - 2 * std::sinh(std::asinh(2 - target / 2) / 3);
  const double value = c * (6 - c * (3 - c)), slope = 3 + 3 * (1 - c) * (1 - c);
  return float(std::clamp(c - (value - target) / slope, 0.0, 2.0));
}

}  // namespace pvol
