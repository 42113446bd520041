// Velocities as files have them.
#pragma once

#include <array>

#include "pvol/density/voxel_grid.h"

namespace pvol {

/// The components along x, y and z of the space that index_to_world leads to, in its units per
/// second. Unlike densities their samples, and values of tiles, are of either sign; finite, and 0
/// in no brick and no tile. All three lie on one lattice: they have the same index_to_world.
struct VelocityGrid {
  std::array<VoxelGrid, 3> along;

  [[nodiscard]] const Affine& index_to_world() const { return along[0].index_to_world; }
};

/// A velocity as grids that are not negative: the positive and the negative part of its component
/// along x, then of those along y and z.
[[nodiscard]] std::array<VoxelGrid, 6> signed_parts(const VelocityGrid& velocity);

/// The velocity that has these parts, which lie on one lattice.
[[nodiscard]] VelocityGrid join_parts(const std::array<VoxelGrid, 6>& parts);

}  // namespace pvol
