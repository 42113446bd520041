#include "pvol/bounds/bound_grids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "pvol/error.h"

namespace pvol {
namespace bound_grids_test {

/// Bricks of noise around the origin, with an empty gap, and a tile.
VoxelGrid make_grid(bool with_tile) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.0f, 2.0f);
  const auto values = std::make_shared<std::vector<float>>(3 * kBrickSamples);
  for (float& v : *values) v = uniform(random);
  VoxelGrid g;
  g.index_to_world = translation({10, 20, 30}) * scaling({0.5, 0.25, 2});
  const Vec3i origins[] = {{-8, 0, 16}, {0, 0, 16}, {40, -24, 8}};
  for (std::size_t b = 0; b < 3; ++b) {
    g.bricks.push_back({origins[b], values->data() + b * kBrickSamples});
  }
  if (with_tile) g.tiles.push_back({{128, 0, 0}, 128, 0.75f});
  g.owner = values;
  return g;
}

bool has_children(const Pyramid& p, std::size_t level, std::uint64_t code) {
  for (std::uint64_t k = 0; level > 0 && k < 8; ++k) {
    if (find(p.levels[level - 1], code * 8 + k)) return true;
  }
  return false;
}

/// The leaf or uniform cube that covers a cell, if any.
std::optional<PyramidNode> node_at(const Pyramid& p, Vec3l cell) {
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    const Vec3l c = cell - p.origin;
    if (min_component(c) < 0) return std::nullopt;
    const Vec3<std::uint32_t> cube(Vec3l(c.x / edge, c.y / edge, c.z / edge));
    const std::uint64_t code = morton_encode(cube);
    const auto i = find(p.levels[level], code);
    if (i && !has_children(p, level, code)) return p.levels[level][*i];
  }
  return std::nullopt;
}

TEST(BoundGrids, HoldTheBoundsOfEveryLeafAndZeroElsewhere) {
  const VoxelGrid grid = make_grid(true);
  const Pyramid p = build_pyramid(grid);
  const BoundGrids b = make_bound_grids(p, grid.index_to_world);
  for (std::int32_t x = -3; x < 34; ++x) {
    for (std::int32_t y = -5; y < 18; ++y) {
      for (std::int32_t z = -2; z < 18; ++z) {
        const auto node = node_at(p, Vec3l(x, y, z) * std::int64_t(kLeafEdge));
        ASSERT_EQ(sample(b.majorant, {x, y, z}), node ? node->hi : 0.0f)
            << x << ' ' << y << ' ' << z;
        ASSERT_EQ(sample(b.minorant, {x, y, z}), node ? node->lo : 0.0f)
            << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(BoundGrids, SamplesLieAtTheCentresOfTheirCubes) {
  const VoxelGrid grid = make_grid(false);
  const BoundGrids b = make_bound_grids(build_pyramid(grid), grid.index_to_world);
  EXPECT_EQ(b.majorant.index_to_world.point({2, -3, 1}),
            grid.index_to_world.point({2 * 8 + 4, -3 * 8 + 4, 1 * 8 + 4}));
  EXPECT_EQ(b.majorant.index_to_world, b.minorant.index_to_world);
}

TEST(BoundGrids, BricksLieAtMultiplesOfEightAndHoldSomething) {
  const VoxelGrid grid = make_grid(true);
  for (const Brick& b :
       make_bound_grids(build_pyramid(grid), grid.index_to_world).majorant.bricks) {
    EXPECT_GT(*std::max_element(b.values, b.values + kBrickSamples), 0);
    EXPECT_EQ(b.origin.x & 7, 0);
    EXPECT_EQ(b.origin.y & 7, 0);
    EXPECT_EQ(b.origin.z & 7, 0);
  }
}

TEST(BoundGrids, HugeUniformRegionsAreRefused) {
  VoxelGrid grid;
  grid.tiles.push_back({{0, 0, 0}, 4096, 1.0f});
  EXPECT_THROW((void)make_bound_grids(build_pyramid(grid), {}, 1000), Error);
}

TEST(BoundGrids, OfAnEmptyPyramidAreEmpty) {
  EXPECT_TRUE(make_bound_grids({}, {}).majorant.bricks.empty());
}

}  // namespace bound_grids_test
}  // namespace pvol
