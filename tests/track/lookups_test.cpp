// How many look-ups trackers make, against theory.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/track/flight.h"
#include "support/flights.h"
#include "support/segment_list.h"
#include "support/statistics.h"

namespace pvol::test {
namespace lookups_test {

/// Two segments with a gap; mu_t goes from lo to hi and back as a sine over each.
const std::vector<Segment> kTwoSegments{{0.5, 2, 0.25, 0.75, 0}, {3, 4, 0.5, 2, 0}};

double extinction_at(const Segment& s, double t) {
  const double x = (t - s.t0) / (s.t1 - s.t0);
  return double(s.lo) + double(s.hi - s.lo) * (0.5 - 0.5 * std::cos(12 * x));
}

/// Expectations along a free flight: int T over each segment, by the midpoint rule.
struct Expected {
  double delta = 0;          ///< int hi T
  double decomposition = 0;  ///< int (hi - lo) T
  double collisions = 0;     ///< int mu_t T
};
Expected expected_lookups() {
  constexpr int kSteps = 20'000;
  Expected e;
  double depth = 0;
  for (const Segment& s : kTwoSegments) {
    const double dt = (s.t1 - s.t0) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const double step = extinction_at(s, s.t0 + (i + 0.5) * dt) * dt;
      const double mean_transmittance = std::exp(-depth - 0.5 * step);
      e.delta += double(s.hi) * mean_transmittance * dt;
      e.decomposition += double(s.hi - s.lo) * mean_transmittance * dt;
      e.collisions += step * mean_transmittance;
      depth += step;
    }
  }
  return e;
}

struct Counts {
  proof::Moments lookups, collisions;
  Tally tally;
};

template <Tracker kTracker, class MakeSegments, class F>
Counts count_flights(int flights, const MakeSegments& make_segments, const F& field) {
  Counts c;
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, std::uint64_t(kTracker), std::uint64_t(i));
    auto segments = make_segments();
    Tally one;
    const Flight t = free_flight<kTracker>(segments, field, rng, one);
    c.lookups.add(double(one.lookups));
    c.collisions.add(t.collided ? 1 : 0);
    c.tally.lookups += one.lookups;
    c.tally.bounds_tests += one.bounds_tests;
    c.tally.null_collisions += one.null_collisions;
    c.tally.segments += one.segments;
  }
  return c;
}

TEST(Lookups, AreCountedUp) {
  Tally t;
  t.lookup(), t.bounds_test(), t.segment(), t.null_collision();
  EXPECT_EQ(t.lookups, 1u);
  EXPECT_EQ(t.bounds_tests, 1u);
  EXPECT_EQ(t.segments, 1u);
  EXPECT_EQ(t.null_collisions, 1u);
}

TEST(Lookups, AreTheIntegralsOfMajorantAndResidual) {
  const int kFlights = proof::samples<int>(400'000);
  const auto segments = [] { return SegmentList{kTwoSegments}; };
  const PlainField field{[](const Segment& s, const LatticePoint& p) {
    return float(extinction_at(s, double(p.frac[0])));
  }};
  const auto delta = count_flights<Tracker::delta>(kFlights, segments, field);
  const auto decomposed = count_flights<Tracker::decomposition>(kFlights, segments, field);
  const Expected e = expected_lookups();
  constexpr double kRounding = 1e-5;
  proof::Family family;
  family.add("delta", proof::mean_p_value(delta.lookups, e.delta, kRounding));
  family.add("decomposition", proof::mean_p_value(decomposed.lookups, e.decomposition, kRounding));
  family.add("collisions, delta", proof::mean_p_value(delta.collisions, e.collisions, kRounding));
  family.add("collisions, decomposition",
             proof::mean_p_value(decomposed.collisions, e.collisions, kRounding));
  EXPECT_TRUE(family.passes());
}

TEST(Lookups, TalliesAddUp) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, 16);
  const Aim a = aim(f, v, LookUp::trilinear, 0, 3);
  constexpr int kFlights = 20'000;
  const auto trilinear = exact<LookUp::trilinear>(v);
  std::uint64_t collisions = 0;
  Tally delta, decomposed;
  for (int i = 0; i < kFlights; ++i) {
    for (Tally* tally : {&delta, &decomposed}) {
      Rng rng(kSeed, 3, std::uint64_t(i));
      Cursor cursor = a.cursor;
      Walk walk(v.density.octree, cursor, a.direction);
      const bool hit =
          tally == &delta
              ? free_flight<Tracker::delta>(walk, trilinear, rng, *tally).collided
              : free_flight<Tracker::decomposition>(walk, trilinear, rng, *tally).collided;
      if (tally == &delta) collisions += hit;
    }
  }
  // With the same random numbers both decide alike; only where they look differs.
  EXPECT_EQ(delta.lookups, delta.null_collisions + collisions);
  EXPECT_EQ(delta.bounds_tests, 0u);
  EXPECT_EQ(decomposed.bounds_tests, delta.lookups);
  EXPECT_EQ(decomposed.null_collisions, delta.null_collisions);
  EXPECT_EQ(decomposed.segments, delta.segments);
  EXPECT_LT(decomposed.lookups, delta.lookups);
}

/// Inside a chequered cube of densities lo and hi, where every leaf has these bounds.
TEST(Lookups, DecompositionSavesTheShareOfTheMinorant) {
  for (const double lo : {0.9, 0.5, 0.125}) {
    const Field f = make_field("chequered", {0, 0, 0}, {40, 40, 40},
                               [lo](Vec3i p) { return (p.x + p.y + p.z) & 1 ? 1.0 : lo; });
    const Volume v = make_test_volume(f, 5, 16);
    const auto trilinear = exact<LookUp::trilinear>(v);
    const Cursor start =
        make_cursor(v.density.octree, Vec3d(20.25, 20.5, 20.75) - Vec3d(v.density.octree.origin));
    Cursor probe = start;
    const auto leaf = Walk(v.density.octree, probe, widen(Vec3f(1, 0, 0))).next();
    ASSERT_TRUE(leaf);
    const double share = 1 - double(leaf->lo) / double(leaf->hi);
    EXPECT_NEAR(share, 1 - lo, 0x1p-10);  // the code of bounds rounds outward
    std::uint64_t lookups[3] = {0, 0, 0};
    const auto fly = [&]<Tracker kTracker>(std::uint64_t i, std::size_t which) {
      Rng rng(kSeed, which, i);
      const auto [x, y] = rng.uniform2();
      Walk walk(v.density.octree, start, widen(normalize(Vec3f(x - 0.5f, y - 0.5f, 0.25f))));
      Tally tally;
      const Flight flight = free_flight<kTracker>(walk, trilinear, rng, tally);
      EXPECT_LT(flight.t, 10);  // before the leaves at the border
      lookups[which] += tally.lookups;
    };
    for (std::uint64_t i = 0; i < 600'000; ++i) {
      fly.operator()<Tracker::delta>(i, 0);
      fly.operator()<Tracker::decomposition>(i, 1);
      fly.operator()<Tracker::weighted_decomposition>(i, 2);
    }
    EXPECT_NEAR(double(lookups[1]) / double(lookups[0]) / share, 1, 0.01) << lo;
    EXPECT_NEAR(double(lookups[2]) / double(lookups[0]) / share, 1, 0.01) << lo;
  }
}

}  // namespace lookups_test
}  // namespace pvol::test
