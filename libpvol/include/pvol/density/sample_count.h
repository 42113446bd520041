// Counts and checks of all samples of a grid, in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "pvol/density/voxel_grid.h"

namespace pvol {

struct SampleCount {
  std::uint64_t active = 0;  ///< samples above 0, all of those of tiles among them
  float largest = 0;
};
[[nodiscard]] SampleCount count_samples(const VoxelGrid& grid);

/// Whether it is finite and at least 0.
[[nodiscard]] inline bool is_density(float v) {
  return v >= 0 && v <= std::numeric_limits<float>::max();
}

/// The first of bricks of kBrickSamples samples each that has one which is no density.
[[nodiscard]] std::optional<std::size_t> find_wrong_brick(std::span<const float> samples);

}  // namespace pvol
