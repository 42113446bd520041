// Look-ups in a volume's cells, wherever in the world these are.
#pragma once

#include "pvol/volume/volume.h"

namespace pvol::detail {

/// mu_t at a place in cells from the octree's origin; 0 outside the support.
[[nodiscard]] float extinction_in_cells(const Volume& volume, Vec3d cells);

}  // namespace pvol::detail
