// Whether bounds hold their samples, before anything is made of them.
#pragma once

#include "pvol/bounds/pyramid.h"

namespace pvol::detail {

/// Throws Error where bounds do not hold all their samples.
void require_bounds(const VoxelGrid& grid, const Pyramid& pyramid);

/// Throws Error for what no tracker makes up for: density where there is no cube, and uniform cubes
/// around several values.
void require_cover(const VoxelGrid& grid, const Pyramid& pyramid);

}  // namespace pvol::detail
