// Hash index from lattice points to numbers, for finding the brick or tile at an origin.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/rng.h"

namespace pvol::detail {

/// Open addressing with linear probing; at most half full.
class LatticeIndex {
 public:
  static constexpr std::int32_t kAbsent = -1;

  explicit LatticeIndex(std::size_t capacity)
      : slots_(std::bit_ceil(2 * capacity + 1)), mask_(slots_.size() - 1) {}

  /// `value` must not be negative; the first value of a key stays.
  void insert(Vec3i key, std::int32_t value) {
    Slot& s = slots_[probe(key)];
    if (s.value == kAbsent) s = {key, value};
  }

  /// The value of the key, or kAbsent.
  [[nodiscard]] std::int32_t find(Vec3i key) const { return slots_[probe(key)].value; }

 private:
  struct Slot {
    Vec3i key;
    std::int32_t value = kAbsent;
  };

  [[nodiscard]] std::size_t probe(Vec3i key) const {
    const auto u = [](std::int32_t v) { return std::uint64_t(std::uint32_t(v)); };
    std::size_t i = std::size_t(mix64(mix64(u(key.x) << 32 | u(key.y)) ^ u(key.z))) & mask_;
    while (slots_[i].value != kAbsent && slots_[i].key != key) i = (i + 1) & mask_;
    return i;
  }

  std::vector<Slot> slots_;
  std::size_t mask_;
};

/// Where the samples of an aligned 8^3 block come from.
struct BlockSource {
  const float* values = nullptr;  ///< 512 samples, or null
  float constant = 0;             ///< of the tile, where `values` is null; 0 outside everything
  std::int32_t edge = 0;          ///< of that tile, whose origin is a multiple of it
};

/// Finds the samples of aligned 8^3 blocks in a grid. Keeps a reference to the grid.
class BlockFinder {
 public:
  explicit BlockFinder(const VoxelGrid& grid)
      : grid_(grid), bricks_(grid.bricks.size()), tiles_(grid.tiles.size()) {
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
      bricks_.insert(grid.bricks[i].origin, std::int32_t(i));
    }
    for (std::size_t i = 0; i < grid.tiles.size(); ++i) {
      tiles_.insert(grid.tiles[i].origin, std::int32_t(i));
      edges_ |= std::uint32_t(grid.tiles[i].edge);
    }
  }

  /// `origin` is a multiple of 8 on each axis.
  [[nodiscard]] BlockSource find(Vec3i origin) const {
    if (const auto i = bricks_.find(origin); i != LatticeIndex::kAbsent) {
      return {grid_.bricks[std::size_t(i)].values, 0, 0};
    }
    for (std::uint32_t left = edges_; left != 0; left &= left - 1) {  // each edge that occurs
      const auto edge = std::int32_t(left & (~left + 1));
      const Vec3i at{origin.x & -edge, origin.y & -edge, origin.z & -edge};
      const auto i = tiles_.find(at);
      if (i != LatticeIndex::kAbsent && grid_.tiles[std::size_t(i)].edge == edge) {
        return {nullptr, grid_.tiles[std::size_t(i)].value, edge};
      }
    }
    return {};
  }

 private:
  const VoxelGrid& grid_;
  LatticeIndex bricks_, tiles_;
  std::uint32_t edges_ = 0;  // the tile edges that occur, each a bit
};

/// Calls `f(source, from, count, to)` for each aligned block of samples that interpolation in the
/// leaf at `leaf` reads: its `count` samples from `from` on are those of the leaf from `to` on,
/// where the leaf's cells begin at 0.
template <class F>
void for_blocks_in_extent(const BlockFinder& blocks, Vec3i leaf, KernelExtent reach, const F& f) {
  constexpr int kEdge = kBrickEdge;
  const int from[3] = {kEdge - reach.below, 0, 0}, count[3] = {reach.below, kEdge, reach.above};
  const int first = reach.below > 0 ? -1 : 0;
  for (int z = first; z <= 1; ++z) {
    for (int y = first; y <= 1; ++y) {
      for (int x = first; x <= 1; ++x) {
        const Vec3i start{from[x + 1], from[y + 1], from[z + 1]};
        f(blocks.find(leaf + Vec3i(x, y, z) * kEdge), start,
          Vec3i(count[x + 1], count[y + 1], count[z + 1]), Vec3i(x, y, z) * kEdge + start);
      }
    }
  }
}

}  // namespace pvol::detail
