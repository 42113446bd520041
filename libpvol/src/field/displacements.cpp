#include "pvol/field/displacements.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/digits.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using Range = Displacements::Range;

constexpr float kMostCells = 0x1p20f;

[[nodiscard]] Range join(const Range& a, const Range& b) {
  return {min(a.lo, b.lo), max(a.hi, b.hi)};
}

/// The matrix from velocities to displacements.
[[nodiscard]] Affine to_displacements(const Affine& index_to_world, double seconds) {
  Affine a = inverse(index_to_world);
  for (Vec3d& row : a.m) row = row * seconds;
  a.t = {};
  return a;
}

[[nodiscard]] std::size_t index_of(Vec3i size, Vec3i at) {
  return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
         std::size_t(at.z);
}

/// visit(p) for all of lo <= p <= hi.
template <class Visit>
void for_box(Vec3i lo, Vec3i hi, const Visit& visit) {
  for (Vec3i p = lo; p.x <= hi.x; ++p.x) {
    for (p.y = lo.y; p.y <= hi.y; ++p.y) {
      for (p.z = lo.z; p.z <= hi.z; ++p.z) visit(p);
    }
  }
}

/// Over samples lo to hi of a brick, both included.
[[nodiscard]] Range range_in(const Float4* brick, Vec3i lo, Vec3i hi) {
  constexpr int kEdge = VectorBricks::kEdge;
  Range r{brick[(lo.x * kEdge + lo.y) * kEdge + lo.z], brick[(lo.x * kEdge + lo.y) * kEdge + lo.z]};
  for_box(lo, hi, [&](Vec3i p) {
    const Float4 v = brick[(p.x * kEdge + p.y) * kEdge + p.z];
    r = join(r, {v, v});
  });
  return r;
}

void add_levels(Displacements& d) {
  const VectorBricks& bricks = d.bricks;
  Displacements::Level leaves{bricks.leaves, {}};
  std::vector<Range> by_brick(bricks.samples.size() / VectorBricks::kSamples);
  parallel_for(0, by_brick.size(), [&](std::size_t b) {
    by_brick[b] = range_in(bricks.brick(std::uint32_t(b)), Vec3i(0), Vec3i(8));
  });
  for (const std::uint32_t b : bricks.brick_of) leaves.cubes.push_back(by_brick[b]);
  d.levels.push_back(std::move(leaves));
  while (d.levels.back().cubes.size() > 1) {
    const Displacements::Level& below = d.levels.back();
    Displacements::Level above{(below.size + Vec3i(1)) / 2, {}};
    above.cubes.reserve(std::size_t(above.size.x) * std::size_t(above.size.y) *
                        std::size_t(above.size.z));
    for_box(Vec3i(0), above.size - Vec3i(1), [&](Vec3i p) {
      Range r = below.cubes[index_of(below.size, p * 2)];
      for_box(p * 2, min(p * 2 + Vec3i(1), below.size - Vec3i(1)),
              [&](Vec3i child) { r = join(r, below.cubes[index_of(below.size, child)]); });
      above.cubes.push_back(r);
    });
    d.levels.push_back(std::move(above));
  }
  const Range all = d.levels.back().cubes.front();
  const Float4 most = max(all.hi, -all.lo);
  d.largest = std::max({most[0], most[1], most[2]});
}

[[nodiscard]] Vec3i floor_of(Vec3d v) {
  return {int(std::floor(v.x)), int(std::floor(v.y)), int(std::floor(v.z))};
}

}  // namespace

Displacements make_displacements(const VelocityGrid& velocity, const Affine& index_to_world,
                                 double seconds) {
  Displacements d;
  const std::array grids{&velocity.along[0], &velocity.along[1], &velocity.along[2]};
  const LeafBox box = leaf_box(grids);
  if (box.empty() || seconds == 0) return d;
  if (box.count() > kMostVectorLeaves) {
    throw Error(
        "the box of the velocities has more than 2^24 leaves of 8^3 voxels; resample them to "
        "larger voxels, which motion blur hides");
  }
  d.index_to_cells = translation(-Vec3d(box.lo * kBrickEdge)) * inverse(velocity.index_to_world()) *
                     index_to_world;
  const Affine map = to_displacements(index_to_world, seconds);
  d.bricks = make_vector_bricks(grids, box,
                                [&](Float4 v) { return widen(Vec3f(map.vector(Vec3d(vec3(v))))); });
  add_levels(d);
  if (!(d.largest <= kMostCells)) {
    throw Error("the medium moves by up to " + detail::digits(double(d.largest)) +
                " voxels a frame, expected at most 2^20. Velocities are in world units per second: "
                "check their scale, and the camera's fps");
  }
  return d;
}

Range range_over(const Displacements& d, const Box& index) {
  // Places round: what lies at a face may be looked up in the cell on its other side.
  constexpr double kRounding = 1e-6;
  Range r;
  bool any = false;
  const auto add = [&](const Range& more) {
    r = any ? join(r, more) : more;
    any = true;
  };
  if (d.levels.empty()) return r;
  const Box cells = transform(d.index_to_cells, index);
  const Vec3d end = Vec3d(d.bricks.leaves) * 8.0;
  const Vec3d lo = cells.lo - Vec3d(kRounding), hi = cells.hi + Vec3d(kRounding);
  if (min(lo, Vec3d(0)) != Vec3d(0) || max(hi, end) != end) add({});  // reaches outside
  const Vec3d first = max(lo, Vec3d(0)), last = min(hi, end - Vec3d(kRounding));
  if (first.x > last.x || first.y > last.y || first.z > last.z) return r;
  const Vec3i from = floor_of(first), to = floor_of(last);
  const Vec3i extent = to - from;
  if (std::max({extent.x, extent.y, extent.z}) <= 2 * kBrickEdge) {
    const Vec3i leaf_lo(from.x >> 3, from.y >> 3, from.z >> 3);
    for_box(leaf_lo, Vec3i(to.x >> 3, to.y >> 3, to.z >> 3), [&](Vec3i leaf) {
      const Vec3i origin = leaf * kBrickEdge;
      add(range_in(d.bricks.brick(d.bricks.brick_at(leaf)), max(from - origin, Vec3i(0)),
                   min(to - origin, Vec3i(7)) + Vec3i(1)));
    });
    return r;
  }
  std::size_t level = 0;
  while (level + 1 < d.levels.size() &&
         std::max({extent.x, extent.y, extent.z}) >> (3 + level) > 2) {
    ++level;
  }
  const auto cube_of = [&](Vec3i cell) {
    const int shift = 3 + int(level);
    return Vec3i(cell.x >> shift, cell.y >> shift, cell.z >> shift);
  };
  for_box(cube_of(from), cube_of(to),
          [&](Vec3i cube) { add(d.levels[level].cubes[index_of(d.levels[level].size, cube)]); });
  return r;
}

}  // namespace pvol
