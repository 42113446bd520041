#include "pvol/density/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "density/array_rows.h"
#include "math/parallel.h"
#include "pvol/error.h"

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

/// Bricks of one x, found by one task.
struct Slab {
  std::vector<Vec3i> origins;
  std::vector<float> samples;
};

Slab fill_slab(Vec3i lo, Vec3i hi, const FillBrick& fill) {
  Slab slab;
  for (std::int32_t y = lo.y; y < hi.y; y += kBrickEdge) {
    for (std::int32_t z = lo.z; z < hi.z; z += kBrickEdge) {
      throw_if_cancelled();
      const Vec3i origin(lo.x, y, z);
      const std::size_t before = slab.samples.size();
      slab.samples.resize(before + kBrickSamples);
      fill(origin, slab.samples.data() + before);
      if (holds_density(origin, slab.samples.data() + before)) {
        slab.origins.push_back(origin);
      } else {
        slab.samples.resize(before);
      }
    }
  }
  slab.samples.shrink_to_fit();
  return slab;
}

}  // namespace

VoxelGrid make_grid(Vec3i lo, Vec3i hi, const FillBrick& fill, const Affine& index_to_world) {
  check_range(Vec3l(lo), Vec3l(hi));
  for (int axis = 0; axis < 3; ++axis) lo[axis] &= -kBrickEdge;
  const std::int64_t width = std::int64_t(hi.x) - lo.x;
  const auto slabs = std::make_shared<std::vector<Slab>>(std::size_t((width - 1) / kBrickEdge + 1));
  parallel_for(0, slabs->size(), [&](std::size_t i) {
    const Vec3i at(lo.x + std::int32_t(i) * kBrickEdge, lo.y, lo.z);
    (*slabs)[i] = fill_slab(at, hi, fill);
  });
  VoxelGrid grid;
  grid.index_to_world = index_to_world;
  for (const Slab& slab : *slabs) {
    const float* values = slab.samples.data();
    for (const Vec3i origin : slab.origins) {
      grid.bricks.push_back({origin, values});
      values += kBrickSamples;
    }
  }
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
  return make_grid(array.origin, Vec3i(end), detail::fill_by_rows(begin, end, copy),
                   index_to_world);
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
