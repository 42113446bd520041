// Turns that take +y to another direction.
#pragma once

#include "pvol/math/vec.h"

namespace pvol {

/// A vector turned by the shortest way that takes +y to `up`, unit; about x where that is -y.
[[nodiscard]] inline Vec3d turn_up(Vec3d up, Vec3d v) {
  if (up.y < -1 + 1e-12) return {v.x, -v.y, -v.z};
  const Vec3d axis(up.z, 0, -up.x);  // times the sine
  return v * up.y + cross(axis, v) + axis * (dot(axis, v) / (1 + up.y));
}

}  // namespace pvol
