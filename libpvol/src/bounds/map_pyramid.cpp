#include "pvol/bounds/map_pyramid.h"

#include <cmath>

#include "math/digits.h"
#include "pvol/error.h"

namespace pvol {
namespace {

void check(const FieldMap& map, const Pyramid& pyramid) {
  if (const float empty = value_at(map, 0); empty > 0) {
    throw Error("the map makes " + detail::digits(double(empty)) +
                " of 0, which would fill all space; expected 0. Lower its offset, or start its "
                "ramp at 0, 0");
  }
  if (!std::isfinite(range_over(map, {0, pyramid.scale}).hi)) {
    throw Error("the map exceeds the range of single precision for values up to " +
                detail::digits(double(pyramid.scale)) + "; take a smaller scale or power");
  }
}

/// The support that is left: that of the cubes, within the old one.
void shrink_support(Pyramid& p) {
  Vec3l lo = p.support_hi, hi = p.support_lo;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (level > 0 && !is_uniform(p, level, i)) continue;
      const Vec3l from = p.origin + Vec3l(morton_decode(p.levels[level][i].code)) * edge;
      lo = min(lo, from);
      hi = max(hi, from + Vec3l(edge));
    }
  }
  p.support_lo = max(p.support_lo, lo);
  p.support_hi = min(p.support_hi, hi);
}

}  // namespace

Pyramid map_pyramid(const Pyramid& pyramid, const FieldMap& map) {
  if (pyramid.empty() || map.is_identity()) return pyramid;
  check(map, pyramid);
  Pyramid mapped = pyramid;
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    std::vector<PyramidNode>& nodes = mapped.levels[level];
    nodes.clear();
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      if (level > 0 && !is_uniform(pyramid, level, i)) continue;
      PyramidNode node = pyramid.levels[level][i];
      const ValueRange r = range_over(map, {node.lo, node.hi});
      node.lo = r.lo, node.hi = r.hi;
      if (node.hi > 0) nodes.push_back(node);
    }
  }
  complete_levels(mapped);
  if (mapped.levels.back().empty()) {
    Pyramid nothing;
    nothing.look_up = pyramid.look_up;
    return nothing;
  }
  mapped.scale = mapped.levels.back().front().hi;
  shrink_support(mapped);
  return mapped;
}

std::vector<std::vector<std::uint32_t>> links_of(
    const Pyramid& mapped, const Pyramid& pyramid,
    const std::vector<std::vector<std::uint32_t>>& links) {
  std::vector<std::vector<std::uint32_t>> kept(mapped.levels.size());
  for (std::size_t level = 0; level < mapped.levels.size(); ++level) {
    for (const PyramidNode& node : mapped.levels[level]) {
      const auto at = find(pyramid.levels[level], node.code);
      kept[level].push_back(at ? links[level][*at] : 0);
    }
  }
  return kept;
}

}  // namespace pvol
