#include "pvol/density/sample_count.h"

#include <algorithm>
#include <mutex>

#include "pvol/math/parallel.h"

namespace pvol {
namespace {

constexpr std::size_t kGrain = 1024;  // bricks of a task

}  // namespace

SampleCount count_samples(const VoxelGrid& grid) {
  SampleCount count;
  std::mutex adding;
  parallel_parts(0, grid.bricks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    SampleCount some;
    for (std::size_t b = begin; b != end; ++b) {
      int active = 0;
      for (const float v : std::span(grid.bricks[b].values, kBrickSamples)) {
        active += v > 0 ? 1 : 0;
        some.largest = std::max(some.largest, v);
      }
      some.active += std::uint64_t(active);
    }
    const std::scoped_lock lock(adding);
    count.active += some.active, count.largest = std::max(count.largest, some.largest);
  });
  for (const Tile& t : grid.tiles) {
    const auto edge = std::uint64_t(t.edge);
    count.active += edge * edge * edge;
    count.largest = std::max(count.largest, t.value);
  }
  return count;
}

std::optional<std::size_t> find_wrong_brick(std::span<const float> samples) {
  const std::size_t bricks = samples.size() / kBrickSamples;
  return parallel_find(bricks, kGrain, [&](std::size_t b) {
    // Without a branch for each, as nearly all are right.
    bool right = true;
    for (const float v : samples.subspan(b * kBrickSamples, kBrickSamples)) right &= is_density(v);
    return !right;
  });
}

}  // namespace pvol
