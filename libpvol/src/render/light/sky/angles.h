// Angles of the sky, in radians.
#pragma once

#include <numbers>

namespace pvol::detail {

inline constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

}  // namespace pvol::detail
