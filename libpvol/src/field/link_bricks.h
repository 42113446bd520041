// Gives every leaf and uniform cube of a pyramid its brick, wherever samples are kept.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "density/lattice_index.h"
#include "density/sample_range.h"
#include "field/brick_codes.h"
#include "field/brick_samples.h"
#include "field/gather.h"
#include "field/sample_check.h"
#include "pvol/field/brick_field.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {

/// Samples of the widest brick.
inline constexpr int kMostFieldSamples = field_samples(LookUp::tricubic);

// A Keeper keeps bricks, counted from 0. extend(n) makes n more and returns the first; fill(b,
// value) gives brick b this value everywhere; fill(b, origin, scratch), from any thread, makes it
// that of the leaf at `origin` and returns its samples, which it may write to `scratch`.

/// Bricks of one value, made on demand.
template <class Keeper>
class ConstantBricks {
 public:
  explicit ConstantBricks(Keeper& keeper) : keeper_(keeper) { (void)brick(0); }

  std::uint32_t brick(float value) {
    const auto [at, fresh] = index_.try_emplace(value);
    if (fresh) {
      at->second = keeper_.extend(1);
      keeper_.fill(at->second, value);
    }
    return at->second;
  }

 private:
  Keeper& keeper_;
  std::map<float, std::uint32_t> index_;
};

/// Bricks of leaves at the faces of tiles, where all samples come from tiles and empty space: equal
/// ones, which huge tiles have millions of, are made once.
template <class Keeper>
class TileBricks {
 public:
  TileBricks(const BlockFinder& blocks, LookUp look_up, Keeper& keeper)
      : blocks_(blocks), look_up_(look_up), keeper_(keeper) {}

  struct Made {
    std::uint32_t brick;
    float lo, hi;  ///< of its samples
  };

  /// Nothing where some of the samples are a brick's own.
  [[nodiscard]] std::optional<Made> find(Vec3i leaf) {
    if (blocks_.find(leaf).values != nullptr) return std::nullopt;
    key_.clear();
    bool plain = true;
    for_blocks_in_extent(blocks_, leaf, extent_of(look_up_),
                         [&](const BlockSource& b, Vec3i, Vec3i, Vec3i) {
                           plain = plain && b.values == nullptr;
                           key_.push_back(b.constant);
                         });
    if (!plain) return std::nullopt;
    const auto [at, fresh] = made_.try_emplace(key_);
    if (fresh) {
      at->second.brick = keeper_.extend(1);
      std::array<float, kMostFieldSamples> scratch;
      const float* const samples = keeper_.fill(at->second.brick, leaf, scratch.data());
      const SampleRange range(samples, field_samples(look_up_));
      at->second.lo = range.lo(), at->second.hi = range.hi();
    }
    return at->second;
  }

 private:
  const BlockFinder& blocks_;
  LookUp look_up_;
  Keeper& keeper_;
  std::vector<float> key_;
  std::map<std::vector<float>, Made> made_;
};

/// Whether a leaf may hold one value: its bounds, rounded outward, differ by one step of their
/// code.
[[nodiscard]] inline bool nearly_equal_bounds(const PyramidNode& leaf) {
  return leaf.lo >= leaf.hi * (1 - 0x1p-10f);
}

/// Writes the codes of a brick with these samples.
inline void code_brick(SampleCodes& codes, std::uint32_t b, const float* samples) {
  codes.scales[b] = code_samples(samples, codes.of_brick(b));
}

/// Room for the codes of all bricks, and those of the first ones.
template <class Field>
[[nodiscard]] std::shared_ptr<SampleCodes> code_first_bricks(const Field& field,
                                                             std::uint32_t count) {
  auto codes = std::make_shared<SampleCodes>();
  codes->resize(field.bricks());
  std::array<float, kFieldSamples> scratch;
  for (std::uint32_t b = 0; b < count; ++b) {
    code_brick(*codes, b, samples_of(field, b, scratch.data()));
  }
  return codes;
}

/// Fills `brick_of`, `excess` and `codes` of a field whose bricks `keeper` keeps. Throws Error as
/// build_field.
template <class Keeper, class Field>
void link_bricks(const BlockFinder& blocks, bool has_tiles, const Pyramid& pyramid,
                 const FieldOptions& options, Keeper& keeper, WithLinks<Field>& r) {
  const LookUp look_up = options.look_up;
  const int count = field_samples(look_up);
  ConstantBricks<Keeper> constant(keeper);
  SampleCheck check(pyramid, options.most_excess);
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
      const BlockSource b = blocks.find(origin_of(pyramid, level, nodes[i].code));
      const float value = b.values ? b.values[0] : b.constant;
      check.add(level, nodes[i], value, value);
      r.brick_of[level][i] = constant.brick(value);
    }
  }
  if (pyramid.empty()) return;

  // Leaves of one value share its brick; the others get one each, filled in parallel.
  const auto& leaves = pyramid.levels[0];
  auto& brick_of = r.brick_of[0];
  brick_of.resize(leaves.size());
  std::vector<std::size_t> rest;
  std::array<float, kMostFieldSamples> samples;
  TileBricks<Keeper> of_tiles(blocks, look_up, keeper);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Vec3i origin = origin_of(pyramid, 0, leaves[i].code);
    if (is_constant(0, i)) {
      brick_of[i] = constant.brick(leaves[i].lo);
      continue;
    }
    if (nearly_equal_bounds(leaves[i])) {
      gather(blocks, origin, look_up, samples.data());
      if (std::equal(samples.begin() + 1, samples.begin() + count, samples.begin())) {
        brick_of[i] = constant.brick(samples[0]);
        check.add(0, leaves[i], samples.data(), count);
        continue;
      }
    }
    if (has_tiles) {
      if (const auto made = of_tiles.find(origin)) {
        brick_of[i] = made->brick;
        check.add(0, leaves[i], made->lo, made->hi);
        continue;
      }
    }
    rest.push_back(i);
  }
  const std::uint32_t first = keeper.extend(rest.size());
  const std::shared_ptr<SampleCodes> codes =
      options.codes ? code_first_bricks(r.field, first) : nullptr;
  r.codes = codes;
  parallel_parts(0, rest.size(), 64, [&](std::size_t begin, std::size_t end) {
    std::array<float, kMostFieldSamples> scratch;
    for (std::size_t k = begin; k != end; ++k) {
      const PyramidNode& leaf = leaves[rest[k]];
      brick_of[rest[k]] = first + std::uint32_t(k);
      const float* const of_leaf =
          keeper.fill(brick_of[rest[k]], origin_of(pyramid, 0, leaf.code), scratch.data());
      check.add(0, leaf, of_leaf, count);
      if (codes != nullptr) code_brick(*codes, brick_of[rest[k]], of_leaf);
    }
  });
  r.excess = check.excess();
}

}  // namespace pvol::detail
