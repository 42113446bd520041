#include "bounds/pyramid_parts.h"

#include <limits>
#include <string>

#include "pvol/error.h"

namespace pvol::detail {
namespace {

/// Whether all corners of the sample blocks that a leaf reads are 32-bit lattice points.
bool in_lattice(Vec3l origin, KernelExtent extent) {
  const std::int64_t below = extent.below > 0 ? kLeafEdge : 0;
  return min_component(origin) - below >= std::numeric_limits<std::int32_t>::min() &&
         max_component(origin) <= std::numeric_limits<std::int32_t>::max() - 2 * kLeafEdge;
}

}  // namespace

void place_root(Pyramid& p, Vec3l lo, Vec3l hi, float largest) {
  const KernelExtent extent = extent_of(p.look_up);
  p.support_lo = lo - Vec3l(extent.above);
  p.support_hi = hi + Vec3l(extent.below + 1);
  p.scale = largest;
  for (int axis = 0; axis < 3; ++axis) p.origin[axis] = p.support_lo[axis] & ~std::int64_t(7);
  const std::int64_t cells = max_component(p.support_hi - p.origin);
  int root_log2 = 3;
  while ((std::int64_t(1) << root_log2) < cells) ++root_log2;
  if (root_log2 > kMaxRootLog2) {
    throw Error("the density extends over " + std::to_string(cells) +
                " voxels along one axis; expected at most 16777216. Split distant parts into "
                "separate clouds, or remove stray voxels.");
  }
  p.levels.resize(std::size_t(root_log2) - 2);
  if (!in_lattice(p.origin, extent) || !in_lattice(p.support_hi, extent)) {
    throw Error(
        "voxels lie within 16 of the end of the 32-bit index range; move the volume towards "
        "the origin of its index space.");
  }
}

PyramidNode quantize(const PyramidNode& n, float scale) {
  return {n.code, decode(encode_down(n.lo, scale), scale), decode(encode_up(n.hi, scale), scale)};
}

}  // namespace pvol::detail
