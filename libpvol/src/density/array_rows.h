// Bricks out of dense arrays, row by row.
#pragma once

#include "pvol/density/voxel_grid.h"

namespace pvol::detail {

/// In samples, along each axis.
[[nodiscard]] inline Vec3l stride_of(const DenseArray& array) {
  const Vec3l size(array.size);
  return array.stride.value_or(Vec3l(size.y * size.z, size.z, 1));
}

/// What fills bricks with the lattice points lo <= p < hi of an array: copy(p, to, count) writes
/// the samples of `count` points from p on, along z.
template <class Copy>
[[nodiscard]] FillBrick fill_by_rows(Vec3l lo, Vec3l hi, const Copy& copy) {
  return [=](Vec3i origin, float* values) {
    const Vec3l brick(origin), begin = max(brick, lo), end = min(brick + Vec3l(kBrickEdge), hi);
    for (std::int64_t x = begin.x; x < end.x; ++x) {
      for (std::int64_t y = begin.y; y < end.y; ++y) {
        const Vec3l row(x, y, begin.z), to = row - brick;
        copy(row, values + (to.x * kBrickEdge + to.y) * kBrickEdge + to.z, end.z - begin.z);
      }
    }
  };
}

/// Along each axis, of those that hold a lattice point of lo <= p < hi.
[[nodiscard]] inline Vec3l count_bricks(Vec3l lo, Vec3l hi) {
  Vec3l count;
  for (int axis = 0; axis < 3; ++axis) {
    count[axis] = (((hi[axis] - 1) & -kBrickEdge) - (lo[axis] & -kBrickEdge)) / kBrickEdge + 1;
  }
  return count;
}

/// Throws NoMemory (math/memory.h) where a grid of what `fill` writes for the lattice points lo <=
/// p < hi would need more than is free, by what it writes for some of the bricks: for arrays, which
/// are there to be read twice.
void require_grid_memory(Vec3l lo, Vec3l hi, const FillBrick& fill);

}  // namespace pvol::detail
