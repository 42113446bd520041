// Whether grids of callers are densities.
#pragma once

#include "pvol/density/voxel_grid.h"

namespace pvol::detail {

/// Throws Error, which names it, for a brick or tile that is not as Brick and Tile say; tiles may
/// be 0.
void check_cubes(const VoxelGrid& grid);

/// Throws Error where cubes of a grid overlap that passes check_cubes.
void check_disjoint(const VoxelGrid& grid);

}  // namespace pvol::detail
