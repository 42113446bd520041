// Bounds as voxels, to look at in any volume viewer.
#pragma once

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"

namespace pvol {

/// Majorants and minorants of the leaves as grids of their own, one voxel for each cube of 8^3
/// cells, named "majorant" and "minorant". `index_to_world` is the map of the density; those of the
/// results put each sample at the centre of its cube. Cubes without density are 0.
/// Throws Error where uniform cubes would fill more than `max_bricks` bricks of 8^3 such voxels.
struct BoundGrids {
  VoxelGrid majorant, minorant;
};
[[nodiscard]] BoundGrids make_bound_grids(const Pyramid& pyramid, const Affine& index_to_world,
                                          std::uint64_t max_bricks = std::uint64_t(1) << 20);

}  // namespace pvol
