// Counts and checks of all samples of a grid, in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "pvol/density/voxel_grid.h"

namespace pvol {

/// Whether it is finite and at least 0.
[[nodiscard]] inline bool is_density(float v) {
  return v >= 0 && v <= std::numeric_limits<float>::max();
}

/// What one pass over all samples of a grid tells.
struct SampleCount {
  std::uint64_t active = 0;  ///< samples above 0, all of those of tiles among them
  float largest = 0;
  /// The first brick that has a sample which is no density; the others are not counted then.
  std::optional<std::size_t> wrong_brick{};
};
[[nodiscard]] SampleCount count_samples(const VoxelGrid& grid);

}  // namespace pvol
