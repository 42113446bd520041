// The DENS chunk: samples in bricks and tiles.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <tuple>

#include "pvol/error.h"
#include "pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

constexpr std::int32_t kTileEdges[] = {8, 128, 4096};

std::string text(Vec3i v) {
  std::ostringstream s;
  s << '(' << v.x << ", " << v.y << ", " << v.z << ')';
  return s.str();
}

bool is_multiple(Vec3i v, std::int32_t of) {
  return v.x % of == 0 && v.y % of == 0 && v.z % of == 0;
}

bool is_density(float v) { return v >= 0 && std::isfinite(v); }

template <class Block>
bool by_origin(const Block& a, const Block& b) {
  return std::tie(a.origin.x, a.origin.y, a.origin.z) <
         std::tie(b.origin.x, b.origin.y, b.origin.z);
}

/// Whether the pyramid has a leaf, or a uniform cube around it, at this sample block.
bool is_covered(const Pyramid& p, Vec3i block) {
  const Vec3l d = Vec3l(block) - p.origin;
  const std::int64_t edge = std::int64_t(1) << p.root_log2();
  if (p.empty() || min_component(d) < 0 || max_component(d) >= edge) return false;
  std::uint64_t code =
      morton_encode(Vec3<std::uint32_t>(Vec3l(d.x / kLeafEdge, d.y / kLeafEdge, d.z / kLeafEdge)));
  if (find(p.levels[0], code)) return true;
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    code >>= 3;
    // A node without children is uniform: then nothing lies below, not even beside the block.
    if (const auto i = find(p.levels[level], code)) return is_uniform(p, level, *i);
  }
  return false;
}

/// Order, alignment, disjointness and place of bricks and tiles; a sentence about what is wrong.
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
  for (std::size_t i = 0; i < grid.tiles.size(); ++i) {
    const Tile& t = grid.tiles[i];
    const std::string tile = "tile " + std::to_string(i) + " at " + text(t.origin) + ": ";
    if (std::find(std::begin(kTileEdges), std::end(kTileEdges), t.edge) == std::end(kTileEdges)) {
      return tile + "edge " + std::to_string(t.edge) + "; expected 8, 128 or 4096";
    }
    if (!is_multiple(t.origin, t.edge)) return tile + "not aligned to its edge";
    if (i > 0 && !by_origin(grid.tiles[i - 1], t)) return tile + "out of order";
    if (!is_density(t.value) || t.value == 0) return tile + "its value is not a positive number";
    if (in_tile(t.origin, t.edge + 1)) return tile + "inside another tile";
    if (!is_covered(pyramid, t.origin) ||
        !is_covered(pyramid, t.origin + Vec3i(t.edge - kBrickEdge))) {
      return tile + "outside the bounds";
    }
  }
  for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
    const Vec3i origin = grid.bricks[i].origin;
    const std::string brick = "brick " + std::to_string(i) + " at " + text(origin) + ": ";
    if (!is_multiple(origin, kBrickEdge)) return brick + "not aligned to 8";
    if (i > 0 && !by_origin(grid.bricks[i - 1], grid.bricks[i])) return brick + "out of order";
    if (in_tile(origin, kBrickEdge)) return brick + "inside a tile";
    if (!is_covered(pyramid, origin)) return brick + "outside the bounds";
  }
  return std::nullopt;
}

/// What the file holds of a grid: sorted, without zeros.
VoxelGrid canonical(const VoxelGrid& grid) {
  VoxelGrid g = grid;
  std::erase_if(g.bricks, [](const Brick& b) {
    return std::all_of(b.values, b.values + kBrickSamples, [](float v) { return v == 0; });
  });
  std::erase_if(g.tiles, [](const Tile& t) { return t.value == 0; });
  sort(g);
  return g;
}

template <class T>
void append(ChunkWriter& chunk, const T& value) {
  chunk.write(std::as_bytes(std::span<const T>(&value, 1)));
}

std::array<std::int32_t, 3> as_array(Vec3i v) { return {v.x, v.y, v.z}; }
Vec3i as_vec(std::array<std::int32_t, 3> v) { return {v[0], v[1], v[2]}; }

}  // namespace

void encode_density(const VoxelGrid& grid, const Pyramid& pyramid, ChunkWriter& chunk,
                    const std::string& place) {
  const VoxelGrid g = canonical(grid);
  if (const auto wrong = check_blocks(g, pyramid)) {
    throw Error(place + ": the density to be written is wrong: " + *wrong + ".");
  }
  append(chunk, DensityHeader{std::uint32_t(g.tiles.size()), std::uint32_t(g.bricks.size())});
  for (const Tile& t : g.tiles) append(chunk, TileRecord{as_array(t.origin), t.edge, t.value});
  for (const Brick& b : g.bricks) append(chunk, as_array(b.origin));
  for (const Brick& b : g.bricks) {
    std::array<float, kBrickSamples> values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!is_density(b.values[i])) {
        throw Error(place + ": the density to be written is wrong: brick at " + text(b.origin) +
                    ": a sample is negative or not finite.");
      }
      values[i] = b.values[i] + 0.0f;  // -0 becomes 0, so that equal fields give equal bytes
    }
    append(chunk, values);
  }
}

VoxelGrid decode_density(ChunkReader& chunk, const Pyramid& pyramid) {
  const auto header = chunk.get<DensityHeader>();
  const std::uint64_t expected =
      sizeof(DensityHeader) + sizeof(TileRecord) * std::uint64_t(header.tiles) +
      (sizeof(Vec3i) + kBrickSamples * sizeof(float)) * std::uint64_t(header.bricks);
  if (chunk.raw_bytes() != expected) {
    refuse(chunk.place(), std::to_string(chunk.raw_bytes()) + " raw bytes; its counts of " +
                              std::to_string(header.tiles) + " tiles and " +
                              std::to_string(header.bricks) + " bricks take " +
                              std::to_string(expected));
  }
  VoxelGrid grid;
  std::vector<TileRecord> tiles(header.tiles);
  chunk.read(tiles);
  for (const TileRecord& t : tiles) grid.tiles.push_back({as_vec(t.origin), t.edge, t.value});
  std::vector<std::array<std::int32_t, 3>> origins(header.bricks);
  chunk.read(origins);
  for (const auto& origin : origins) grid.bricks.push_back({as_vec(origin), nullptr});
  if (const auto bad = check_blocks(grid, pyramid)) refuse(chunk.place(), *bad);

  const std::size_t count = std::size_t(header.bricks) * kBrickSamples;
  const auto values = std::make_shared_for_overwrite<float[]>(count);
  const std::span<float> samples(values.get(), count);
  chunk.read(std::as_writable_bytes(samples));
  const auto wrong = std::find_if_not(samples.begin(), samples.end(), is_density);
  if (wrong != samples.end()) {
    refuse(chunk.place(), "brick " + std::to_string((wrong - samples.begin()) / kBrickSamples) +
                              ": a sample is negative or not finite");
  }
  for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
    grid.bricks[b].values = samples.data() + b * kBrickSamples;
  }
  grid.owner = values;
  return grid;
}

}  // namespace pvol::formats::detail
