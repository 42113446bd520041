// Whether boxes have a point in common.
#pragma once

#include "pvol/math/box.h"

namespace pvol::detail {

/// Of closed boxes; an empty one meets none.
[[nodiscard]] inline bool meet(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(a.lo[axis] <= b.hi[axis] && b.lo[axis] <= a.hi[axis])) return false;
  }
  return true;
}

}  // namespace pvol::detail
