// A cloud that only scatters, in light that comes alike from everywhere, is in equilibrium:
// radiance is the same at every place and in every direction, whatever the density. So tentative
// collisions spread like the majorant and real ones like the extinction, and their ratio is known
// exactly.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/bounds/integrals.h"
#include "pvol/track/flight.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/extinction_source.h"
#include "support/flights.h"
#include "support/statistics.h"

namespace pvol::test {
namespace equilibrium_test {

/// A cloud-like field: a noisy ball with a soft edge and clear air around it.
Field make_cloud() {
  return make_field("cloud", {-30, -30, -30}, {61, 61, 61}, [](Vec3i p) {
    const Vec3d q(p);
    const double bumps = std::sin(0.9 * q.x) * std::sin(0.7 * q.y) * std::sin(0.8 * q.z);
    return std::clamp(1.2 - length(q) / 24 + 0.4 * bumps, 0.0, 1.0);
  });
}

Vec3f isotropic(Rng& rng) {
  const auto [a, b] = rng.uniform2();
  const double z = 2 * double(a) - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
  const double azimuth = 2 * std::numbers::pi * double(b);
  return Vec3f(Vec3d(r * std::cos(azimuth), r * std::sin(azimuth), z));
}

/// A ray of isotropic light entering a box: faces by area, cosine-weighted directions.
Ray entering(const Box& box, Rng& rng) {
  const Vec3d e = box.extent();
  const double area[3] = {e.y * e.z, e.z * e.x, e.x * e.y};
  double pick = double(rng.uniform()) * (area[0] + area[1] + area[2]);
  int axis = 0;
  while (axis < 2 && pick >= area[axis]) pick -= area[axis++];
  const auto [u, w] = rng.uniform2();
  const auto [a, b] = rng.uniform2();
  const bool low = rng.uniform() < 0.5f;
  const double cosine = std::sqrt(1 - double(a)), sine = std::sqrt(double(a));
  const double azimuth = 2 * std::numbers::pi * double(b);
  const int second = (axis + 1) % 3, third = (axis + 2) % 3;
  Ray ray;
  ray.o[axis] = low ? box.lo[axis] : box.hi[axis];
  ray.o[second] = box.lo[second] + double(u) * e[second];
  ray.o[third] = box.lo[third] + double(w) * e[third];
  ray.d[axis] = low ? cosine : -cosine;
  ray.d[second] = sine * std::cos(azimuth);
  ray.d[third] = sine * std::sin(azimuth);
  return ray;
}

/// What happened on a path.
struct PathCounts {
  double lookups, collisions;
};

template <Tracker kTracker, class Field>
PathCounts follow(const Volume& v, const Field& field, Rng& rng) {
  const Ray ray = entering(v.density.octree.support(), rng);
  Cursor cursor = make_cursor(v.density.octree, ray.o);
  Vec3f d(ray.d);
  Tally tally;
  double collisions = 0;
  for (;;) {
    Walk walk(v.density.octree, cursor, widen(d));
    const Flight f = free_flight<kTracker>(walk, field, rng, tally);
    if (!f.collided) return {double(tally.lookups), collisions};
    ++collisions;
    cursor = walk.stop_at(walk.point(f.t));
    d = isotropic(rng);
  }
}

/// The claim lookups = ratio x collisions, in expectation, as a t-test of the difference by path;
/// and the mean number of collisions, which is the mean chord 4 V / S times the mean extinction.
template <Tracker kTracker>
void test_equilibrium(const Volume& v, double density_sum, const std::string& name,
                      proof::Family& family) {
  const int paths = proof::samples(50'000);
  const BoundIntegrals bounds = integrate_bounds(v.density.octree);
  const double mass = double(v.density.scale) * density_sum;
  const double lookups = kTracker == Tracker::decomposition ? bounds.hi - bounds.lo : bounds.hi;
  const Vec3d e = v.density.octree.support().extent();
  const double surface = 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
  proof::Moments excess, collisions;
  for (int i = 0; i < paths; ++i) {
    Rng rng(kSeed, std::uint64_t(v.density.octree.depth) * 3 + std::uint64_t(kTracker),
            std::uint64_t(i));
    const PathCounts c = follow<kTracker>(v, exact<LookUp::trilinear>(v), rng);
    excess.add(c.lookups - lookups / mass * c.collisions);
    collisions.add(c.collisions);
  }
  const double rounding = 1e-5 * 4 * mass / surface;
  family.add(name + ", look-ups", proof::mean_p_value(excess, 0, rounding * lookups / mass));
  family.add(name + ", collisions", proof::mean_p_value(collisions, 4 * mass / surface, rounding));
}

TEST(Equilibrium, CountsAreVolumeIntegralsOfBounds) {
  const Field cloud = make_cloud();
  proof::Family family;
  for (const double extinction : {0.1, 1.0}) {
    for (const Choice& c : choices()) {
      const Volume v = make_test_volume(cloud, extinction, c.depth, c.tracker);
      const std::string name = c.name + ", extinction " + std::to_string(extinction);
      with_tracker(c.tracker, [&](auto constant) {
        test_equilibrium<decltype(constant)::value>(v, cloud.sum, name, family);
      });
    }
  }
  EXPECT_TRUE(family.passes());
}

/// The same with micro-bounds: what they leave open, within the bounds of the walk, is looked up.
template <Squeeze kSqueeze>
void test_squeeze(const Volume& v, double density_sum, const std::string& name,
                  proof::Family& family) {
  const int paths = proof::samples(700'000, 2);
  const auto field = make_field<LookUp::trilinear, kSqueeze>(v.density);
  const double lookups = integrate_open(v) / (double(v.density.scale) * density_sum);
  proof::Moments excess, collisions;
  for (int i = 0; i < paths; ++i) {
    Rng rng(kSeed, std::uint64_t(100 + 4 * int(kSqueeze) + v.density.micro.edge), std::uint64_t(i));
    const PathCounts c = follow<Tracker::decomposition>(v, field, rng);
    excess.add(c.lookups - lookups * c.collisions);
    collisions.add(c.collisions);
  }
  const double rounding = 1e-5 * lookups * collisions.mean();
  family.add(name, proof::mean_p_value(excess, 0, rounding));
  // An error of 1.5 % would be found, on a commit one of 2 %: five standard errors are less. Codes
  // leave few look-ups.
  const double found = (proof::runs_all() ? 0.015 : 0.02) * (kSqueeze == Squeeze::codes ? 4 : 1);
  EXPECT_LT(5 * std::sqrt(excess.variance_of_mean()), found * lookups * collisions.mean()) << name;
}

TEST(Equilibrium, MicroBoundsAndCodesLeaveTheirIntegralOpen) {
  const Field cloud = make_cloud();
  proof::Family family;
  for (const std::optional<int> depth : {std::optional<int>(), std::optional(1)}) {
    Volume v = make_test_volume(cloud, 0.3, depth, Tracker::decomposition);
    v.density.codes.reset();
    const double plain = integrate_open(v);
    const std::string name = depth ? ", shallow" : ", by cost";
    v.density.micro = build_micro_bounds(v.density.bricks(), 2);
    EXPECT_LT(integrate_open(v), plain);
    test_squeeze<Squeeze::micro_bounds>(v, cloud.sum, "2" + name, family);
    v.density.micro = build_micro_bounds(v.density.bricks(), 1);
    EXPECT_LT(integrate_open(v), plain);
    test_squeeze<Squeeze::micro_bounds>(v, cloud.sum, "1" + name, family);
    v.density.codes = std::make_shared<const SampleCodes>(build_sample_codes(v.density.bricks()));
    EXPECT_LT(integrate_open(v), 0.03 * plain);
    test_squeeze<Squeeze::codes>(v, cloud.sum, "codes" + name, family);
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace equilibrium_test
}  // namespace pvol::test
