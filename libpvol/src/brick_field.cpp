// Copies the samples of each leaf, with its apron, out of the grid.
#include "pvol/medium/brick_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>

#include "lattice_index.h"
#include "pvol/error.h"

namespace pvol {
namespace {

/// The samples that interpolation in the leaf at `origin`, a multiple of 8, reads.
void gather(const detail::BlockFinder& blocks, Vec3i origin, Interpolation interpolation,
            float* out) {
  const KernelReach reach = reach_of(interpolation);
  const int edge = field_edge(interpolation);
  const auto copy = [&](const detail::BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
    const Vec3i first = to + Vec3i(reach.below);
    for (int i = 0; i < count.x; ++i) {
      for (int j = 0; j < count.y; ++j) {
        float* row = out + ((first.x + i) * edge + first.y + j) * edge + first.z;
        if (b.values) {
          const float* source = b.values + ((from.x + i) * 8 + from.y + j) * 8 + from.z;
          std::memcpy(row, source, std::size_t(count.z) * sizeof(float));
        } else {
          std::fill_n(row, count.z, b.constant);
        }
      }
    }
  };
  detail::for_blocks_in_reach(blocks, origin, reach, copy);
}

/// Refuses bounds that do not bound: every picture made with them would be wrong.
void check_bounds(const PyramidNode& leaf, float lo, float hi) {
  if (leaf.lo <= lo && hi <= leaf.hi) return;
  const auto range = [](float a, float b) {
    return "[" + std::to_string(a) + ", " + std::to_string(b) + "]";
  };
  throw Error("the bounds do not hold: leaf " + std::to_string(leaf.code) + " says " +
              range(leaf.lo, leaf.hi) + ", its samples lie in " + range(lo, hi) +
              ". They belong to another density or were damaged; fit the cloud again.");
}

void check_bounds(const PyramidNode& leaf, const float* samples, int count) {
  float lo = samples[0], hi = samples[0];
  for (int i = 1; i < count; ++i) {
    lo = std::min(lo, samples[i]);
    hi = std::max(hi, samples[i]);
  }
  check_bounds(leaf, lo, hi);
}

/// Refuses density outside the support's box, at which walks end.
void check_support(const VoxelGrid& grid, const Pyramid& pyramid, Interpolation interpolation) {
  const KernelReach reach = reach_of(interpolation);
  const Vec3l first = pyramid.support_lo + Vec3l(reach.above);
  const Vec3l last = pyramid.support_hi - Vec3l(reach.below + 1);
  const auto inside = [&](Vec3l lo, Vec3l hi) {
    return min(lo, first) == first && max(hi, last) == last;
  };
  const auto require = [&](bool holds) {
    if (holds) return;
    throw Error(
        "the bounds do not hold: there is density outside the box that they name. They belong to "
        "another density or were damaged; fit the cloud again.");
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

/// Whether a leaf may hold one value: its bounds, rounded outward, differ by one step of their
/// code.
bool nearly_equal_bounds(const PyramidNode& leaf) { return leaf.lo >= leaf.hi * (1 - 0x1p-10f); }

/// Bricks of one value, made on demand and shared.
class ConstantBricks {
 public:
  explicit ConstantBricks(BrickField& field) : field_(field) { (void)brick(0); }

  std::uint32_t brick(float value) {
    const auto [at, fresh] = index_.try_emplace(value, std::uint32_t(field_.bricks()));
    const auto count = std::size_t(field_samples(field_.interpolation));
    if (fresh) field_.samples.insert(field_.samples.end(), count, value);
    return at->second;
  }

 private:
  BrickField& field_;
  std::map<float, std::uint32_t> index_;
};

}  // namespace

FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid,
                           Interpolation interpolation) {
  check_support(grid, pyramid, interpolation);
  FieldWithLinks r;
  if (interpolation == Interpolation::tricubic) r.field.interpolation = interpolation;
  const int count = field_samples(interpolation);
  ConstantBricks constant(r.field);
  const detail::BlockFinder blocks(grid);
  const auto origin_of = [&](std::size_t level, std::uint64_t code) {
    return Vec3i(pyramid.origin + Vec3l(morton_decode(code)) * (std::int64_t(kLeafEdge) << level));
  };

  r.brick_of.resize(pyramid.levels.size());
  for (std::size_t level = 1; level < pyramid.levels.size(); ++level) {
    const auto& nodes = pyramid.levels[level];
    r.brick_of[level].resize(nodes.size(), kZeroBrick);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!is_uniform(pyramid, level, i)) continue;
      const detail::BlockSource b = blocks.find(origin_of(level, nodes[i].code));
      const float value = b.values ? b.values[0] : b.constant;
      check_bounds(nodes[i], value, value);
      r.brick_of[level][i] = constant.brick(value);
    }
  }
  if (pyramid.empty()) return r;

  // Leaves of one value share its brick; the others get one each, filled in parallel.
  const auto& leaves = pyramid.levels[0];
  auto& brick_of = r.brick_of[0];
  brick_of.resize(leaves.size());
  std::vector<std::size_t> own;
  std::vector<float> samples(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (nearly_equal_bounds(leaves[i])) {
      gather(blocks, origin_of(0, leaves[i].code), interpolation, samples.data());
      if (std::equal(samples.begin() + 1, samples.end(), samples.begin())) {
        brick_of[i] = constant.brick(samples[0]);
        check_bounds(leaves[i], samples.data(), count);
        continue;
      }
    }
    own.push_back(i);
  }
  const std::size_t first = r.field.bricks();
  r.field.samples.resize((first + own.size()) * samples.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, own.size(), 64), [&](const auto& range) {
    for (std::size_t k = range.begin(); k != range.end(); ++k) {
      brick_of[own[k]] = std::uint32_t(first + k);
      float* samples_of_leaf = r.field.samples.data() + (first + k) * samples.size();
      gather(blocks, origin_of(0, leaves[own[k]].code), interpolation, samples_of_leaf);
      check_bounds(leaves[own[k]], samples_of_leaf, count);
    }
  });
  return r;
}

}  // namespace pvol
