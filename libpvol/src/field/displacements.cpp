#include "pvol/field/displacements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "density/lattice_index.h"
#include "math/digits.h"
#include "math/parallel.h"
#include "pvol/error.h"

namespace pvol {
namespace {

using Range = Displacements::Range;
using detail::BlockFinder;
using detail::BlockSource;

constexpr std::uint64_t kMostLeaves = std::uint64_t(1) << 24;
constexpr float kMostCells = 0x1p20f;

[[nodiscard]] Range join(const Range& a, const Range& b) {
  return {min(a.lo, b.lo), max(a.hi, b.hi)};
}

/// The leaves, in units of 8 cells, in which a component may differ from 0: [lo, hi).
struct LeafBox {
  Vec3i lo{1 << 30}, hi{-(1 << 30)};

  void add(Vec3i origin, int edge) {
    // Cells below the first sample have it for a corner.
    lo = min(lo, Vec3i(origin.x >> 3, origin.y >> 3, origin.z >> 3) - Vec3i(1));
    hi = max(hi, Vec3i((origin.x + edge) >> 3, (origin.y + edge) >> 3, (origin.z + edge) >> 3));
  }
  [[nodiscard]] bool empty() const { return lo.x >= hi.x; }
};

[[nodiscard]] LeafBox leaf_box(const VelocityGrid& velocity) {
  LeafBox box;
  for (const VoxelGrid& grid : velocity.along) {
    for (const Brick& b : grid.bricks) box.add(b.origin, kBrickEdge);
    for (const Tile& t : grid.tiles) box.add(t.origin, t.edge);
  }
  return box;
}

/// The matrix from velocities to displacements.
[[nodiscard]] Affine to_displacements(const Affine& index_to_world, double seconds) {
  Affine a = inverse(index_to_world);
  for (Vec3d& row : a.m) row = row * seconds;
  a.t = {};
  return a;
}

/// Fills the bricks of one velocity.
class Builder {
 public:
  Builder(const VelocityGrid& velocity, Affine map, Vec3i first_leaf)
      : blocks_{BlockFinder(velocity.along[0]), BlockFinder(velocity.along[1]),
                BlockFinder(velocity.along[2])},
        map_(map),
        first_(first_leaf) {}

  void fill(Displacements& d) {
    d.samples.assign(Displacements::kSamples, Float4{});
    std::map<std::array<float, 3>, std::uint32_t> constant{{{0, 0, 0}, 0}};
    std::vector<std::size_t> own;
    std::size_t bricks = 1;
    d.brick_of.resize(std::size_t(d.leaves.x) * std::size_t(d.leaves.y) * std::size_t(d.leaves.z));
    for (std::size_t i = 0; i < d.brick_of.size(); ++i) {
      const auto value = constant_in(origin_of(d, i));
      if (!value) {
        own.push_back(i);
        continue;
      }
      const auto [at, fresh] = constant.try_emplace(*value, std::uint32_t(bricks));
      if (fresh) {
        d.samples.insert(d.samples.end(), std::size_t(Displacements::kSamples),
                         displacement(Float4{(*value)[0], (*value)[1], (*value)[2], 0}));
        ++bricks;
      }
      d.brick_of[i] = at->second;
    }
    d.samples.resize((bricks + own.size()) * Displacements::kSamples);
    parallel_parts(0, own.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k != end; ++k) {
        d.brick_of[own[k]] = std::uint32_t(bricks + k);
        gather(origin_of(d, own[k]), d.samples.data() + (bricks + k) * Displacements::kSamples);
      }
    });
  }

 private:
  std::array<BlockFinder, 3> blocks_;
  Affine map_;
  Vec3i first_;

  [[nodiscard]] Vec3i origin_of(const Displacements& d, std::size_t i) const {
    const auto y = std::size_t(d.leaves.y), z = std::size_t(d.leaves.z);
    return (first_ + Vec3i(int(i / z / y), int(i / z % y), int(i % z))) * kBrickEdge;
  }

  [[nodiscard]] Float4 displacement(Float4 v) const {
    return lanes(Vec3f(map_.vector(Vec3d(vec3(v)))));
  }

  /// The one velocity of a leaf where tiles or empty space show it without a look at samples.
  [[nodiscard]] std::optional<std::array<float, 3>> constant_in(Vec3i leaf) const {
    std::array<float, 3> value{};
    for (std::size_t c = 0; c < 3; ++c) {
      value[c] = blocks_[c].find(leaf).constant;
      bool same = true;
      detail::for_blocks_in_reach(blocks_[c], leaf, {0, 1},
                                  [&](const BlockSource& b, Vec3i, Vec3i, Vec3i) {
                                    same &= b.values == nullptr && b.constant == value[c];
                                  });
      if (!same) return std::nullopt;
    }
    return value;
  }

  void gather(Vec3i leaf, Float4* out) const {
    constexpr int kEdge = Displacements::kEdge;
    for (int c = 0; c < 3; ++c) {
      const auto copy = [&](const BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
        for (int i = 0; i < count.x; ++i) {
          for (int j = 0; j < count.y; ++j) {
            for (int k = 0; k < count.z; ++k) {
              const int at = ((from.x + i) * 8 + from.y + j) * 8 + from.z + k;
              out[((to.x + i) * kEdge + to.y + j) * kEdge + to.z + k][c] =
                  b.values ? b.values[at] : b.constant;
            }
          }
        }
      };
      detail::for_blocks_in_reach(blocks_[std::size_t(c)], leaf, {0, 1}, copy);
    }
    for (int i = 0; i < Displacements::kSamples; ++i) out[i] = displacement(out[i]);
  }
};

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
  constexpr int kEdge = Displacements::kEdge;
  Range r{brick[(lo.x * kEdge + lo.y) * kEdge + lo.z], brick[(lo.x * kEdge + lo.y) * kEdge + lo.z]};
  for_box(lo, hi, [&](Vec3i p) {
    const Float4 v = brick[(p.x * kEdge + p.y) * kEdge + p.z];
    r = join(r, {v, v});
  });
  return r;
}

void add_levels(Displacements& d) {
  Displacements::Level leaves{d.leaves, {}};
  std::vector<Range> by_brick(d.samples.size() / Displacements::kSamples);
  parallel_for(0, by_brick.size(), [&](std::size_t b) {
    by_brick[b] = range_in(d.brick(std::uint32_t(b)), Vec3i(0), Vec3i(8));
  });
  for (const std::uint32_t b : d.brick_of) leaves.cubes.push_back(by_brick[b]);
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
  const LeafBox box = leaf_box(velocity);
  if (box.empty() || seconds == 0) return d;
  d.leaves = box.hi - box.lo + Vec3i(1);
  const Vec3d size(d.leaves);
  if (size.x * size.y * size.z > double(kMostLeaves)) {
    throw Error(
        "the box of the velocities has more than 2^24 leaves of 8^3 voxels; resample them "
        "to larger voxels, which motion blur does not show");
  }
  d.index_to_cells = translation(-Vec3d(box.lo * kBrickEdge)) * inverse(velocity.index_to_world()) *
                     index_to_world;
  Builder(velocity, to_displacements(index_to_world, seconds), box.lo).fill(d);
  add_levels(d);
  if (!(d.largest <= kMostCells)) {
    throw Error("matter moves by up to " + detail::digits(double(d.largest)) +
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
  const Vec3d end = Vec3d(d.leaves) * 8.0;
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
      add(range_in(d.brick(d.brick_at(leaf)), max(from - origin, Vec3i(0)),
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
