// Directions of any length.
#pragma once

#include <cmath>

#include "pvol/math/vec.h"

namespace pvol::detail {

/// The direction, scaled where its square leaves the range of doubles; 0 for one that is 0 or not
/// finite.
[[nodiscard]] inline Vec3d in_range(const Vec3d& direction) {
  const double squared = dot(direction, direction);
  if (squared > 0x1p-1000 && squared < 0x1p1000) return direction;
  const double most = max_component(max(direction, -direction));
  if (!is_finite(direction) || most == 0) return {};
  // In two steps, for the reciprocal of the smallest doubles is infinite.
  const double step = most < 1 ? 0x1p500 : 0x1p-500;
  return direction * step / (most * step);
}

/// The unit vector along it; 0 for one that is 0 or not finite.
[[nodiscard]] inline Vec3d unit_of(const Vec3d& direction) {
  const Vec3d d = in_range(direction);
  return d == Vec3d{} ? d : d / std::sqrt(dot(d, d));
}

}  // namespace pvol::detail
