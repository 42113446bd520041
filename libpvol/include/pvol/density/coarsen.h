// A cloud with fewer samples, for previews.
#pragma once

#include "pvol/density/voxel_grid.h"

namespace pvol {

/// The grid with every other sample along each axis, each the mean of its neighbourhood with
/// weights (1/4, 1/2, 1/4) along each axis: sample I stands at index point 2 I of the grid that it
/// comes from, and the mass, the integral of the trilinear density over the world, stays the same
/// but for rounding. The support may grow by a coarse cell. In parallel. Throws Error where tiles
/// would make more than 2^26 bricks.
[[nodiscard]] VoxelGrid coarsen(const VoxelGrid& grid);

}  // namespace pvol
