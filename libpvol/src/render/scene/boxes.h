// How boxes lie to each other and to points.
#pragma once

#include "pvol/math/box.h"

namespace pvol::detail {

/// Whether closed boxes have a point in common; an empty one meets none.
[[nodiscard]] inline bool meet(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(a.lo[axis] <= b.hi[axis] && b.lo[axis] <= a.hi[axis])) return false;
  }
  return true;
}

[[nodiscard]] inline int longest_axis(const Box& b) {
  const Vec3d e = b.extent();
  return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
}

/// From a point to a box that is not empty; 0 within.
[[nodiscard]] inline double distance(const Box& b, Vec3d p) {
  return length(max(max(b.lo - p, p - b.hi), Vec3d(0.0)));
}

}  // namespace pvol::detail
