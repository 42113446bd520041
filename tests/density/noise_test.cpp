#include "pvol/density/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "density/noise_kernels.h"

namespace pvol {
namespace noise_test {

using Random = std::mt19937_64;

double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
Vec3d point(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
Vec3d point_in(Random& random, const Box& b) {
  Vec3d p;
  for (int i = 0; i < 3; ++i) {
    const double side = uniform(random, 0, 5);
    p[i] = side < 1 ? b.lo[i] : side < 2 ? b.hi[i] : uniform(random, b.lo[i], b.hi[i]);
    if (side > 4) p[i] = std::clamp(std::round(p[i]), b.lo[i], b.hi[i]);  // on a cell's border
  }
  return p;
}
Box random_box(Random& random, double place, double largest) {
  const Vec3d centre = point(random, place);
  Vec3d half;
  for (int i = 0; i < 3; ++i) half[i] = largest * std::exp(uniform(random, -12, 0));
  return {centre - half, centre + half};
}

TEST(Noise, IsZeroAtLatticePoints) {
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      for (int z = -3; z <= 3; ++z) EXPECT_EQ(gradient_noise(7, Vec3d(x, y, z)), 0);
    }
  }
}

TEST(Noise, StaysWithinOneAndComesNear) {
  Random random(1);
  double most = 0;
  for (int n = 0; n < 1000000; ++n) {
    most = std::max(most, std::abs(gradient_noise(3, point(random, 1000))));
  }
  EXPECT_LE(most, 1);
  EXPECT_GT(most, 0.7);
}

TEST(Noise, HasMeanZeroAndTheSameSpreadOnBothSides) {
  Random random(2);
  double sum = 0, squares = 0, cubes = 0;
  constexpr int kSamples = 400000;  // in as many different cells: independent
  for (int n = 0; n < kSamples; ++n) {
    const double v = gradient_noise(11, point(random, 1e6));
    sum += v;
    squares += v * v;
    cubes += v * v * v;
  }
  const double deviation = std::sqrt(squares / kSamples);
  EXPECT_GT(deviation, 0.15);
  EXPECT_LT(deviation, 0.35);
  EXPECT_NEAR(sum / kSamples, 0, 5 * deviation / std::sqrt(kSamples));
  EXPECT_NEAR(cubes / kSamples, 0, 5 * 4 * std::pow(deviation, 3) / std::sqrt(kSamples));
}

TEST(Noise, IsContinuousAcrossCellBorders) {
  Random random(3);
  for (int n = 0; n < 20000; ++n) {
    Vec3d p = point(random, 50);
    const int axis = n % 3;
    p[axis] = std::round(p[axis]);
    Vec3d q = p;
    q[axis] -= 1e-9;
    EXPECT_NEAR(gradient_noise(5, p), gradient_noise(5, q), 1e-8);
  }
}

TEST(Noise, DependsOnTheSeedAndHasNoShortPeriod) {
  int same_seed = 0, same_period = 0;
  for (int x = 0; x < 1000; ++x) {
    const Vec3d p{x + 0.5, 0.3, 0.7};
    same_seed += gradient_noise(1, p) == gradient_noise(2, p);
    same_period += gradient_noise(1, p) == gradient_noise(1, p + Vec3d{256, 0, 0});
  }
  EXPECT_LT(same_seed, 10);
  EXPECT_LT(same_period, 10);
}

TEST(Noise, HasTheseValues) {
  EXPECT_EQ(gradient_noise(1, {0.5, 0.5, 0.5}), 0.5103103630798288);
  EXPECT_EQ(gradient_noise(42, {-12.25, 3.75, 1e6 + 0.125}), 0.12388414932130926);
  EXPECT_EQ(fbm({.seed = 9, .cell = 0.5, .octaves = 5, .gain = 0.5}, {1.5, -2.25, 0.75}),
            0.20135611753363972);
  EXPECT_EQ(
      fbm({.seed = 9, .cell = 0.5, .octaves = 5, .gain = 0.5, .billow = true}, {1.5, -2.25, 0.75}),
      0.20653521205085115);
}

/// Whatever the lanes, and however far from the origin: recipes are the same on every machine.
TEST(Noise, KernelsGiveTheBitsOfSinglePoints) {
  std::vector<detail::FbmKernel> kernels = detail::fbm_kernels();
  kernels.push_back(detail::find_fbm);
  Random random(8);
  for (int n = 0; n < 400; ++n) {
    const Fbm noise{.seed = random(),
                    .cell = std::exp(uniform(random, -3, 3)),
                    .octaves = 1 + n % kMaxOctaves,
                    .gain = uniform(random, 0.1, 1),
                    .billow = n % 3 == 0};
    detail::NoisePoints points;
    for (int k = 0; k < 1 + n % 50; ++k) {
      Vec3d p = point(random, n % 2 ? 5 : 1e6);
      if (k % 5 == 0) p = {std::round(p.x), p.y, std::round(p.z)};
      points.add(p);
    }
    for (const detail::FbmKernel kernel : kernels) {
      std::fill(points.noise.begin(), points.noise.end(), -2);
      kernel(noise, points);
      for (std::size_t k = 0; k < points.n; ++k) {
        const Vec3d p{points.x[k], points.y[k], points.z[k]};
        ASSERT_EQ(points.noise[k], fbm(noise, p)) << n << ' ' << k;
      }
    }
  }
}

TEST(Noise, RangeHoldsTheNoiseAtEveryPointOfTheBox) {
  Random random(4);
  for (int n = 0; n < 10000; ++n) {
    const Box b = random_box(random, n % 2 ? 5 : 1e5, 2.5);
    const Interval r = gradient_noise_range(17, b);
    for (int s = 0; s < 100; ++s) {
      ASSERT_TRUE(r.contains(gradient_noise(17, point_in(random, b)))) << n;
    }
  }
}

TEST(Noise, RangeShrinksWithTheBox) {
  Random random(5);
  for (int n = 0; n < 300; ++n) {
    const Vec3d centre = point(random, 20);
    for (double half = 0.1; half > 1e-6; half *= 0.5) {
      const Interval r = gradient_noise_range(17, {centre - Vec3d(half), centre + Vec3d(half)});
      EXPECT_LE(r.width(), 20 * half + 1e-12);
    }
  }
}

TEST(Noise, RangeOfALargeBoxIsThatOfAllSpace) {
  const Interval r = gradient_noise_range(1, {Vec3d(-1e9), Vec3d(1e9)});
  EXPECT_TRUE(r.contains(-1) && r.contains(1));
  EXPECT_NEAR(r.width(), 2, 1e-9);
}

TEST(Fbm, RangeHoldsTheSumAtEveryPointOfTheBox) {
  Random random(6);
  for (int n = 0; n < 2000; ++n) {
    const Fbm noise{random(), std::exp(uniform(random, -3, 3)), 1 + n % 7, uniform(random, 0.2, 1),
                    n % 2 == 0};
    const Box b = random_box(random, 10, noise.cell);
    const Interval r = fbm_range(noise, b), all = fbm_range(noise);
    EXPECT_LE(all.lo, r.lo);
    EXPECT_GE(all.hi, r.hi);
    for (int s = 0; s < 100; ++s) {
      ASSERT_TRUE(r.contains(fbm(noise, point_in(random, b)))) << n;
    }
  }
}

TEST(Fbm, StaysInItsStatedRange) {
  for (const int octaves : {1, 3, kMaxOctaves}) {
    const Interval smooth = fbm_range({.octaves = octaves});
    EXPECT_NEAR(smooth.lo, -1, 1e-9);
    EXPECT_NEAR(smooth.hi, 1, 1e-9);
    const Interval billow = fbm_range({.octaves = octaves, .billow = true});
    EXPECT_NEAR(billow.lo, 0, 1e-9);
    EXPECT_NEAR(billow.hi, 1, 1e-9);
  }
}

TEST(Fbm, OfOneOctaveIsNoiseOfThatCellSize) {
  Random random(7);
  const Fbm coarse{.seed = 3, .cell = 2, .octaves = 1}, fine{.seed = 3, .cell = 1, .octaves = 1};
  for (int n = 0; n < 1000; ++n) {
    const Vec3d p = point(random, 10);
    EXPECT_EQ(fbm(coarse, p * 2.0), fbm(fine, p));
  }
}

}  // namespace noise_test
}  // namespace pvol
