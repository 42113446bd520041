// Copies the samples of each leaf, with its apron, out of the grid.
#include "pvol/field/brick_field.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>

#include "density/lattice_index.h"
#include "field/gather.h"
#include "math/parallel.h"
#include "pvol/error.h"

namespace pvol {
namespace {

/// Compares bounds with samples and keeps a record of those that do not hold; from any thread.
class BoundsCheck {
 public:
  BoundsCheck(const Pyramid& pyramid, double most_excess)
      : pyramid_(pyramid), most_excess_(most_excess) {}

  /// Refuses what most_excess does not allow: every picture made with it would be wrong.
  void add(std::size_t level, const PyramidNode& node, float lo, float hi) {
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
  void add(std::size_t level, const PyramidNode& node, const float* samples, int count) {
    const auto [lo, hi] = std::minmax_element(samples, samples + count);
    add(level, node, *lo, *hi);
  }
  [[nodiscard]] const BoundsExcess& excess() const { return excess_; }

 private:
  [[nodiscard]] Box cube_of(std::size_t level, const PyramidNode& node) const {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    const Vec3l lo = pyramid_.origin + Vec3l(morton_decode(node.code)) * edge;
    return {Vec3d(lo), Vec3d(lo + Vec3l(edge))};
  }

  [[noreturn]] void fail(const Box& cube, const PyramidNode& node, float lo, float hi) const {
    const auto range = [](float a, float b) {
      char text[64];
      std::snprintf(text, sizeof text, "[%.6g, %.6g]", double(a), double(b));
      return std::string(text);
    };
    const auto at = [](double v) { return std::to_string(std::int64_t(v)); };
    std::string message = "the bounds do not hold: the cube of ";
    message += at(cube.hi.x - cube.lo.x) + "^3 voxels at (" + at(cube.lo.x) + ", " + at(cube.lo.y) +
               ", " + at(cube.lo.z) + ") says " + range(node.lo, node.hi) +
               ", its samples lie in " + range(lo, hi) +
               ". They belong to another density or were damaged; fit the cloud again.";
    if (most_excess_ > 1) {
      message += " (Trackers with weights are right up to a factor of " +
                 std::to_string(most_excess_) + " only.)";
    }
    throw Error(message);
  }

  const Pyramid& pyramid_;
  double most_excess_;
  BoundsExcess excess_;
  std::mutex mutex_;
};

/// Refuses density outside the support's box, at which walks end.
void check_support(const VoxelGrid& grid, const Pyramid& pyramid, LookUp look_up) {
  const KernelReach reach = reach_of(look_up);
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
    const auto count = std::size_t(field_samples(field_.look_up));
    if (fresh) field_.samples.insert(field_.samples.end(), count, value);
    return at->second;
  }

 private:
  BrickField& field_;
  std::map<float, std::uint32_t> index_;
};

/// Bricks of leaves at the faces of tiles, where all samples come from tiles and empty space: equal
/// ones, which huge tiles have millions of, are made once.
class TileBricks {
 public:
  TileBricks(const detail::BlockFinder& blocks, BrickField& field)
      : blocks_(blocks), field_(field) {}

  struct Made {
    std::uint32_t brick;
    float lo, hi;  ///< of its samples
  };

  /// Nothing where some of the samples are a brick's own.
  [[nodiscard]] std::optional<Made> find(Vec3i leaf) {
    if (blocks_.find(leaf).values != nullptr) return std::nullopt;
    key_.clear();
    bool plain = true;
    detail::for_blocks_in_reach(blocks_, leaf, reach_of(field_.look_up),
                                [&](const detail::BlockSource& b, Vec3i, Vec3i, Vec3i) {
                                  plain = plain && b.values == nullptr;
                                  key_.push_back(b.constant);
                                });
    if (!plain) return std::nullopt;
    const auto [at, fresh] = made_.try_emplace(key_);
    if (fresh) {
      const std::size_t first = field_.samples.size(),
                        count = std::size_t(field_samples(field_.look_up));
      at->second.brick = std::uint32_t(field_.bricks());
      field_.samples.resize(first + count);
      detail::gather(blocks_, leaf, field_.look_up, field_.samples.data() + first);
      const auto [lo, hi] =
          std::minmax_element(field_.samples.begin() + std::ptrdiff_t(first), field_.samples.end());
      at->second.lo = *lo, at->second.hi = *hi;
    }
    return at->second;
  }

 private:
  const detail::BlockFinder& blocks_;
  BrickField& field_;
  std::vector<float> key_;
  std::map<std::vector<float>, Made> made_;
};

}  // namespace

void detail::gather(const BlockFinder& blocks, Vec3i origin, LookUp look_up, float* out) {
  const KernelReach reach = reach_of(look_up);
  const int edge = field_edge(look_up);
  const auto copy = [&](const BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
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
  for_blocks_in_reach(blocks, origin, reach, copy);
}

FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid,
                           const FieldOptions& options) {
  const LookUp look_up = options.look_up;
  check_support(grid, pyramid, look_up);
  FieldWithLinks r;
  if (look_up == LookUp::tricubic) r.field.look_up = look_up;
  const int count = field_samples(look_up);
  ConstantBricks constant(r.field);
  BoundsCheck check(pyramid, options.most_excess);
  const detail::BlockFinder blocks(grid);
  const auto origin_of = [&](std::size_t level, std::uint64_t code) {
    return Vec3i(pyramid.origin + Vec3l(morton_decode(code)) * (std::int64_t(kLeafEdge) << level));
  };
  const auto is_constant = [&](std::size_t level, std::size_t i) {
    return options.constant != nullptr && (*options.constant)[level][i] != 0;
  };

  r.brick_of.resize(pyramid.levels.size());
  for (std::size_t level = 1; level < pyramid.levels.size(); ++level) {
    const auto& nodes = pyramid.levels[level];
    r.brick_of[level].resize(nodes.size(), kZeroBrick);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!is_uniform(pyramid, level, i)) continue;
      if (is_constant(level, i)) {
        r.brick_of[level][i] = constant.brick(nodes[i].lo);
        continue;
      }
      const detail::BlockSource b = blocks.find(origin_of(level, nodes[i].code));
      const float value = b.values ? b.values[0] : b.constant;
      check.add(level, nodes[i], value, value);
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
  TileBricks of_tiles(blocks, r.field);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (is_constant(0, i)) {
      brick_of[i] = constant.brick(leaves[i].lo);
      continue;
    }
    if (nearly_equal_bounds(leaves[i])) {
      detail::gather(blocks, origin_of(0, leaves[i].code), look_up, samples.data());
      if (std::equal(samples.begin() + 1, samples.end(), samples.begin())) {
        brick_of[i] = constant.brick(samples[0]);
        check.add(0, leaves[i], samples.data(), count);
        continue;
      }
    }
    if (!grid.tiles.empty()) {
      if (const auto made = of_tiles.find(origin_of(0, leaves[i].code))) {
        brick_of[i] = made->brick;
        check.add(0, leaves[i], made->lo, made->hi);
        continue;
      }
    }
    own.push_back(i);
  }
  const std::size_t first = r.field.bricks();
  r.field.samples.resize((first + own.size()) * samples.size());
  parallel_parts(0, own.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k != end; ++k) {
      brick_of[own[k]] = std::uint32_t(first + k);
      float* samples_of_leaf = r.field.samples.data() + (first + k) * samples.size();
      detail::gather(blocks, origin_of(0, leaves[own[k]].code), look_up, samples_of_leaf);
      check.add(0, leaves[own[k]], samples_of_leaf, count);
    }
  });
  r.excess = check.excess();
  return r;
}

}  // namespace pvol
