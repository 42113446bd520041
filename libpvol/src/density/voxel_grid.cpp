#include "pvol/density/voxel_grid.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <random>
#include <tuple>

#include "density/array_rows.h"
#include "math/memory.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {

namespace {

// 64-bit differences: a tile may end at the last 32-bit coordinate.
bool holds(Vec3i origin, std::int64_t edge, Vec3i at) {
  const Vec3l d = Vec3l(at) - Vec3l(origin);
  return d.x >= 0 && d.y >= 0 && d.z >= 0 && d.x < edge && d.y < edge && d.z < edge;
}

constexpr auto kByOrigin = [](const auto& a, const auto& b) {
  return std::tie(a.origin.x, a.origin.y, a.origin.z) <
         std::tie(b.origin.x, b.origin.y, b.origin.z);
};

std::string text(Vec3i v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

void check_range(Vec3l lo, Vec3l hi) {
  constexpr std::int64_t kFarthest = std::int64_t(1) << 30;
  if (min_component(hi - lo) < 1) {
    throw Error(
        "the density has no samples; expected a size of at least 1 along each axis. Check the "
        "order of the corners, or the array's size.");
  }
  if (min_component(lo) < -kFarthest || max_component(hi) > kFarthest) {
    throw Error(
        "the density has lattice points beyond +-2^30; move it towards the origin of its index "
        "space, and adapt its map to the world.");
  }
}

/// Whether the brick holds anything; refuses what no density can be.
bool holds_density(Vec3i origin, const float* values) {
  bool any = false;
  for (int i = 0; i < kBrickSamples; ++i) {
    if (!(values[i] >= 0 && std::isfinite(values[i]))) {
      constexpr int e = kBrickEdge;
      throw Error("sample " + text(origin + Vec3i(i / (e * e), i / e % e, i % e)) +
                  " of the density is " + std::to_string(values[i]) +
                  "; expected a finite number of at least 0. Clean the density first.");
    }
    any |= values[i] > 0;
  }
  return any;
}

/// Bytes that a brick takes in a grid.
constexpr double kBrickBytes = kBrickSamples * sizeof(float) + sizeof(Brick) + sizeof(Vec3i);

/// Counts the bricks of a grid that is made, and refuses what there is no room for.
class Room {
 public:
  void take(std::size_t bricks) {
    const std::uint64_t all = bricks_.fetch_add(bricks, std::memory_order_relaxed) + bricks;
    if (double(all) * kBrickBytes > double(free_)) refuse();
  }
  [[noreturn]] void refuse() const {
    const double taken = double(bricks_.load()) * kBrickBytes;
    detail::refuse_memory("the density", std::max(taken, double(free_)), free_);
  }

 private:
  std::uint64_t free_ = detail::free_memory();
  std::atomic<std::uint64_t> bricks_ = 0;
};

/// Bricks of one x, found by one task.
class Slab {
 public:
  void fill(Vec3i lo, Vec3i hi, const FillBrick& fill, Room& room);

  [[nodiscard]] std::size_t size() const { return origins_.size(); }
  void add_to(VoxelGrid& grid) const {
    std::size_t i = 0;
    for (const std::vector<float>& chunk : chunks_) {
      for (std::size_t at = 0; at < chunk.size(); at += kBrickSamples) {
        grid.bricks.push_back({origins_[i++], chunk.data() + at});
      }
    }
  }

 private:
  std::vector<Vec3i> origins_;
  std::vector<std::vector<float>> chunks_;  ///< of samples, which stay where they are

  /// Room for one brick more, of zeros.
  float* extend(Room& room) {
    constexpr std::size_t kFewest = 8 * kBrickSamples, kMost = 512 * kBrickSamples;
    if (chunks_.empty()) chunks_.emplace_back().reserve(kFewest);
    if (const std::size_t full = chunks_.back().size(); full == chunks_.back().capacity()) {
      room.take(full / kBrickSamples);
      chunks_.emplace_back().reserve(std::min(2 * full, kMost));
    }
    std::vector<float>& chunk = chunks_.back();
    chunk.resize(chunk.size() + kBrickSamples);
    return chunk.data() + chunk.size() - kBrickSamples;
  }
  void drop_last() { chunks_.back().resize(chunks_.back().size() - kBrickSamples); }
};

void Slab::fill(Vec3i lo, Vec3i hi, const FillBrick& fill, Room& room) {
  for (std::int32_t y = lo.y; y < hi.y; y += kBrickEdge) {
    for (std::int32_t z = lo.z; z < hi.z; z += kBrickEdge) {
      throw_if_cancelled();
      const Vec3i origin(lo.x, y, z);
      float* const values = extend(room);
      fill(origin, values);
      if (holds_density(origin, values)) {
        origins_.push_back(origin);
      } else {
        drop_last();
      }
    }
  }
  if (!chunks_.empty()) chunks_.back().shrink_to_fit();
}

}  // namespace

void detail::require_grid_memory(Vec3l lo, Vec3l hi, const FillBrick& fill) {
  const Vec3l count = count_bricks(lo, hi);
  const double bricks = double(count.x) * double(count.y) * double(count.z);
  const std::uint64_t free = free_memory();
  if (bricks * kBrickBytes <= double(free)) return;
  // Some bricks by chance, the same each time.
  constexpr int kProbes = 512;
  std::mt19937_64 numbers(1);
  std::array<float, kBrickSamples> values;
  int occupied = 0;
  for (int i = 0; i < kProbes; ++i) {
    Vec3i origin;
    for (int axis = 0; axis < 3; ++axis) {
      const auto brick = std::int64_t(numbers() % std::uint64_t(count[axis]));
      origin[axis] = std::int32_t((lo[axis] & -kBrickEdge) + brick * kBrickEdge);
    }
    values.fill(0);
    fill(origin, values.data());
    occupied += holds_density(origin, values.data());
  }
  // The share of all, by five standard errors less.
  const double share = double(occupied) / kProbes;
  const double least = share - 5 * std::sqrt(share * (1 - share) / kProbes) - 12.0 / kProbes;
  if (least * bricks * kBrickBytes > double(free)) {
    refuse_memory("the density", least * bricks * kBrickBytes, free);
  }
}

VoxelGrid make_grid(Vec3i lo, Vec3i hi, const FillBrick& fill, const Affine& index_to_world) {
  check_range(Vec3l(lo), Vec3l(hi));
  for (int axis = 0; axis < 3; ++axis) lo[axis] &= -kBrickEdge;
  const std::int64_t width = std::int64_t(hi.x) - lo.x;
  const auto slabs = std::make_shared<std::vector<Slab>>(std::size_t((width - 1) / kBrickEdge + 1));
  Room room;
  try {
    parallel_for(0, slabs->size(), [&](std::size_t i) {
      const Vec3i at(lo.x + std::int32_t(i) * kBrickEdge, lo.y, lo.z);
      (*slabs)[i].fill(at, hi, fill, room);
    });
  } catch (const std::bad_alloc&) {
    room.refuse();
  }
  VoxelGrid grid;
  grid.index_to_world = index_to_world;
  std::size_t bricks = 0;
  for (const Slab& slab : *slabs) bricks += slab.size();
  grid.bricks.reserve(bricks);
  for (const Slab& slab : *slabs) slab.add_to(grid);
  grid.owner = slabs;
  return grid;
}

VoxelGrid make_grid(const DenseArray& array, const Affine& index_to_world) {
  const Vec3l size(array.size), begin(array.origin), end = begin + size;
  check_range(begin, end);
  if (array.values == nullptr) throw Error("the address of the array of densities is null");
  const Vec3l stride = detail::stride_of(array);
  const auto copy = [&](Vec3l at, float* to, std::int64_t count) {
    const float* const from = array.values + dot(at - begin, stride);
    for (std::int64_t k = 0; k < count; ++k) to[k] = from[k * stride.z];
  };
  const FillBrick fill = detail::fill_by_rows(begin, end, copy);
  detail::require_grid_memory(begin, end, fill);
  return make_grid(array.origin, Vec3i(end), fill, index_to_world);
}

float sample(const VoxelGrid& grid, Vec3i at) {
  for (const Brick& b : grid.bricks) {
    if (!holds(b.origin, kBrickEdge, at)) continue;
    const Vec3i p = at - b.origin;
    return b.values[(p.x * kBrickEdge + p.y) * kBrickEdge + p.z];
  }
  for (const Tile& t : grid.tiles) {
    if (holds(t.origin, t.edge, at)) return t.value;
  }
  return 0;
}

void sort(VoxelGrid& grid) {
  std::sort(grid.bricks.begin(), grid.bricks.end(), kByOrigin);
  std::sort(grid.tiles.begin(), grid.tiles.end(), kByOrigin);
}

VoxelGrid occupied(const VoxelGrid& grid) {
  VoxelGrid g = grid;
  std::erase_if(g.bricks, [](const Brick& b) {
    return std::all_of(b.values, b.values + kBrickSamples, [](float v) { return v == 0; });
  });
  std::erase_if(g.tiles, [](const Tile& t) { return t.value == 0; });
  sort(g);
  return g;
}

}  // namespace pvol
