#include "pvol/bounds/distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pvol/measure/probe.h"
#include "support/cloud_scene.h"
#include "support/fields.h"

namespace pvol {
namespace distribution_test {

using test::CloudScene;

struct Measured {
  Pyramid pyramid;
  BoundsStatistics bounds;
  std::vector<DepthDistributions> depths;
};

Measured measured(const VoxelGrid& grid) {
  Measured m;
  m.pyramid = build_pyramid(grid);
  const PyramidContent content = measure_content(grid, m.pyramid);
  m.bounds = measure_bounds(m.pyramid, content);
  m.depths = measure_distributions(m.pyramid, content);
  return m;
}

double total(const Distribution& d) {
  return std::accumulate(d.share.begin(), d.share.end(), d.below + d.above);
}

/// The least and the largest mean that the bins allow, where nothing lies outside them.
std::pair<double, double> mean_range(const Distribution& d) {
  double lo = 0, hi = 0;
  for (std::size_t i = 0; i < Distribution::kBins; ++i) {
    lo += d.share[i] * Distribution::edge(i), hi += d.share[i] * Distribution::edge(i + 1);
  }
  return {lo, hi};
}

TEST(Distribution, SharesAddUpAndQuantilesAscend) {
  for (const test::Field& f : test::fields()) {
    for (const DepthDistributions& d : measured(f.grid).depths) {
      for (const TwoDistributions* t : {&d.hi, &d.lo, &d.gap}) {
        for (const Distribution* one : {&t->by_volume, &t->by_mass}) {
          EXPECT_NEAR(total(*one), 1, 1e-9) << f.name;
          EXPECT_TRUE(std::is_sorted(one->quantiles.begin(), one->quantiles.end())) << f.name;
        }
      }
      EXPECT_GE(d.hi.by_volume.quantiles[0], 1 - 1e-6) << f.name;  // no majorant below the mean
      EXPECT_LE(d.lo.by_volume.quantiles[4], 1 + 1e-6) << f.name;
    }
  }
}

TEST(Distribution, ByMassItsMeanIsTheIntegralOfTheBoundOverTheMass) {
  for (const char* name : {"gaussian", "linear", "exponential"}) {
    SCOPED_TRACE(name);
    const Measured m = measured(test::field(name).grid);
    int compared = 0;
    for (std::size_t i = 0; i < m.depths.size(); ++i) {
      const Distribution& d = m.depths[i].hi.by_mass;
      if (d.below > 0 || d.above > 0) continue;
      ++compared;
      const auto [lo, hi] = mean_range(d);
      EXPECT_LE(lo, m.bounds.depths[i].tightness.majorant.even * (1 + 1e-9));
      EXPECT_GE(hi, m.bounds.depths[i].tightness.majorant.even * (1 - 1e-9));
    }
    EXPECT_GT(compared, 0);
  }
}

TEST(Distribution, RatiosAreThoseOfTheBoundsToTheMean) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(8);
  p.levels = {{{0, 0.25f, 1}}};
  const PyramidContent content{{{.mass = 0.5 * 512, .leaf = true}}};
  const DepthDistributions d = measure_distributions(p, content).at(0);
  const auto expect_one = [](const TwoDistributions& t, double ratio, std::size_t bin) {
    for (const Distribution& one : {t.by_volume, t.by_mass}) {
      for (const double q : one.quantiles) EXPECT_DOUBLE_EQ(q, ratio);
      EXPECT_EQ(one.share[bin], 1);
    }
  };
  expect_one(d.hi, 2, 44);
  expect_one(d.lo, 0.5, 36);
  expect_one(d.gap, 1.5, 42);
}

TEST(Distribution, RatiosBeyondAllBinsAreCountedApart) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(8);
  p.levels = {{{0, 0, 1}}};
  const PyramidContent content{{{.mass = 0x1p-16 * 512, .leaf = true}}};
  const DepthDistributions d = measure_distributions(p, content).at(0);
  EXPECT_EQ(d.hi.by_mass.above, 1);  // 2^16 is the edge, and not below it
  EXPECT_EQ(d.lo.by_mass.below, 1);
}

/// A share that is reached exactly is the quantile's: half of the volume does not exceed 2.
TEST(Distribution, MedianOfTwoEqualHalvesIsTheLower) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = {16, 8, 8};
  p.levels = {{{0, 0, 1}, {1, 0, 1}}, {{0, 0, 1}}};
  const PyramidContent content{
      {{.mass = 0.25 * 512, .leaf = true}, {.mass = 0.5 * 512, .leaf = true}},
      {{.mass = 0.75 * 512, .leaf = false}}};
  const DepthDistributions d = measure_distributions(p, content).at(1);
  EXPECT_EQ(d.hi.by_volume.quantiles, (std::array<double, 5>{2, 2, 2, 4, 4}));
}

TEST(Distribution, OfAUniformCubeIsOne) {
  VoxelGrid g;
  g.tiles.push_back({{0, 0, 0}, 128, 0.5f});
  const Measured m = measured(g);
  const DepthDistributions& leaves = m.depths.back();
  // Most of the volume is inside, where both bounds are the density.
  EXPECT_NEAR(leaves.hi.by_mass.quantiles[1], 1, 1e-3);
  EXPECT_NEAR(leaves.lo.by_mass.quantiles[3], 1, 1e-3);
  EXPECT_LT(leaves.gap.by_mass.quantiles[2], 1e-3);
}

TEST(Distribution, EdgesAreFourToAFactorOfTwo) {
  EXPECT_DOUBLE_EQ(Distribution::edge(0), std::exp2(-10));
  EXPECT_DOUBLE_EQ(Distribution::edge(40), 1);
  EXPECT_DOUBLE_EQ(Distribution::edge(44), 2);
  EXPECT_DOUBLE_EQ(Distribution::edge(Distribution::kBins), 65536);
}

TEST(Distribution, EmptySpaceOfTheBoxIsWhatNoCubeHolds) {
  VoxelGrid g;  // a tile fills its box but for the rim of one cell
  g.tiles.push_back({{0, 0, 0}, 8, 1.0f});
  EXPECT_EQ(empty_share_of_box(build_pyramid(g)), 0);
  g.tiles.push_back({{56, 0, 0}, 8, 1.0f});
  // Cells from -1 to 64 along x; leaves hold [-8, 8) and [48, 64).
  EXPECT_NEAR(empty_share_of_box(build_pyramid(g)), 40.0 / 65, 1e-12);
}

/// A ball of noise.
test::Field ball() {
  return test::make_field("ball", {0, 0, 0}, Vec3i(40), [](Vec3i p) {
    const double edge = 1 - length(Vec3d(p) - Vec3d(20)) / 18;
    return edge <= 0 ? 0.0
                     : std::min(1.0, 4 * edge) * (0.5 + 0.5 * to_uniform_double(mix64(std::uint64_t(
                                                                  p.x * 10007 + p.y * 101 + p.z))));
  });
}

TEST(Probe, ThinCloudsCostWhatTheirBoundsLeadToExpect) {
  const test::Field f = ball();
  const Pyramid p = build_pyramid(f.grid);
  measure::ProbeOptions options;
  options.extinction = 1e-3;  // one collision in a hundred rays: light reaches every place alike
  options.width = 96;
  options.samples = 128;
  const measure::Probe probe = measure::probe(f.grid, p, options);
  CloudScene scene;
  scene.medium.extinction = *options.extinction;
  const Volume v = make_volume(f.grid, p, scene);
  const Tightness t =
      measure_cut(p, measure_content(f.grid, p), v.density.octree, *options.extinction);
  // Perspective favours what is near, which changes little for a ball.
  const auto near = [](const measure::CountRatio& r, double expected) {
    return std::abs(r.value - expected) < 2 * r.half_width + 0.03 * expected;
  };
  EXPECT_TRUE(near(probe.delta.lookups, t.majorant.even))
      << probe.delta.lookups.value << ' ' << t.majorant.even;
  EXPECT_TRUE(near(probe.decomposition.lookups, t.residual.even))
      << probe.decomposition.lookups.value << ' ' << t.residual.even;
}

TEST(Probe, CountsAreInOrderAndIntervalsHoldTheTruth) {
  const test::Field f = ball();
  const Pyramid p = build_pyramid(f.grid);
  measure::ProbeOptions options;
  options.width = 64;
  const measure::Probe few = measure::probe(f.grid, p, options);
  options.samples = 128;
  const measure::Probe many = measure::probe(f.grid, p, options);
  EXPECT_EQ(few.extinction, many.extinction);
  const double* t = few.facts.mean_optical_thickness;
  EXPECT_NEAR((t[0] + t[1] + t[2]) / 3, 10, 1e-9);
  EXPECT_LT(few.squeezed.lookups.value, few.decomposition.lookups.value);
  EXPECT_LT(few.decomposition.lookups.value, few.delta.lookups.value);
  EXPECT_NEAR(few.delta.lookups.value, few.delta.tentative, 1e-12);
  EXPECT_EQ(few.delta.counts.shadow_rays, 0u);
  EXPECT_GT(few.squeezed.micro_bytes, 0u);
  for (const auto& [a, b] :
       {std::pair(few.delta, many.delta), std::pair(few.decomposition, many.decomposition),
        std::pair(few.squeezed, many.squeezed)}) {
    EXPECT_LT(std::abs(a.lookups.value - b.lookups.value),
              2 * (a.lookups.half_width + b.lookups.half_width));
    EXPECT_GT(a.lookups.half_width, b.lookups.half_width);  // by 4, on average
  }
}

}  // namespace distribution_test
}  // namespace pvol
