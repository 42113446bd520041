#include "pvol/bounds/statistics.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <random>

#include "pvol/field/brick_field.h"

namespace pvol {
namespace statistics_test {

/// `count` bricks of noise in a row along x, from 0.
VoxelGrid make_noise(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.25f, 1.0f);
  const auto values = std::make_shared<std::vector<float>>(std::size_t(count) * kBrickSamples);
  for (float& v : *values) v = uniform(random);
  VoxelGrid g;
  for (int b = 0; b < count; ++b) {
    g.bricks.push_back({{8 * b, 0, 0}, values->data() + std::size_t(b) * kBrickSamples});
  }
  g.owner = values;
  return g;
}

VoxelGrid make_tile() {
  VoxelGrid g;
  g.tiles.push_back({{0, 0, 0}, 128, 0.5f});
  return g;
}

double sum_of_samples(const VoxelGrid& g) {
  double sum = 0;
  for (const Brick& b : g.bricks) sum = std::accumulate(b.values, b.values + kBrickSamples, sum);
  for (const Tile& t : g.tiles) sum += double(t.value) * t.edge * t.edge * t.edge;
  return sum;
}

Octree build(const VoxelGrid& g, const Pyramid& p, double extinction, int depth) {
  const FieldWithLinks f = build_field(g, p);
  Cut cut;
  cut.depth = depth;
  cut.everywhere = true;
  return build_octree(p, extinction, 1, cut, f.brick_of, kZeroBrick);
}

TEST(Statistics, MassIsTheSumOfAllSamples) {
  for (const VoxelGrid& g : {make_noise(1), make_noise(5), make_tile()}) {
    const Pyramid p = build_pyramid(g);
    const BoundsStatistics s = measure_bounds(p, measure_content(g, p));
    EXPECT_NEAR(s.mass, sum_of_samples(g), 1e-12 * sum_of_samples(g));
  }
}

TEST(Statistics, EveryLevelAndTheLeavesAboveItHoldTheWholeMass) {
  const VoxelGrid g = make_tile();
  const PyramidContent content = measure_content(g, build_pyramid(g));
  double above = 0;
  for (std::size_t level = content.size(); level-- > 0;) {
    double here = 0, leaves = 0;
    for (const NodeContent& n : content[level]) {
      here += n.mass;
      if (n.leaf) leaves += n.mass;
    }
    EXPECT_NEAR(above + here, sum_of_samples(g), 1e-9 * sum_of_samples(g));
    above += leaves;
  }
}

TEST(Statistics, MeansAreThoseOverTheNodesOfADepth) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(16, 8, 8);
  p.levels = {{{0, 0.25f, 1}, {morton_encode({1, 0, 0}), 0.5f, 0.5f}}, {{0, 0, 1}}};
  const PyramidContent content{
      {{.mass = 0.5 * 512, .leaf = true}, {.mass = 0.5 * 512, .leaf = true, .uniform = true}},
      {{.mass = 0.5 * 1024}}};
  const BoundsStatistics s = measure_bounds(p, content);
  ASSERT_EQ(s.depths.size(), 2u);
  const DepthStatistics &root = s.depths[0], &leaves = s.depths[1];
  EXPECT_EQ(root.nodes, 1u);
  EXPECT_EQ(root.leaves, 0u);
  EXPECT_DOUBLE_EQ(root.mean_hi, 2);
  EXPECT_DOUBLE_EQ(root.mean_lo, 0);
  EXPECT_EQ(leaves.nodes, 2u);
  EXPECT_EQ(leaves.leaves, 2u);
  EXPECT_DOUBLE_EQ(leaves.mean_hi, (2 + 1) / 2.0);
  EXPECT_DOUBLE_EQ(leaves.mean_lo, (0.5 + 1) / 2.0);
}

/// By the cost model cubes of equal bounds are divided alike, wherever they stand.
TEST(Statistics, EqualHalvesAreCutAlike) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(32, 16, 16);
  p.levels.resize(3);
  for (const std::uint64_t half : {morton_encode({0, 0, 0}), morton_encode({1, 0, 0})}) {
    for (std::uint64_t k = 0; k < 8; ++k) {
      p.levels[0].push_back({8 * half + k, 0.25f, k == 0 ? 1 : 0.5f});
    }
  }
  complete_levels(p);
  std::vector<std::vector<std::uint32_t>> bricks;
  for (const auto& level : p.levels) bricks.emplace_back(level.size(), kZeroBrick);
  bool halves = false, leaves = false;
  for (double extinction = 1e-4; extinction < 100; extinction *= 1.1) {
    const std::uint64_t n = build_octree(p, extinction, 1, {}, bricks, kZeroBrick).terminals;
    ASSERT_TRUE(n == 2 || n == 16) << n << " at " << extinction;
    halves |= n == 2, leaves |= n == 16;
  }
  EXPECT_TRUE(halves && leaves);
}

TEST(Statistics, ClassesFillTheRoot) {
  const VoxelGrid g = make_tile();
  const Pyramid p = build_pyramid(g);
  const BoundsStatistics s = measure_bounds(p, measure_content(g, p));
  EXPECT_EQ(s.uniform.volume + s.mixed.volume + s.empty.volume, s.root_volume);
  EXPECT_NEAR(s.uniform.mass + s.mixed.mass, s.mass, 1e-9 * s.mass);
  // The tile's samples span 127 cells; leaves wholly among them are the 15 x 15 x 15 of the inside.
  EXPECT_EQ(s.uniform.volume, 15.0 * 15 * 15 * 512);
}

TEST(Statistics, BoundsTightenWithDepthAndResidualsStayBelowMajorants) {
  const VoxelGrid g = make_noise(9);
  const Pyramid p = build_pyramid(g);
  const BoundsStatistics s = measure_bounds(p, measure_content(g, p));
  ASSERT_EQ(s.depths.size(), p.levels.size());
  for (std::size_t d = 0; d < s.depths.size(); ++d) {
    const Tightness& t = s.depths[d].tightness;
    EXPECT_EQ(s.depths[d].depth, int(d));
    EXPECT_GE(t.majorant.even, 1.0);
    EXPECT_GE(t.majorant.dense, 1.0);
    EXPECT_LE(t.residual.even, t.majorant.even);
    EXPECT_LE(t.residual.dense, t.majorant.dense);
    if (d == 0) continue;
    EXPECT_LE(t.majorant.even, s.depths[d - 1].tightness.majorant.even);
  }
}

// Where all leaves have the same mean, weights of the density change nothing, wherever the box cuts
// them: one sample spans 2^3 cells, in one leaf or in eight, and its bound is 8 times the mean.
TEST(Statistics, LeavesCountByWhatLiesInTheBox) {
  for (const std::size_t at : {std::size_t{3}, std::size_t{0}}) {
    VoxelGrid g;
    const auto values = std::make_shared<std::vector<float>>(kBrickSamples, 0.0f);
    (*values)[at * (64 + 8 + 1)] = 0.75f;
    g.bricks.push_back({{0, 0, 0}, values->data()});
    g.owner = values;
    const Pyramid p = build_pyramid(g);
    const BoundsStatistics s = measure_bounds(p, measure_content(g, p));
    const Tightness& finest = s.depths.back().tightness;
    EXPECT_NEAR(finest.majorant.even, 8, 1e-4) << at;
    EXPECT_NEAR(finest.majorant.dense, 8, 1e-4) << at;
    EXPECT_NEAR(s.global_majorant.dense, 8, 1e-4) << at;
  }
}

TEST(Statistics, GlobalMajorantCostsItsBoxOverTheMass) {
  const VoxelGrid g = make_noise(2);
  const Pyramid p = build_pyramid(g);
  const BoundsStatistics s = measure_bounds(p, measure_content(g, p));
  // Two bricks from 0 reach from cell -1 to 16 along x and to 8 along y and z.
  EXPECT_NEAR(s.global_majorant.even, double(p.scale) * 17 * 9 * 9 / s.mass, 1e-9);
}

TEST(Statistics, CutsAtADepthCostWhatTheDepthSays) {
  const VoxelGrid g = make_noise(9);
  const Pyramid p = build_pyramid(g);
  const PyramidContent content = measure_content(g, p);
  const BoundsStatistics s = measure_bounds(p, content);
  for (const DepthStatistics& d : s.depths) {
    const Tightness t = measure_cut(p, content, build(g, p, 3.5, d.depth), 3.5);
    EXPECT_NEAR(t.majorant.even, d.tightness.majorant.even, 1e-5 * t.majorant.even) << d.depth;
    EXPECT_NEAR(t.majorant.dense, d.tightness.majorant.dense, 1e-5 * t.majorant.dense) << d.depth;
    EXPECT_NEAR(t.residual.even, d.tightness.residual.even, 1e-5 * t.majorant.even) << d.depth;
    EXPECT_NEAR(t.residual.dense, d.tightness.residual.dense, 1e-5 * t.majorant.dense) << d.depth;
  }
}

TEST(Statistics, OfAnEmptyCloudAreZero) {
  const BoundsStatistics s = measure_bounds({}, measure_content({}, {}));
  EXPECT_TRUE(s.depths.empty());
  EXPECT_EQ(s.mass, 0);
}

}  // namespace statistics_test
}  // namespace pvol
