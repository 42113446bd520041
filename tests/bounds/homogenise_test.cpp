// Homogenised clouds: the mass stays, the stated bound on the error of optical depths holds, and
// what is left is a homogeneous medium to every tracker.
#include "pvol/bounds/homogenise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/embed.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/fields.h"
#include "support/pictures.h"
#include "support/statistics.h"

namespace pvol::test {
namespace homogenise_test {

constexpr double kCellDiagonal = 1.7320508075688772;

/// The integral over what walks can see of nodes that are all homogeneous.
double visible_mass(const Pyramid& p) {
  double sum = 0;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    for (const PyramidNode& n : p.levels[level]) {
      const std::int64_t edge = std::int64_t(kLeafEdge) << level;
      const Vec3l at = p.origin + Vec3l(morton_decode(n.code)) * edge;
      const Vec3l size = min(at + Vec3l(edge), p.support_hi) - max(at, p.support_lo);
      sum += double(n.lo) * double(size.x) * double(size.y) * double(size.z);
    }
  }
  return sum;
}

CloudScene scene_of(double extinction, std::optional<double> tolerance) {
  CloudScene s;
  s.medium.extinction = extinction;
  s.options.homogenise = tolerance;
  return s;
}

Volume volume_of(const Field& f, double extinction, std::optional<double> tolerance) {
  const CloudScene s = scene_of(extinction, tolerance);
  VolumeOptions o = s.volume_options();
  o.samples = SampleStorage::copied;
  return pvol::make_volume(f.grid, build_pyramid(f.grid), s.medium.medium(), o);
}

Ray random_line(const Volume& v, Rng& rng) {
  const auto u = [&] { return double(rng.uniform()); };
  const Vec3d size = v.density.world_box.extent();
  const auto inside = [&] { return v.density.world_box.lo + size * Vec3d(u(), u(), u()); };
  const Vec3d a = inside(), b = inside();
  const Vec3d d = normalize(b - a);
  return {a - d * (2 * length(size)), d};
}

TEST(Homogenise, KeepsTheMass) {
  for (const Field& f : fields()) {
    const Pyramid p = build_pyramid(f.grid);
    const PyramidContent content = measure_content(f.grid, p);
    const HomogenisedPyramid h = homogenise(p, content, 1, kCellDiagonal, 1e30);
    ASSERT_FALSE(h.pyramid.empty());
    if (!content.back()[0].uniform) {
      EXPECT_EQ(h.parts.nodes, 1u) << f.name;  // the root
      EXPECT_NEAR(h.parts.mass_share, 1, 1e-12) << f.name;
      EXPECT_NEAR(visible_mass(h.pyramid) / f.sum, 1, 1e-6) << f.name;
    }
  }
}

TEST(Homogenise, ChangesNothingWithoutTolerance) {
  for (const Field& f : fields()) {
    const Volume plain = volume_of(f, 0.3, std::nullopt), none = volume_of(f, 0.3, 0);
    EXPECT_EQ(none.density.homogeneous->nodes, 0u) << f.name;
    EXPECT_EQ(none.density.homogeneous->depth_error, 0) << f.name;
    EXPECT_EQ(plain.density.bricks().samples, none.density.bricks().samples) << f.name;
    EXPECT_EQ(plain.density.octree.terminals, none.density.octree.terminals) << f.name;
  }
}

TEST(Homogenise, BoundsTheErrorOfEveryRay) {
  for (const Field& f : fields()) {
    const Volume exact = volume_of(f, 0.3, std::nullopt);
    for (const double tolerance : {0.01, 0.3, 3.0, 100.0}) {
      const Volume v = volume_of(f, 0.3, tolerance);
      ASSERT_TRUE(v.density.homogeneous);
      Rng rng(11, std::uint64_t(tolerance * 100), 3);
      constexpr double kEverything = std::numeric_limits<double>::infinity();
      for (int i = 0; i < 300; ++i) {
        const Ray ray = random_line(exact, rng);
        const double a = -std::log(exact_transmittance(exact, ray, kEverything));
        const double b = -std::log(exact_transmittance(v, ray, kEverything));
        ASSERT_LE(std::abs(a - b), v.density.homogeneous->depth_error + 1e-5 * (a + 1))
            << f.name << ", tolerance " << tolerance;
      }
    }
  }
}

TEST(Homogenise, BoundsOneNodeByTheTolerance) {
  // One leaf of density 1/2 with a spot: whatever is replaced changes a depth by the tolerance at
  // most.
  const Field f = make_field("spot", {0, 0, 0}, {8, 8, 8},
                             [](Vec3i p) { return p == Vec3i(4, 4, 4) ? 0.75 : 0.5; });
  const Pyramid p = build_pyramid(f.grid);
  const PyramidContent content = measure_content(f.grid, p);
  const HomogenisedPyramid all = homogenise(p, content, 2, kCellDiagonal, 1e30);
  EXPECT_EQ(all.parts.nodes, 1u);
  const double needed = all.parts.depth_error;
  const auto nodes = [&](double tolerance) {
    return homogenise(p, content, 2, kCellDiagonal, tolerance).pyramid.levels.back()[0];
  };
  EXPECT_EQ(nodes(needed * 1.0001).lo, nodes(needed * 1.0001).hi);
  EXPECT_LT(nodes(needed * 0.9999).lo, nodes(needed * 0.9999).hi);
}

/// A line meets four octants of a cube at most; here those on one deviate, the first of them more
/// than the others together, so that their sum is below the root's own bound.
TEST(Homogenise, CountsFourOctantsOfANode) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(16);
  p.levels.resize(2);
  PyramidContent content(2);
  for (std::uint64_t code = 0; code < 8; ++code) {
    const bool on_line = (code & (code + 1)) == 0;  // 0, 1, 3 and 7: one step along an axis each
    const float d = code == 0 ? 0.375f : on_line ? 0.0625f : 0;
    p.levels[0].push_back({code, 0.5f - d, 0.5f + d});
    content[0].push_back({.mass = 0.5 * 512, .leaf = true, .uniform = !on_line});
  }
  p.levels[1] = {{0, 0.125f, 0.875f}};
  content[1] = {{.mass = 0.5 * 4096}};
  const double unit = 0.01;                 // of a cell's diagonal
  const double tolerance = 0.4 * 8 * unit;  // enough for leaves, not for the root
  const HomogenisedPyramid h = homogenise(p, content, 1, unit, tolerance);
  EXPECT_EQ(h.parts.nodes, 4u);
  EXPECT_EQ(h.parts.volume_share, 0.5);
  EXPECT_EQ(h.parts.mass_share, 0.5);
  EXPECT_NEAR(h.parts.depth_error, (0.375 + 3 * 0.0625) * 8 * unit, 1e-12);
}

TEST(Homogenise, RefusesBoundsThatDoNotHold) {
  const Field& f = field("gaussian");
  Pyramid p = build_pyramid(f.grid);
  for (PyramidNode& n : p.levels[0]) n.hi *= 0.9f;
  for (const Tracker tracker : {Tracker::decomposition, Tracker::weighted_delta}) {
    CloudScene s = scene_of(0.3, 0.5);
    s.options.tracker = tracker;
    EXPECT_THROW((void)make_volume(f.grid, p, s), Error);
  }
}

TEST(Homogenise, IsOneMediumToAllTrackers) {
  const Field& f = field("tiles_128");
  proof::Family family;
  std::optional<Average> first;
  for (const Tracker tracker : kTrackers) {
    CloudScene s = scene_of(0.4, 5.0);
    s.medium.albedo = Rgb(0.8f);
    s.environment = ConstantSky{Rgb(1.0f)};
    s.lights = {Sun{{0.3, 0.8, 0.4}, Rgb(2.0f), 0}};
    s.options.tracker = tracker;
    s.options.width = s.options.height = 24;
    s.options.samples = 96;
    s.options.seed = 7 + std::uint64_t(tracker);
    s.options.count = true;
    const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
    ASSERT_GT(v.density.homogeneous->mass_share, 0.1);
    ASSERT_LT(v.density.homogeneous->mass_share, 0.9);
    s.camera = frame(v.density.world_box, 1);
    const RenderResult r = render(v, s);
    const Average a = average(r.film);
    if (first) compare(a, *first, label(tracker), family);
    if (!first) first = a;
  }
  EXPECT_TRUE(family.passes());
}

TEST(Homogenise, NeedsNoLookUpsWhereAllIsHomogeneous) {
  CloudScene s = scene_of(0.4, 1e30);
  const Field& f = field("gaussian");
  const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
  s.camera = frame(v.density.world_box, 1);
  s.options.width = s.options.height = 16;
  s.options.samples = 16;
  s.options.count = true;
  const Counts c = render(v, s).counts;
  EXPECT_GT(c.collisions, 0u);
  EXPECT_EQ(c.path.lookups + c.shadow.lookups, 0u);
}

}  // namespace homogenise_test
}  // namespace pvol::test
