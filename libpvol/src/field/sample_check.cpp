#include "field/sample_check.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <tuple>

#include "density/sample_range.h"
#include "pvol/error.h"

namespace pvol::detail {

void SampleCheck::add(std::size_t level, const PyramidNode& node, float lo, float hi) {
  if (node.lo <= lo && hi <= node.hi) return;
  const double factor = std::max(1.0, double(hi) / double(node.hi));
  const Box cube = cube_of(level, node);
  if (!(most_excess_ > 1 && factor <= most_excess_)) fail(cube, node, lo, hi);
  const std::scoped_lock lock(mutex_);
  ++excess_.nodes;
  // Among equals the lowest place, whatever the order of threads.
  const auto before = [](Vec3d a, Vec3d b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  if (excess_.worst.empty() || factor > excess_.factor ||
      (factor == excess_.factor && before(cube.lo, excess_.worst.lo))) {
    excess_.factor = factor;
    excess_.worst = cube;
  }
}

void SampleCheck::add(std::size_t level, const PyramidNode& node, const float* samples, int count) {
  const SampleRange range(samples, count);
  add(level, node, range.lo(), range.hi());
}

Box SampleCheck::cube_of(std::size_t level, const PyramidNode& node) const {
  const std::int64_t edge = std::int64_t(kLeafEdge) << level;
  const Vec3l lo = pyramid_.origin + Vec3l(morton_decode(node.code)) * edge;
  return {Vec3d(lo), Vec3d(lo + Vec3l(edge))};
}

void SampleCheck::fail(const Box& cube, const PyramidNode& node, float lo, float hi) const {
  const auto range = [](float a, float b) {
    char text[64];
    std::snprintf(text, sizeof text, "[%.6g, %.6g]", double(a), double(b));
    return std::string(text);
  };
  const auto at = [](double v) { return std::to_string(std::int64_t(v)); };
  std::string message = "the bounds do not hold: the cube of ";
  message += at(cube.hi.x - cube.lo.x) + "^3 voxels at (" + at(cube.lo.x) + ", " + at(cube.lo.y) +
             ", " + at(cube.lo.z) + ") has bounds " + range(node.lo, node.hi) +
             ", but its samples lie in " + range(lo, hi) +
             ". They belong to another density or were damaged; fit the cloud again.";
  if (most_excess_ > 1) {
    message += " (Weighted trackers are correct up to a factor of " + std::to_string(most_excess_) +
               " only.)";
  }
  throw Error(message);
}

void check_support(const VoxelGrid& grid, const Pyramid& pyramid, LookUp look_up) {
  const KernelExtent extent = extent_of(look_up);
  const Vec3l first = pyramid.support_lo + Vec3l(extent.above);
  const Vec3l last = pyramid.support_hi - Vec3l(extent.below + 1);
  const auto inside = [&](Vec3l lo, Vec3l hi) {
    return min(lo, first) == first && max(hi, last) == last;
  };
  const auto require = [&](bool holds) {
    if (holds) return;
    throw Error(
        "the bounds do not hold: there is density outside their box. They belong to another "
        "density or were damaged; fit the cloud again.");
  };
  for (const Tile& t : grid.tiles) {
    require(t.value == 0 || inside(Vec3l(t.origin), Vec3l(t.origin) + Vec3l(t.edge - 1)));
  }
  for (const Brick& b : grid.bricks) {
    const Vec3l lo(b.origin);
    if (inside(lo, lo + Vec3l(kBrickEdge - 1))) continue;
    for (int i = 0; i < kBrickSamples; ++i) {
      const Vec3l at = lo + Vec3l(i >> 6, i >> 3 & 7, i & 7);
      require(b.values[i] == 0 || inside(at, at));
    }
  }
}

}  // namespace pvol::detail
