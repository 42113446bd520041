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

}  // namespace pvol
