#include "pvol/density/sample_count.h"

#include <algorithm>
#include <bit>
#include <mutex>

#include "density/sample_range.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

constexpr std::size_t kGrain = 1024;  // bricks of a task

/// is_density for each of a brick's samples. By their bits and without branches, as nearly all are
/// right: such loops become those of vectors.
bool are_densities(const float* samples) {
  constexpr auto kLargest = std::bit_cast<std::int32_t>(std::numeric_limits<float>::max());
  constexpr auto kMinusZero = std::bit_cast<std::int32_t>(-0.0f);
  int wrong = 0;
  for (int i = 0; i < kBrickSamples; ++i) {
    const auto bits = std::bit_cast<std::int32_t>(samples[i]);
    wrong |= int(bits > kLargest) | (int(bits < 0) & int(bits != kMinusZero));
  }
  return wrong == 0;
}

void add(SampleCount& count, const SampleCount& more) {
  count.active += more.active;
  count.largest = std::max(count.largest, more.largest);
  if (more.wrong_brick && (!count.wrong_brick || *more.wrong_brick < *count.wrong_brick)) {
    count.wrong_brick = more.wrong_brick;
  }
}

void add_brick(SampleCount& count, const float* samples) {
  int active = 0;
  for (int i = 0; i < kBrickSamples; ++i) active += samples[i] > 0 ? 1 : 0;
  count.active += std::uint64_t(active);
  count.largest = std::max(count.largest, detail::SampleRange(samples, kBrickSamples).hi());
}

}  // namespace

SampleCount count_samples(const VoxelGrid& grid) {
  SampleCount count;
  std::mutex adding;
  parallel_parts(0, grid.bricks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    SampleCount part;
    for (std::size_t b = begin; b != end && !part.wrong_brick; ++b) {
      if (are_densities(grid.bricks[b].values)) {
        add_brick(part, grid.bricks[b].values);
      } else {
        part.wrong_brick = b;
      }
    }
    const std::scoped_lock lock(adding);
    add(count, part);
  });
  for (const Tile& t : grid.tiles) {
    const auto edge = std::uint64_t(t.edge);
    add(count, {edge * edge * edge, t.value});
  }
  return count;
}

}  // namespace pvol
