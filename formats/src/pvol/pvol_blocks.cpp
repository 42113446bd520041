#include "pvol/pvol_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "pvol/bounds/node_index.h"
#include "pvol/density/sample_count.h"
#include "pvol/math/parallel.h"

namespace pvol::formats::detail {
namespace {

constexpr std::int32_t kTileEdges[] = {8, 128, 4096};
constexpr std::size_t kGrain = 1024;  // bricks of a task

bool is_multiple(Vec3i v, std::int32_t of) {
  return v.x % of == 0 && v.y % of == 0 && v.z % of == 0;
}

template <class Block>
bool by_origin(const Block& a, const Block& b) {
  return std::tie(a.origin.x, a.origin.y, a.origin.z) <
         std::tie(b.origin.x, b.origin.y, b.origin.z);
}

/// Whether the pyramid has a leaf, or a uniform cube around it, at this sample block.
bool is_covered(const Pyramid& p, const NodeIndex& leaves, Vec3i block) {
  const Vec3l d = Vec3l(block) - p.origin;
  const std::int64_t edge = std::int64_t(1) << p.root_log2();
  if (p.empty() || min_component(d) < 0 || max_component(d) >= edge) return false;
  std::uint64_t code =
      morton_encode(Vec3<std::uint32_t>(Vec3l(d.x / kLeafEdge, d.y / kLeafEdge, d.z / kLeafEdge)));
  if (leaves.find(code)) return true;
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    code >>= 3;
    // A node without children is uniform: then nothing lies below, not even beside the block.
    if (const auto i = find(p.levels[level], code)) return is_uniform(p, level, *i);
  }
  return false;
}

std::array<std::int32_t, 3> as_array(Vec3i v) { return {v.x, v.y, v.z}; }
Vec3i as_vec(std::array<std::int32_t, 3> v) { return {v[0], v[1], v[2]}; }

}  // namespace

std::string text(Vec3i v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

std::optional<std::string> check_blocks(const VoxelGrid& grid, const Pyramid& pyramid) {
  const auto in_tile = [&](Vec3i at, std::int32_t smallest) {
    for (const std::int32_t edge : kTileEdges) {
      if (edge < smallest) continue;
      const Tile key{{at.x & -edge, at.y & -edge, at.z & -edge}, 0, 0};
      const auto t = std::lower_bound(grid.tiles.begin(), grid.tiles.end(), key, by_origin<Tile>);
      if (t != grid.tiles.end() && t->origin == key.origin && t->edge == edge) return true;
    }
    return false;
  };
  const NodeIndex leaves(pyramid);
  for (std::size_t i = 0; i < grid.tiles.size(); ++i) {
    const Tile& t = grid.tiles[i];
    const std::string tile = fmt::format("tile {} at {}: ", i, text(t.origin));
    if (std::find(std::begin(kTileEdges), std::end(kTileEdges), t.edge) == std::end(kTileEdges)) {
      return fmt::format("{}edge {}; expected 8, 128 or 4096", tile, t.edge);
    }
    if (!is_multiple(t.origin, t.edge)) return tile + "not aligned to its edge";
    if (i > 0 && !by_origin(grid.tiles[i - 1], t)) return tile + "out of order";
    if (!is_density(t.value) || t.value == 0) return tile + "its value is not a positive number";
    if (in_tile(t.origin, t.edge + 1)) return tile + "inside another tile";
    if (!is_covered(pyramid, leaves, t.origin) ||
        !is_covered(pyramid, leaves, t.origin + Vec3i(t.edge - kBrickEdge))) {
      return tile + "outside the bounds";
    }
  }
  const auto wrong_with = [&](std::size_t i) -> const char* {
    const Vec3i origin = grid.bricks[i].origin;
    if (!is_multiple(origin, kBrickEdge)) return "not aligned to 8";
    if (i > 0 && !by_origin(grid.bricks[i - 1], grid.bricks[i])) return "out of order";
    if (in_tile(origin, kBrickEdge)) return "inside a tile";
    return is_covered(pyramid, leaves, origin) ? nullptr : "outside the bounds";
  };
  const auto wrong = parallel_find(grid.bricks.size(), kGrain,
                                   [&](std::size_t i) { return wrong_with(i) != nullptr; });
  if (!wrong) return std::nullopt;
  return fmt::format("brick {} at {}: {}", *wrong, text(grid.bricks[*wrong].origin),
                     wrong_with(*wrong));
}

void write_blocks(const VoxelGrid& grid, ChunkWriter& chunk) {
  for (const Tile& t : grid.tiles) chunk.put(TileRecord{as_array(t.origin), t.edge, t.value});
  for (const Brick& b : grid.bricks) chunk.put(as_array(b.origin));
}

VoxelGrid read_blocks(ChunkReader& chunk, std::uint32_t tiles, std::uint32_t bricks) {
  VoxelGrid grid;
  std::vector<TileRecord> records(tiles);
  chunk.read(records);
  for (const TileRecord& t : records) grid.tiles.push_back({as_vec(t.origin), t.edge, t.value});
  std::vector<std::array<std::int32_t, 3>> origins(bricks);
  chunk.read(origins);
  for (const auto& origin : origins) grid.bricks.push_back({as_vec(origin), nullptr});
  return grid;
}

}  // namespace pvol::formats::detail
