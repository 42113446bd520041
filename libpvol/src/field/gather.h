// The samples of a leaf's brick, from the blocks that a grid has them in.
#pragma once

#include "density/lattice_index.h"

namespace pvol::detail {

/// Writes the samples that interpolation in the leaf at `origin`, a multiple of 8, reads, in the
/// order of a BrickField's brick.
void gather(const BlockFinder& blocks, Vec3i origin, LookUp look_up, float* out);

}  // namespace pvol::detail
