#include "pvol/medium/voxel_grid.h"

#include <algorithm>
#include <tuple>

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

}  // namespace

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

}  // namespace pvol
