// Flights and transmittances by any tracker, with counts, beside the templates that they are made
// of.
#include "pvol/volume/counted_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/trackers.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/placed_clouds.h"

namespace pvol::test {
namespace counted_rays_test {

struct Counted {
  double t = 0;
  float weight = 0;
  Tally tally{};
  friend bool operator==(const Counted&, const Counted&) = default;
};

/// What run(walk, field, rng, counted) finds; nothing where the ray misses.
Counted by_template(const Volume& v, const Ray& ray, double t_max, Rng rng, const auto& run) {
  Counted c;
  const auto field = make_field<LookUp::trilinear, Squeeze::codes>(v.density);
  if (auto walk = enter(v, ray, t_max)) run(*walk, field, rng, c);
  return c;
}

/// Calls check(volume, ray, t_max, rng) for rays through a cloud in every placement.
void for_rays(const auto& check) {
  for (const Placement& p : placements()) {
    SCOPED_TRACE(p.name);
    const PlacedCloud cloud(field("gaussian"), p.to_world, 1 / cell_length(p.to_world),
                            {.micro_bounds = MicroBoundsUse::codes});
    ASSERT_EQ(squeeze_of(cloud.volume.density), Squeeze::codes);
    for (int i = 0; i < 100; ++i) {
      Rng rng(kPlacedSeed, 77, std::uint64_t(i));
      const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
      check(cloud.volume, ray, t_max, rng);
    }
  }
}

template <Tracker kTracker>
void expect_same_flights() {
  int collided = 0;
  for_rays([&](const Volume& v, const Ray& ray, double t_max, const Rng& rng) {
    const Counted expected = by_template(
        v, ray, t_max, rng, [](RayWalk& walk, const auto& field, Rng& numbers, Counted& c) {
          const Flight f = free_flight<kTracker>(walk, field, numbers, c.tally);
          c.t = f.collided ? f.t : 0, c.weight = f.weight;
        });
    Rng numbers = rng;
    Counted found;
    const Flight f = sample_flight(v, ray, t_max, numbers, kTracker, found.tally);
    found.t = f.collided ? f.t : 0, found.weight = f.weight;
    if (!enter(v, ray, t_max)) found.weight = 0;
    EXPECT_EQ(found, expected) << label(kTracker);
    collided += f.collided;
  });
  EXPECT_GT(collided, 100) << label(kTracker);
}

TEST(CountedRays, FlyAsTheTrackersDo) {
  expect_same_flights<Tracker::delta_global>();
  expect_same_flights<Tracker::decomposition>();
  expect_same_flights<Tracker::delta>();
  expect_same_flights<Tracker::weighted_delta>();
  expect_same_flights<Tracker::weighted_decomposition>();
  expect_same_flights<Tracker::regular>();
}

template <Transmittance kEstimator, Tracker kTracker>
void expect_same_transmittances() {
  for_rays([&](const Volume& v, const Ray& ray, double t_max, const Rng& rng) {
    const Counted expected = by_template(
        v, ray, t_max, rng, [](RayWalk& walk, const auto& field, Rng& numbers, Counted& c) {
          c.weight = transmittance<kEstimator, kTracker>(walk, field, numbers, c.tally);
        });
    Rng numbers = rng;
    Counted found;
    found.weight = sample_transmittance(v, ray, t_max, numbers, kEstimator, found.tally);
    if (!enter(v, ray, t_max)) found.weight = 0;
    EXPECT_EQ(found, expected) << label(kEstimator);
  });
}

TEST(CountedRays, PassAsTheEstimatorsDo) {
  expect_same_transmittances<Transmittance::analog, Tracker::decomposition>();
  expect_same_transmittances<Transmittance::ratio, Tracker::delta>();
  expect_same_transmittances<Transmittance::residual_ratio, Tracker::delta>();
  expect_same_transmittances<Transmittance::regular, Tracker::delta>();
}

TEST(CountedRays, FindDepthsCellByCell) {
  for_rays([&](const Volume& v, const Ray& ray, double t_max, const Rng&) {
    Tally tally;
    const double depth = exact_optical_depth(v, ray, t_max, tally);
    EXPECT_EQ(std::exp(-depth), exact_transmittance(v, ray, t_max));
    EXPECT_EQ(depth > 0, tally.lookups > 0);
  });
}

/// call(tally) counts the same each time, beyond what the tally has.
void expect_adding(const auto& call) {
  Tally once, twice;
  call(once);
  call(twice), call(twice);
  EXPECT_GT(once.segments + once.lookups, 0u);
  const Tally expected{2 * once.lookups, 2 * once.bounds_tests, 2 * once.segments,
                       2 * once.null_collisions};
  EXPECT_EQ(twice, expected);
}

TEST(CountedRays, AddToEarlierCounts) {
  const PlacedCloud cloud(field("gaussian"), {}, 1);
  const Volume& v = cloud.volume;
  Rng aiming(kPlacedSeed, 1, 1);
  const Ray ray = cloud.aim(0, aiming).ray;
  expect_adding([&](Tally& tally) {
    Rng rng(1, 2, 3);
    (void)sample_flight(v, ray, kFar, rng, Tracker::delta, tally);
  });
  expect_adding([&](Tally& tally) {
    Rng rng(1, 2, 3);
    (void)sample_transmittance(v, ray, kFar, rng, Transmittance::ratio, tally);
  });
  expect_adding([&](Tally& tally) { (void)exact_optical_depth(v, ray, kFar, tally); });
}

TEST(CountedRays, AreRefusedClosedFormsThatThereAreNot) {
  FieldMap map;
  map.scale = 2;
  VolumeOptions tricubic, mapped;
  tricubic.look_up = LookUp::tricubic;
  mapped.map = std::make_shared<const FieldMap>(map);
  for (const VolumeOptions& o : {tricubic, mapped}) {
    const Volume v = make_volume(field("gaussian").grid, Medium{}, o);
    const Ray ray{{0, 0, 0}, {1, 0, 0}};
    Rng rng(1, 2, 3);
    Tally tally;
    const auto flight = [&] { (void)sample_flight(v, ray, kFar, rng, Tracker::regular, tally); };
    const auto share = [&] {
      (void)sample_transmittance(v, ray, kFar, rng, Transmittance::regular, tally);
    };
    const auto depth = [&] { (void)exact_optical_depth(v, ray, kFar, tally); };
    EXPECT_NE(error_of(flight).find("closed form"), std::string::npos);
    EXPECT_EQ(error_of(flight), error_of(share));
    EXPECT_EQ(error_of(flight), error_of(depth));
  }
}

}  // namespace counted_rays_test
}  // namespace pvol::test
