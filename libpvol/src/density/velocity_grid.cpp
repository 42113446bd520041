#include "pvol/density/velocity_grid.h"

#include <algorithm>
#include <array>
#include <deque>
#include <memory>

#include "density/lattice_index.h"

namespace pvol {
namespace {

using detail::BlockFinder;
using Samples = std::array<float, kBrickSamples>;

/// Bricks and tiles that are made one by one, without zeros.
class Collected {
 public:
  explicit Collected(const VoxelGrid& like) {
    grid_.name = like.name;
    grid_.index_to_world = like.index_to_world;
  }
  void add(Vec3i origin, const Samples& samples) {
    if (std::ranges::all_of(samples, [](float v) { return v == 0; })) return;
    grid_.bricks.push_back({origin, samples_->emplace_back(samples).data()});
  }
  void add(const Tile& tile) {
    if (tile.value != 0) grid_.tiles.push_back(tile);
  }
  [[nodiscard]] VoxelGrid take() && {
    grid_.owner = samples_;
    sort(grid_);
    return std::move(grid_);
  }

 private:
  VoxelGrid grid_;
  std::shared_ptr<std::deque<Samples>> samples_ = std::make_shared<std::deque<Samples>>();
};

/// What is left of values times a sign that is above 0.
VoxelGrid part(const VoxelGrid& grid, float sign) {
  Collected all(grid);
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
  Collected all(positive);
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
