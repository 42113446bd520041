// What builders of pyramids share.
#pragma once

#include "pvol/bounds/pyramid.h"

namespace pvol::detail {

/// Gives a pyramid of the way of look-up that it has its origin, support, scale and empty levels:
/// `lo` and `hi` are the outermost lattice points with a sample above 0, `largest` is the largest
/// sample. The root is a power-of-two multiple of leaves from the leaf below the lowest cell.
/// Throws Error where it would be too large, or voxels lie at the end of the 32-bit lattice.
void place_root(Pyramid& pyramid, Vec3l lo, Vec3l hi, float largest);

/// The node with its bounds rounded outward to the 16-bit code.
[[nodiscard]] PyramidNode quantize(const PyramidNode& node, float scale);

}  // namespace pvol::detail
