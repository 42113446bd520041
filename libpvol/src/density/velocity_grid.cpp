#include "pvol/density/velocity_grid.h"

#include <algorithm>
#include <array>

#include "density/block_collector.h"
#include "density/lattice_index.h"

namespace pvol {
namespace {

using detail::BlockCollector;
using detail::BlockFinder;
using Samples = BlockCollector::Samples;

/// What is left of values times a sign that is above 0.
VoxelGrid part(const VoxelGrid& grid, float sign) {
  BlockCollector all(grid);
  for (const Brick& b : grid.bricks) {
    Samples samples;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i] = std::max(sign * b.values[i], 0.0f);
    }
    all.add(b.origin, samples);
  }
  for (const Tile& t : grid.tiles) all.add({t.origin, t.edge, std::max(sign * t.value, 0.0f)});
  return std::move(all).take();
}

/// Where parts come from one grid no sample is above 0 in both, and no brick lies in a tile.
VoxelGrid difference(const VoxelGrid& positive, const VoxelGrid& negative) {
  BlockCollector all(positive);
  const BlockFinder other(negative);
  for (const Brick& b : positive.bricks) {
    const auto minus = other.find(b.origin);
    Samples samples;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i] = b.values[i] - (minus.values != nullptr ? minus.values[i] : minus.constant);
    }
    all.add(b.origin, samples);
  }
  const BlockFinder own(positive);
  for (const Brick& b : negative.bricks) {
    if (own.find(b.origin).values != nullptr) continue;
    Samples samples;
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = -b.values[i];
    all.add(b.origin, samples);
  }
  for (const Tile& t : positive.tiles) all.add(t);
  for (const Tile& t : negative.tiles) all.add({t.origin, t.edge, -t.value});
  return std::move(all).take();
}

}  // namespace

std::array<VoxelGrid, 6> signed_parts(const VelocityGrid& velocity) {
  std::array<VoxelGrid, 6> parts;
  for (std::size_t c = 0; c < 3; ++c) {
    parts[2 * c] = part(velocity.along[c], 1);
    parts[2 * c + 1] = part(velocity.along[c], -1);
  }
  return parts;
}

VelocityGrid join_parts(const std::array<VoxelGrid, 6>& parts) {
  VelocityGrid velocity;
  for (std::size_t c = 0; c < 3; ++c) {
    velocity.along[c] = difference(parts[2 * c], parts[2 * c + 1]);
  }
  return velocity;
}

}  // namespace pvol
