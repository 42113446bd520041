// What all samples of a grid are, whatever the threads.
#include "pvol/density/sample_count.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "pvol/math/rng.h"

namespace pvol {
namespace sample_count_test {

constexpr std::size_t kBricks = 5000;  // several tasks

std::vector<float> random_samples() {
  std::vector<float> samples(kBricks * kBrickSamples);
  Rng rng(1, 2, 3);
  for (float& v : samples) v = std::max(0.0f, rng.uniform() - 0.5f);
  return samples;
}

VoxelGrid grid_of(const std::vector<float>& samples) {
  VoxelGrid grid;
  for (std::size_t b = 0; b < samples.size() / kBrickSamples; ++b) {
    grid.bricks.push_back({{8 * int(b), 0, 0}, samples.data() + b * kBrickSamples});
  }
  return grid;
}

TEST(SampleCount, IsThatOfBricksAndTiles) {
  const std::vector<float> samples = random_samples();
  VoxelGrid grid = grid_of(samples);
  std::uint64_t active = 0;
  float largest = 0;
  for (const float v : samples) active += v > 0, largest = std::max(largest, v);
  EXPECT_EQ(count_samples(grid).active, active);
  EXPECT_EQ(count_samples(grid).largest, largest);
  grid.tiles = {{{0, 16, 0}, 16, 0.75f}};
  EXPECT_EQ(count_samples(grid).active, active + 4096);
  EXPECT_EQ(count_samples(grid).largest, 0.75f);
  EXPECT_EQ(count_samples({}).active, 0u);
}

TEST(SampleCount, TheFirstWrongBrickIsFound) {
  std::vector<float> samples = random_samples();
  const VoxelGrid grid = grid_of(samples);
  const auto found = [&] { return count_samples(grid).wrong_brick; };
  EXPECT_EQ(found(), std::nullopt);
  EXPECT_EQ(count_samples({}).wrong_brick, std::nullopt);
  const float wrong[] = {-0x1p-149f, std::numeric_limits<float>::infinity(), std::nanf(""),
                         -std::nanf(""), -1};
  // One alone, the first or the last sample of its brick among them.
  for (const std::size_t alone : {std::size_t(0), std::size_t(10), kBricks / 2, kBricks - 1}) {
    float& sample = samples[alone * kBrickSamples + (alone == 0 ? 0 : kBrickSamples - 1)];
    const float right = std::exchange(sample, -1.0f);
    for (int trial = 0; trial < 20; ++trial) ASSERT_EQ(found(), alone);
    sample = right;
  }
  // Each earlier than those before, in other tasks.
  std::size_t brick = kBricks - 1;
  for (const float v : wrong) {
    ASSERT_FALSE(is_density(v));
    samples[brick * kBrickSamples + brick % kBrickSamples] = v;
    for (int trial = 0; trial < 20; ++trial) ASSERT_EQ(found(), brick) << v;
    brick = brick * 2 / 3;
  }
  samples.assign(samples.size(), -0.0f);
  EXPECT_EQ(found(), std::nullopt);
  EXPECT_EQ(count_samples(grid).active, 0u);
  EXPECT_EQ(count_samples(grid).largest, 0);
}

}  // namespace sample_count_test
}  // namespace pvol
