#include "pvol/density/color_grid.h"

#include <algorithm>

#include "density/block_collector.h"
#include "density/lattice_index.h"

namespace pvol {
namespace {

using detail::BlockCollector;
using detail::BlockFinder;
using detail::BlockSource;
using Samples = BlockCollector::Samples;

/// An empty grid on the lattice of another.
VoxelGrid unnamed(const VoxelGrid& like) {
  VoxelGrid grid;
  grid.index_to_world = like.index_to_world;
  return grid;
}

float value_in(const BlockSource& block, int i) {
  return block.values != nullptr ? block.values[i] : block.constant;
}

/// Origins of the bricks of all grids, and of their tiles, each once.
struct Blocks {
  std::vector<Vec3i> bricks;
  std::vector<Tile> tiles;
};
Blocks blocks_of(std::span<const VoxelGrid* const> grids) {
  const auto place = [](Vec3i p) { return std::array{p.x, p.y, p.z}; };
  Blocks all;
  for (const VoxelGrid* g : grids) {
    for (const Brick& b : g->bricks) all.bricks.push_back(b.origin);
    all.tiles.insert(all.tiles.end(), g->tiles.begin(), g->tiles.end());
  }
  std::ranges::sort(all.bricks, {}, place);
  all.bricks.erase(std::unique(all.bricks.begin(), all.bricks.end()), all.bricks.end());
  const auto by_place = [&](const Tile& t) { return std::pair(place(t.origin), t.edge); };
  std::ranges::sort(all.tiles, {}, by_place);
  const auto same = [&](const Tile& a, const Tile& b) { return by_place(a) == by_place(b); };
  all.tiles.erase(std::unique(all.tiles.begin(), all.tiles.end(), same), all.tiles.end());
  return all;
}

}  // namespace

void visit_colors(
    const ColorGrid& colors,
    const std::function<void(Vec3i origin, int edge, std::span<const Float4> samples)>& visit) {
  const auto& c = colors.channels;
  const std::array finders{BlockFinder(c[0]), BlockFinder(c[1]), BlockFinder(c[2])};
  const auto at = [&](Vec3i origin) {
    return std::array{finders[0].find(origin), finders[1].find(origin), finders[2].find(origin)};
  };
  for (const Brick& b : colors.known.bricks) {
    std::array<Float4, kBrickSamples> samples;
    const auto [r, g, blue] = at(b.origin);
    for (int i = 0; i < kBrickSamples; ++i) {
      samples[std::size_t(i)] =
          Float4{value_in(r, i), value_in(g, i), value_in(blue, i), b.values[i]};
    }
    visit(b.origin, kBrickEdge, samples);
  }
  for (const Tile& t : colors.known.tiles) {
    const auto [r, g, blue] = at(t.origin);
    const Float4 sample{value_in(r, 0), value_in(g, 0), value_in(blue, 0), t.value};
    visit(t.origin, t.edge, std::span(&sample, 1));
  }
}

VoxelGrid known_of(const std::array<VoxelGrid, 3>& channels, const VoxelGrid* black) {
  std::vector<const VoxelGrid*> grids{&channels[0], &channels[1], &channels[2]};
  if (black != nullptr) grids.push_back(black);
  std::vector<BlockFinder> finders;
  finders.reserve(grids.size());
  for (const VoxelGrid* g : grids) finders.emplace_back(*g);
  const Blocks blocks = blocks_of(grids);
  BlockCollector known(unnamed(channels[0]));
  for (const Tile& t : blocks.tiles) known.add({t.origin, t.edge, 1});
  for (const Vec3i origin : blocks.bricks) {
    Samples samples{};
    bool in_tile = false;
    for (const BlockFinder& f : finders) {
      const BlockSource block = f.find(origin);
      in_tile |= block.values == nullptr && block.constant > 0;
      for (int i = 0; i < kBrickSamples; ++i) {
        if (value_in(block, i) > 0) samples[std::size_t(i)] = 1;
      }
    }
    if (!in_tile) known.add(origin, samples);
  }
  return std::move(known).take();
}

VoxelGrid black_of(const ColorGrid& colors) {
  BlockCollector black(unnamed(colors.channels[0]));
  const auto is_black = [](const Float4& s) {
    return s[3] > 0 && !(s[0] > 0) && !(s[1] > 0) && !(s[2] > 0);
  };
  visit_colors(colors, [&](Vec3i origin, int edge, std::span<const Float4> samples) {
    if (samples.size() == 1) {
      if (is_black(samples[0])) black.add({origin, edge, 1});
      return;
    }
    Samples ones{};
    for (std::size_t i = 0; i < samples.size(); ++i) ones[i] = is_black(samples[i]) ? 1 : 0;
    black.add(origin, ones);
  });
  return std::move(black).take();
}

}  // namespace pvol
