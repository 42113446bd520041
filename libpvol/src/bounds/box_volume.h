// How much of a pyramid's cube lies where walks go.
#pragma once

#include "pvol/bounds/pyramid.h"

namespace pvol::detail {

/// Volume in cells of the part of a cube inside the support's box, at which walks end.
[[nodiscard]] inline double volume_in_box(const Pyramid& p, Vec3l origin, std::int64_t edge) {
  const Vec3l size = min(origin + Vec3l(edge), p.support_hi) - max(origin, p.support_lo);
  return size.x > 0 && size.y > 0 && size.z > 0 ? double(size.x) * double(size.y) * double(size.z)
                                                : 0;
}

/// The same for the cube of a node.
[[nodiscard]] inline double volume_in_box(const Pyramid& p, std::size_t level, std::uint64_t code) {
  const std::int64_t edge = std::int64_t(kLeafEdge) << level;
  return volume_in_box(p, p.origin + Vec3l(morton_decode(code)) * edge, edge);
}

}  // namespace pvol::detail
