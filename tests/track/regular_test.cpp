// Closed forms against the oracle, which shares no code with them.
#include "pvol/track/regular.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/track/transmittance.h"
#include "support/flights.h"

namespace pvol::test {
namespace regular_test {

TEST(BernsteinCubic, IsItsPolynomial) {
  const BernsteinCubic c{{1, 0, 5, 2}};  // 1 - 3x + 18x^2 - 14x^3
  for (const double x : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(c(x), 1 + x * (-3 + x * (18 - 14 * x)), 1e-14);
    EXPECT_NEAR(c.integral(x), x * (1 + x * (-1.5 + x * (6 - 3.5 * x))), 1e-14);
  }
}

/// Areas from next to nothing to all but nothing of random cubics, many of them with zeros.
TEST(BernsteinCubic, InvertsItsIntegral) {
  Rng rng(kSeed, 1, 1);
  for (int i = 0; i < 100'000; ++i) {
    BernsteinCubic c;
    for (double& b : c.b) b = rng.uniform() < 0.4f ? 0 : std::exp2(-60.0 * double(rng.uniform()));
    const double all = c.integral(1);
    if (all == 0) continue;
    const double share = rng.uniform() < 0.2f ? std::exp2(-50.0 * double(rng.uniform()))
                                              : to_uniform_double(rng.block().lo);
    const double x = c.inverse_integral(share * all);
    ASSERT_TRUE(x >= 0 && x <= 1) << x;
    ASSERT_NEAR(c.integral(x), share * all, 1e-14 * all) << i;
  }
}

/// What rounding of positions to 2^-24 cells leaves of an optical depth, relative to the largest
/// density on the way: a few per cell crossed.
constexpr double kRelative = 4e-6;

template <LookUp kLookUp>
void test_all() {
  for (const Field& f : fields()) {
    for (const std::optional<int> depth : {std::optional<int>(16), std::optional<int>(0)}) {
      const Volume v = make_test_volume(f, 1, depth);
      for (int ray = 0; ray < kRays; ++ray) {
        SCOPED_TRACE(f.name + ", ray " + std::to_string(ray));
        constexpr double kDepth = 3;
        const Aim a = aim(f, v, kLookUp, ray, kDepth);
        const auto trilinear = exact<kLookUp>(v);
        NoTally none;
        Walk through(v.density.octree, a.cursor, a.direction);
        const double all = a.oracle.optical_depth();
        EXPECT_NEAR(optical_depth(through, trilinear, none), all, kRelative * all);
        for (const double share : {1e-9, 1e-4, 0.1, 0.3, 0.5, 0.9, 0.9999}) {
          Walk walk(v.density.octree, a.cursor, a.direction);
          const auto t = regular_flight(walk, trilinear, share * all, none);
          ASSERT_TRUE(t);
          EXPECT_NEAR(a.oracle.optical_depth(*t), share * all, kRelative * all) << share;
        }
        Walk beyond(v.density.octree, a.cursor, a.direction);
        EXPECT_FALSE(regular_flight(beyond, trilinear, 1.0001 * all, none));
      }
    }
  }
}

TEST(Regular, FollowsTheTrilinearOpticalDepth) { test_all<LookUp::trilinear>(); }
TEST(Regular, FollowsTheNearestOpticalDepth) { test_all<LookUp::nearest>(); }

TEST(Regular, TransmittanceTakesNoRandomNumbers) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, 16);
  const Aim a = aim(f, v, LookUp::trilinear, 0, 2);
  Rng rng(kSeed, 1, 1), same = rng;
  NoTally none;
  Walk walk(v.density.octree, a.cursor, a.direction);
  const float t = transmittance<Transmittance::regular, Tracker::delta>(
      walk, exact<LookUp::trilinear>(v), rng, none);
  EXPECT_NEAR(double(t), a.oracle.transmittance(), 1e-5 * a.oracle.transmittance());
  EXPECT_EQ(rng.block().lo, same.block().lo);
}

/// A look-up for each cell crossed: along an axis through a cube of 21 cells.
TEST(Regular, LooksUpEachCellOnce) {
  const Field& f = field("constant");
  const Volume v = make_test_volume(f, 1, 16);
  Walk walk(
      v.density.octree,
      make_cursor(v.density.octree, Vec3d(v.density.octree.support().lo) + Vec3d(0, 2.25, 3.5)),
      widen(Vec3f(1, 0, -0.0f)));
  Tally tally;
  EXPECT_NEAR(optical_depth(walk, exact<LookUp::trilinear>(v), tally), 20, 1e-5);
  EXPECT_TRUE(tally.lookups == 21 || tally.lookups == 22);  // walks end a little beyond the support
}

/// In faces and edges of cells, where the cell is either's.
TEST(Regular, IsRightInFacesAndEdges) {
  const Field& f = field("checkerboard");
  const Volume v = make_test_volume(f, 1, 16);
  const Vec3d low = v.density.octree.support().lo;
  for (const Vec3d at : {Vec3d(0, 8, 8), Vec3d(0, 8, 8.5), Vec3d(0, 9, 3.25), Vec3d(0, 1, 24)}) {
    for (const float y : {0.0f, -0.0f, 1.0f}) {
      const Vec3f d(1, y, 0);
      const Cursor cursor = make_cursor(v.density.octree, low + at);
      const RayOracle oracle(f, LookUp::trilinear,
                             {low + at + Vec3d(v.density.octree.origin), Vec3d(d)}, 1);
      Walk walk(v.density.octree, cursor, widen(d));
      NoTally none;
      EXPECT_NEAR(optical_depth(walk, exact<LookUp::trilinear>(v), none), oracle.optical_depth(),
                  1e-5 * (1 + oracle.optical_depth()))
          << at.y << " " << at.z << " " << y;
    }
  }
}

}  // namespace regular_test
}  // namespace pvol::test
