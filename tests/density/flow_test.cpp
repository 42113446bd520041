// Velocities in closed form, and velocities in parts.
#include "pvol/density/flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pvol/math/rng.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/velocities.h"

namespace pvol::test {
namespace flow_test {

TEST(Flow, IsTheSumOfItsParts) {
  const Flow flow{
      .velocity = {1, 2, 3}, .spin = {0, 0, 2}, .stretch = {0, 0.5, 0}, .centre = {10, 20, 30}};
  EXPECT_EQ(velocity_at(flow, {10, 20, 30}), Vec3d(1, 2, 3));
  // Against the clock as seen from the tip of z: x turns to y.
  EXPECT_EQ(velocity_at(flow, {11, 20, 30}), Vec3d(1, 4, 3));
  EXPECT_EQ(velocity_at(flow, {10, 21, 30}), Vec3d(-1, 2.5, 3));
  EXPECT_EQ(velocity_at(flow, {10, 20, 35}), Vec3d(1, 2, 3));
}

TEST(Flow, TurbulenceIsThreeNoisesWithinItsBound) {
  Flow flow{.turbulence = 3, .noise = {.seed = 5, .cell = 0.5}};
  Rng rng(1, 0, 0);
  Vec3d squares, products;
  for (int i = 0; i < 4000; ++i) {
    const Vec3d p = Vec3d(Vec3f{rng.uniform(), rng.uniform(), rng.uniform()}) * 20.0;
    const Vec3d v = velocity_at(flow, p);
    for (int c = 0; c < 3; ++c) {
      Fbm noise = flow.noise;
      noise.seed = 5 + std::uint64_t(c);
      EXPECT_EQ(v[c], 3 * fbm(noise, p));
      EXPECT_LE(std::abs(v[c]), 3);
    }
    squares += v * v;
    products += v * Vec3d(v.y, v.z, v.x);
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(squares[c] / 4000, 0.1);
    EXPECT_LT(std::abs(products[c]), 0.15 * squares[c]) << "components are independent";
  }
}

TEST(Flow, SamplesReachHalfABoxBeyondIt) {
  const Flow flow{.velocity = {1, -2, 0}, .spin = {0.3, -0.2, 1}, .centre = {1, 0, 0}};
  const Box box{{-1, 2, 5}, {3, 3, 6.5}};
  const VelocityGrid grid = sample_flow(flow, box, 0.125);
  EXPECT_EQ(grid.index_to_world(), scaling(Vec3d(0.125)));
  Rng rng(2, 0, 0);
  for (int i = 0; i < 500; ++i) {
    const Vec3d u(Vec3f{rng.uniform(), rng.uniform(), rng.uniform()});
    const Vec3d p = box.lo + box.extent() * (u * 2.0 - Vec3d(0.5));
    for (int c = 0; c < 3; ++c) {
      const VoxelGrid& g = grid.along[std::size_t(c)];
      const auto at = [&](Vec3i q) { return double(sample(g, q)); };
      EXPECT_NEAR(trilinear(at, p / 0.125), velocity_at(flow, p)[c], 1e-5);
    }
  }
}

TEST(Flow, OfNothingHasNoBricks) {
  const VelocityGrid grid = sample_flow({.velocity = {0, 1, 0}}, {{0, 0, 0}, {1, 1, 1}}, 0.1);
  EXPECT_TRUE(grid.along[0].bricks.empty());
  EXPECT_FALSE(grid.along[1].bricks.empty());
  EXPECT_TRUE(grid.along[2].bricks.empty());
}

TEST(Flow, WhatIsOutOfRangeIsNamed) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const auto refused = [&](const Flow& f, const Box& b = {{0, 0, 0}, {1, 1, 1}},
                           double voxel = 0.1) {
    return error_of([&] { (void)sample_flow(f, b, voxel); });
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refused({.velocity = {0, kNan, 0}}).find("velocity"), std::string::npos);
  EXPECT_NE(refused({.spin = {1e31, 0, 0}}).find("spin"), std::string::npos);
  EXPECT_NE(refused({.turbulence = -1}).find("turbulence"), std::string::npos);
  EXPECT_NE(refused({.noise = {.cell = 0}}).find("cell"), std::string::npos);
  EXPECT_NE(refused({.noise = {.octaves = 0}}).find("octaves"), std::string::npos);
  EXPECT_NE(refused({.noise = {.gain = 2}}).find("gain"), std::string::npos);
  EXPECT_NE(refused({}, {}).find("box"), std::string::npos);
  EXPECT_NE(refused({}, box, 0).find("voxel"), std::string::npos);
  EXPECT_NE(refused({}, box, 1e-4).find("512 voxels"), std::string::npos);
  EXPECT_TRUE(says(refused({.velocity = {1e30, 0, 0}, .stretch = {1e30, 0, 0}},
                           {{0, 0, 0}, {1e10, 1e10, 1e10}}, 1e9),
                   "flow.flow_velocity_exceeds"));
}

TEST(VelocityParts, JoinToWhatTheyWereMadeOf) {
  VelocityGrid v = make_velocity({-9, 0, 0}, {20, 10, 10}, [](Vec3i p) {
    return Vec3d(p.x - 3, p.y % 3 == 0 ? 0 : 2.5, p.z < 4 ? -1 : 0);
  });
  v.along[0].tiles = {{{128, 0, 0}, 128, -2}, {{0, 512, 0}, 8, 3}};
  v.along[2].tiles = {{{128, 0, 0}, 128, 5}};
  const auto parts = signed_parts(v);
  for (const VoxelGrid& part : parts) {
    for (const Brick& b : part.bricks) {
      for (int i = 0; i < kBrickSamples; ++i) EXPECT_GE(b.values[i], 0);
    }
    for (const Tile& t : part.tiles) EXPECT_GT(t.value, 0);
  }
  EXPECT_TRUE(parts[3].bricks.empty()) << "nothing moves down along y";
  const VelocityGrid joined = join_parts(parts);
  for (std::size_t c = 0; c < 3; ++c) {
    for (const Vec3i p : {Vec3i(130, 5, 7), Vec3i(255, 127, 127), Vec3i(3, 515, 2)}) {
      EXPECT_EQ(sample(joined.along[c], p), sample(v.along[c], p));
    }
    for (int i = 0; i < 40 * 12 * 12; ++i) {
      const Vec3i p(i % 40 - 15, i / 40 % 12, i / 480);
      ASSERT_EQ(sample(joined.along[c], p), sample(v.along[c], p)) << c << ' ' << i;
    }
  }
}

}  // namespace flow_test
}  // namespace pvol::test
