// Grids that are made brick by brick.
#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <utility>

#include "pvol/density/voxel_grid.h"

namespace pvol::detail {

/// Collects bricks and tiles in any order, but none of zeros.
class BlockCollector {
 public:
  using Samples = std::array<float, kBrickSamples>;

  /// With the name and the map of a grid.
  explicit BlockCollector(const VoxelGrid& like) {
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

}  // namespace pvol::detail
