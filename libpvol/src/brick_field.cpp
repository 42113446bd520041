// Copies the samples of each leaf, with its apron, out of the grid.
#include "pvol/medium/brick_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <string>

#include "lattice_index.h"
#include "pvol/error.h"

namespace pvol {
namespace {

/// 9^3 samples from `origin` up, which is a multiple of 8.
void gather(const detail::BlockFinder& blocks, Vec3i origin, float* out) {
  for (int corner = 0; corner < 8; ++corner) {
    const int far[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const Vec3i offset = Vec3i(far[0], far[1], far[2]) * kLeafEdge;
    const detail::BlockSource b = blocks.find(origin + offset);
    const int ni = far[0] ? 1 : 8, nj = far[1] ? 1 : 8, nk = far[2] ? 1 : 8;
    for (int i = 0; i < ni; ++i) {
      for (int j = 0; j < nj; ++j) {
        float* row = out + ((offset.x + i) * kFieldEdge + offset.y + j) * kFieldEdge + offset.z;
        if (b.values) {
          std::memcpy(row, b.values + (i * 8 + j) * 8, std::size_t(nk) * sizeof(float));
        } else {
          std::fill_n(row, nk, b.constant);
        }
      }
    }
  }
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

void check_bounds(const PyramidNode& leaf, const float* samples) {
  float lo = samples[0], hi = samples[0];
  for (int i = 1; i < kFieldSamples; ++i) {
    lo = std::min(lo, samples[i]);
    hi = std::max(hi, samples[i]);
  }
  check_bounds(leaf, lo, hi);
}

/// Refuses density outside the support's box, at which walks end.
void check_support(const VoxelGrid& grid, const Pyramid& pyramid) {
  const Vec3l first = pyramid.support_lo + Vec3l(1), last = pyramid.support_hi - Vec3l(1);
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
    const auto [at, fresh] =
        index_.try_emplace(value, std::uint32_t(field_.samples.size() / kFieldSamples));
    if (fresh) field_.samples.insert(field_.samples.end(), kFieldSamples, value);
    return at->second;
  }

 private:
  BrickField& field_;
  std::map<float, std::uint32_t> index_;
};

}  // namespace

FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid) {
  check_support(grid, pyramid);
  FieldWithLinks r;
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
  std::array<float, kFieldSamples> samples;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (nearly_equal_bounds(leaves[i])) {
      gather(blocks, origin_of(0, leaves[i].code), samples.data());
      if (std::equal(samples.begin() + 1, samples.end(), samples.begin())) {
        brick_of[i] = constant.brick(samples[0]);
        check_bounds(leaves[i], samples.data());
        continue;
      }
    }
    own.push_back(i);
  }
  const std::size_t first = r.field.samples.size() / kFieldSamples;
  r.field.samples.resize((first + own.size()) * kFieldSamples);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, own.size(), 64), [&](const auto& range) {
    for (std::size_t k = range.begin(); k != range.end(); ++k) {
      brick_of[own[k]] = std::uint32_t(first + k);
      float* samples_of_leaf = r.field.samples.data() + (first + k) * kFieldSamples;
      gather(blocks, origin_of(0, leaves[own[k]].code), samples_of_leaf);
      check_bounds(leaves[own[k]], samples_of_leaf);
    }
  });
  return r;
}

}  // namespace pvol
