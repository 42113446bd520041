// Grids from the caller's own samples.
#include "pvol/density/voxel_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "density/array_rows.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/math/rng.h"

namespace pvol {
namespace make_grid_test {

constexpr std::uint64_t kSeed = 20240607;

TEST(MakeGrid, HoldsTheSamplesOfADenseArray) {
  const Vec3i size(13, 7, 20), origin(-5, 17, -9);
  std::vector<float> values, x_first(13 * 7 * 20);
  Rng rng(kSeed, 1, 0);
  for (int i = 0; i < size.x; ++i) {
    for (int j = 0; j < size.y; ++j) {
      for (int k = 0; k < size.z; ++k) {
        values.push_back(i < 5 ? 0 : rng.uniform());
        x_first[std::size_t((k * size.y + j) * size.x + i)] = values.back();
      }
    }
  }
  const VoxelGrid grids[] = {make_grid({.values = values.data(), .size = size, .origin = origin}),
                             make_grid({.values = x_first.data(),
                                        .size = size,
                                        .origin = origin,
                                        .stride = Vec3l(1, size.x, size.x * size.y)})};
  for (const VoxelGrid& grid : grids) {
    int wrong = 0;
    for (int i = -4; i < size.x + 12; ++i) {
      for (int j = -12; j < size.y + 12; ++j) {
        for (int k = -12; k < size.z + 12; ++k) {
          const bool inside = i >= 0 && j >= 0 && k >= 0 && i < 13 && j < 7 && k < 20;
          const float expected = inside ? values[std::size_t((i * 7 + j) * 20 + k)] : 0;
          wrong += sample(grid, origin + Vec3i(i, j, k)) != expected;
        }
      }
    }
    EXPECT_EQ(wrong, 0);
    for (const Brick& b : grid.bricks) EXPECT_GE(b.origin.x, 0);
    EXPECT_FALSE(validate(build_pyramid(grid)));
  }
}

TEST(MakeGrid, AsksTheCallerForBricksAndDropsEmptyOnes) {
  const auto fill = [](Vec3i origin, float* values) {
    if (origin.x == 8) values[511] = float(origin.z + 100);
  };
  const VoxelGrid grid = make_grid({-3, 0, -8}, {17, 1, 9}, fill);
  ASSERT_EQ(grid.bricks.size(), 3u);
  for (const int z : {-8, 0, 8}) EXPECT_EQ(sample(grid, {15, 7, z + 7}), float(z + 100));
}

/// Of a box that no memory holds it is the bricks with a density that count, as some of them tell.
TEST(MakeGrid, FitsIntoMemoryByWhatIsOccupied) {
  const Vec3l lo(0, 0, 0), hi(1 << 17, 1 << 17, 1 << 17);
  const auto occupied_up_to = [](std::int32_t end) {
    return [end](Vec3i origin, float* values) { values[0] = origin.x < end ? 1.0f : 0.0f; };
  };
  EXPECT_NO_THROW(detail::require_grid_memory(lo, hi, occupied_up_to(0)));
  EXPECT_THROW(detail::require_grid_memory(lo, hi, occupied_up_to(1 << 14)), Error);
  EXPECT_THROW(detail::require_grid_memory(lo, hi, occupied_up_to(1 << 17)), Error);
}

TEST(MakeGrid, RefusesWhatIsNoDensity) {
  std::vector<float> values(27, 1.0f);
  const DenseArray array{.values = values.data(), .size = {3, 3, 3}, .origin = {40, 0, 0}};
  EXPECT_EQ(make_grid(array).bricks.size(), 1u);
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF, -1e-30f}) {
    values[14] = bad;
    try {
      (void)make_grid(array);
      ADD_FAILURE() << bad;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("(41, 1, 2)"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW((void)make_grid({.values = nullptr, .size = {3, 3, 3}}), Error);
  EXPECT_THROW((void)make_grid({.values = values.data(), .size = {3, 0, 3}}), Error);
  EXPECT_THROW((void)make_grid({.values = values.data(), .size = {3, 3, -1}}), Error);
  EXPECT_THROW(
      (void)make_grid({.values = values.data(), .size = {3, 3, 3}, .origin = {0, 1 << 30, 0}}),
      Error);
  const FillBrick fails = [](Vec3i, float*) { throw std::out_of_range("the caller's own"); };
  EXPECT_THROW((void)make_grid({0, 0, 0}, {99, 9, 9}, fails), std::out_of_range);
}

}  // namespace make_grid_test
}  // namespace pvol
