// The grids that recipes are sampled to.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "pvol/density/recipe.h"
#include "support/recipes.h"

namespace pvol {
namespace recipe_grid_test {

using test::ball;
using test::kRecipes;
using test::make_sample;

std::uint64_t key(Vec3i at) {
  const auto bits = [](std::int32_t v) { return std::uint64_t(v + (1 << 20)); };
  return bits(at.x) << 42 | bits(at.y) << 21 | bits(at.z);
}

/// All samples of a grid that are not 0; a sample given twice is a failure.
std::unordered_map<std::uint64_t, float> samples_of(const VoxelGrid& grid) {
  std::unordered_map<std::uint64_t, float> samples;
  const auto put = [&](Vec3i at, float v) {
    if (v != 0) {
      EXPECT_TRUE(samples.emplace(key(at), v).second);
    }
  };
  for (const Brick& b : grid.bricks) {
    for (int n = 0; n < kBrickSamples; ++n) {
      put(b.origin + Vec3i{n / 64, n / 8 % 8, n % 8}, b.values[n]);
    }
  }
  for (const Tile& t : grid.tiles) {
    for (int n = 0; n < t.edge * t.edge * t.edge; ++n) {
      put(t.origin + Vec3i{n / t.edge / t.edge, n / t.edge % t.edge, n % t.edge}, t.value);
    }
  }
  return samples;
}

TEST(Recipe, GridHoldsExactlyTheSamplesOfTheDensity) {
  for (const Recipe& r : kRecipes) {
    const VoxelGrid grid = make_grid(r);
    auto samples = samples_of(grid);
    ASSERT_GT(samples.size(), 1000u);
    const Box b = support(r);
    const auto first = [&](double x) { return int(std::floor(x / r.voxel)) - 4; };
    const auto last = [&](double x) { return int(std::ceil(x / r.voxel)) + 4; };
    std::size_t wrong = 0;
    for (int i = first(b.lo.x); i <= last(b.hi.x); ++i) {
      for (int j = first(b.lo.y); j <= last(b.hi.y); ++j) {
        for (int k = first(b.lo.z); k <= last(b.hi.z); ++k) {
          const auto found = samples.find(key({i, j, k}));
          const float in_grid = found == samples.end() ? 0 : found->second;
          wrong += in_grid != float(density(r, Vec3d(i, j, k) * r.voxel));
          if (found != samples.end()) samples.erase(found);
        }
      }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_TRUE(samples.empty());  // nothing outside the support
  }
}

TEST(Recipe, GridHasNoEmptyBrickAndIsSorted) {
  for (const Recipe& r : kRecipes) {
    VoxelGrid grid = make_grid(r);
    for (const Brick& b : grid.bricks) {
      EXPECT_EQ(b.origin.x % 8 | b.origin.y % 8 | b.origin.z % 8, 0);
      EXPECT_TRUE(std::any_of(b.values, b.values + kBrickSamples, [](float v) { return v > 0; }));
    }
    const VoxelGrid before = grid;
    sort(grid);
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
      EXPECT_EQ(grid.bricks[i].origin, before.bricks[i].origin);
    }
    EXPECT_EQ(grid.index_to_world, scaling(Vec3d(r.voxel)));
    EXPECT_EQ(grid.name, "density");
  }
}

TEST(Recipe, GridIsTheSameForAnyNumberOfThreads) {
  const Recipe r = make_sample();
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
    VoxelGrid grid;
    tbb::task_arena(threads).execute([&] { grid = make_grid(r); });
    return grid;
  };
  const VoxelGrid one = with_threads(1), seven = with_threads(7);
  ASSERT_EQ(one.bricks.size(), seven.bricks.size());
  ASSERT_EQ(one.tiles.size(), seven.tiles.size());
  for (std::size_t i = 0; i < one.bricks.size(); ++i) {
    ASSERT_EQ(one.bricks[i].origin, seven.bricks[i].origin);
    ASSERT_TRUE(std::equal(one.bricks[i].values, one.bricks[i].values + kBrickSamples,
                           seven.bricks[i].values));
  }
  for (std::size_t i = 0; i < one.tiles.size(); ++i) {
    EXPECT_EQ(one.tiles[i].origin, seven.tiles[i].origin);
  }
}

TEST(Recipe, UniformInsideBecomesTiles) {
  Recipe r;
  r.voxel = 0.004;  // 500 samples across
  r.forms = {ball({}, 1)};
  r.density = 2;
  const VoxelGrid grid = make_grid(r);
  std::size_t large = 0;
  double volume = 0;
  for (const Tile& t : grid.tiles) {
    EXPECT_EQ(t.value, 2);
    large += t.edge == 128;
    volume += std::pow(t.edge * r.voxel, 3);
  }
  EXPECT_GE(large, 8u);
  EXPECT_GT(volume, 0.8 * 4.18879);
}

TEST(Recipe, WithoutACloudGivesAnEmptyGrid) {
  Recipe r;
  r.forms = {FreeForm{{{}, {}, {}, -1}, {}}};
  EXPECT_TRUE(support(r).empty());
  const VoxelGrid grid = make_grid(r);
  EXPECT_TRUE(grid.bricks.empty() && grid.tiles.empty());
  r.forms = {ball({}, 1)};
  r.cuts = {FreeForm{half_space({0, 5, 0}, {0, 1, 0}), {}}};
  EXPECT_TRUE(support(r).empty());
  EXPECT_TRUE(make_grid(r).bricks.empty());
}

}  // namespace recipe_grid_test
}  // namespace pvol
