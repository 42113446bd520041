#include "density/check_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

[[nodiscard]] std::string place(Vec3i v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

void check_values(const Brick& brick) {
  if (brick.values == nullptr)
    throw Error("the leaf at " + place(brick.origin) + " has no samples");
  for (int i = 0; i < kBrickSamples; ++i) {
    const float v = brick.values[i];
    if (v >= 0 && std::isfinite(v)) continue;
    throw Error("sample " + place(brick.origin + Vec3i(i >> 6, i >> 3 & 7, i & 7)) + " is " +
                std::to_string(v) +
                "; expected a finite number of at least 0. Clean the field first.");
  }
}

void check_origin(Vec3i origin, std::int32_t edge) {
  if (((origin.x | origin.y | origin.z) & (edge - 1)) == 0) return;
  throw Error("a cube of " + std::to_string(edge) + "^3 samples lies at " + place(origin) +
              "; expected an origin that is a multiple of the edge along each axis");
}

void check_tile(const Tile& t) {
  if (t.edge != 8 && t.edge != 128 && t.edge != 4096) {
    throw Error("a tile has an edge of " + std::to_string(t.edge) + "; expected 8, 128 or 4096");
  }
  check_origin(t.origin, t.edge);
  if (!(t.value >= 0 && std::isfinite(t.value))) {
    throw Error("the tile at " + place(t.origin) + " has the value " + std::to_string(t.value) +
                "; expected a finite number of at least 0");
  }
}

using Origin = std::array<std::int32_t, 3>;
/// Tiles by what they cover.
using Tiles = std::set<std::array<std::int32_t, 4>>;

[[noreturn]] void refuse_overlap(Vec3i origin, std::int32_t edge, Vec3i other, std::int32_t its) {
  throw Error("a cube of " + std::to_string(edge) + "^3 samples at " + place(origin) +
              " overlaps one of " + std::to_string(its) + "^3 at " + place(other) +
              "; expected cubes that are disjoint");
}

void check_outside(const Tiles& tiles, Vec3i origin, std::int32_t edge) {
  for (const std::int32_t its : {4096, 128, 8}) {
    const Vec3i around(origin.x & -its, origin.y & -its, origin.z & -its);
    if (its >= edge && tiles.contains({around.x, around.y, around.z, its})) {
      refuse_overlap(origin, edge, around, its);
    }
  }
}

}  // namespace

void check_cubes(const VoxelGrid& grid) {
  constexpr std::size_t kGrain = 64;  // bricks of a task
  parallel_parts(0, grid.bricks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      check_origin(grid.bricks[i].origin, kBrickEdge);
      check_values(grid.bricks[i]);
    }
  });
  for (const Tile& t : grid.tiles) check_tile(t);
}

void check_disjoint(const VoxelGrid& grid) {
  Tiles tiles;
  for (const std::int32_t edge : {4096, 128, 8}) {
    for (const Tile& t : grid.tiles) {
      if (t.edge != edge) continue;
      check_outside(tiles, t.origin, edge);
      tiles.insert({t.origin.x, t.origin.y, t.origin.z, edge});
    }
  }
  std::vector<Origin> origins;
  for (const Brick& b : grid.bricks) {
    if (!tiles.empty()) check_outside(tiles, b.origin, kBrickEdge);
    origins.push_back({b.origin.x, b.origin.y, b.origin.z});
  }
  std::sort(origins.begin(), origins.end());
  const auto same = std::adjacent_find(origins.begin(), origins.end());
  if (same == origins.end()) return;
  const Vec3i origin((*same)[0], (*same)[1], (*same)[2]);
  refuse_overlap(origin, kBrickEdge, origin, kBrickEdge);
}

}  // namespace pvol::detail
