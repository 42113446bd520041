// Free flights against quadrature, and whether these tests would notice a wrong tracker.
#include "pvol/track/flight.h"

#include <gtest/gtest.h>

#include <map>

#include "support/flight_histogram.h"
#include "support/flights.h"

namespace pvol::test {
namespace flight_test {

constexpr auto kTrilinear = LookUp::trilinear;
/// `fly(walk, rng)` again and again.
template <class Fly>
FlightHistogram sample_flights(const Volume& v, const Aim& a, int flights, std::uint64_t stream,
                               const Fly& fly) {
  FlightHistogram histogram(a.oracle);
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, stream, std::uint64_t(i));
    Cursor cursor = a.cursor;
    Walk walk(v.density.octree, cursor, a.direction);
    histogram.add(fly(walk, rng));
  }
  return histogram;
}

template <LookUp kLookUp>
FlightHistogram sample_flights(const Volume& v, const Aim& a, int flights, std::uint64_t stream,
                               Tracker tracker) {
  return with_tracker(tracker, [&](auto constant) {
    return sample_flights(v, a, flights, stream, [&v](Walk& walk, Rng& rng) {
      NoTally none;
      return free_flight<decltype(constant)::value>(walk, exact<kLookUp>(v), rng, none);
    });
  });
}

/// Rays of one optical depth, so that their histograms add up.
constexpr double kDepth = 2;

/// Every tracker, depth, field and ray: each by itself, each tracker over all fields and rays, and
/// all together.
template <LookUp kLookUp>
void test_all(int flights) {
  proof::Family family, together;
  std::map<std::string, FlightHistogram> sums;
  std::uint64_t stream = 0;
  for (const Field& f : fields()) {
    for (const Choice& c : choices()) {
      const Volume v = make_test_volume(f, 1, c.depth, c.tracker);
      for (int ray = 0; ray < kRays; ++ray) {
        const Aim a = aim(f, v, kLookUp, ray, kDepth);
        const auto h = sample_flights<kLookUp>(v, a, flights, ++stream, c.tracker);
        family.add(f.name + ", ray " + std::to_string(ray) + ", " + c.name, h.p_value());
        for (const std::string& sum : {c.name, std::string("all together")}) {
          sums.try_emplace(sum, FlightHistogram(a.oracle)).first->second.add(h);
        }
      }
    }
  }
  for (const auto& [name, sum] : sums) together.add(name, sum.p_value());
  EXPECT_TRUE(family.passes());
  EXPECT_TRUE(together.passes());
}

TEST(Flight, DistancesFollowTheTrilinearOpticalDepth) {
  test_all<kTrilinear>(proof::samples(20'000));
}

TEST(Flight, DistancesFollowTheNearestOpticalDepth) { test_all<LookUp::nearest>(5'000); }

/// The p-value of a tracker over a few fields; the tests above have more flights by far.
template <class MakeFly>
double p_value_of(int flights, const MakeFly& make_fly) {
  std::optional<FlightHistogram> sum;
  std::uint64_t stream = 10'000;
  for (const char* name : {"gaussian", "linear", "exponential", "sparse", "tiles_8", "far"}) {
    const Volume v = make_test_volume(field(name), 1, std::nullopt);
    for (int ray = 0; ray < kRays; ++ray) {
      const Aim a = aim(field(name), v, kTrilinear, ray, kDepth);
      if (!sum) sum.emplace(a.oracle);
      sum->add(sample_flights(v, a, flights, ++stream, make_fly(v)));
    }
  }
  return sum->p_value();
}

const int kFew = proof::samples(10'000);
const int kMany = proof::samples(100'000);
constexpr double kCertain = 1e-6;

TEST(FlightProof, AcceptsTheTracker) {
  const auto right = [](const Volume& v) {
    return [&v](Walk& walk, Rng& rng) {
      NoTally none;
      return free_flight<Tracker::delta>(walk, exact<kTrilinear>(v), rng, none);
    };
  };
  EXPECT_GT(p_value_of(kMany, right), proof::kFalseAlarmRate);
}

/// On a commit by two, with as many flights as are to find them there.
TEST(FlightProof, FindsExtinctionWrongByOnePerCent) {
  const float error = proof::runs_all() ? 0.01f : 0.02f;
  for (const float factor : {1 - error, 1 + error}) {
    const auto wrong = [factor](const Volume& v) {
      return [&v, factor](Walk& walk, Rng& rng) {
        NoTally none;
        const PlainField field{[&](const Segment& s, const LatticePoint& p) {
          return factor * exact<kTrilinear>(v).source(s, p);
        }};
        return free_flight<Tracker::delta>(walk, field, rng, none);
      };
    };
    EXPECT_LT(p_value_of(kMany, wrong), kCertain) << factor;
  }
}

/// Forgets to subtract from the optical depth what a segment used up.
Flight fly_without_carry(Walk& walk, const Volume& v, Rng& rng) {
  Rng::Tentative next = rng.tentative();
  while (const auto s = walk.next()) {
    double t = s->t0;
    while (double(next.depth / s->hi) < s->t1 - t) {
      t += double(next.depth / s->hi);
      if (next.u * s->hi < exact<kTrilinear>(v).source(*s, walk.point(t))) return {t, 1, true};
      next = rng.tentative();
    }
  }
  return {};
}

double p_value_with_majorants_times(float factor) {
  return p_value_of(kFew, [factor](const Volume& v) {
    return [&v, factor](Walk& walk, Rng& rng) {
      NoTally none;
      ScaledSegments<Walk> segments{walk, factor};
      return free_flight<Tracker::decomposition>(segments, exact<kTrilinear>(v), rng, none);
    };
  });
}

TEST(FlightProof, FindsWrongMajorants) {
  EXPECT_LT(p_value_with_majorants_times(0.8f), kCertain);
  const auto careless = [](const Volume& v) {
    return [&v](Walk& walk, Rng& rng) { return fly_without_carry(walk, v, rng); };
  };
  EXPECT_LT(p_value_of(kFew, careless), kCertain);
}

TEST(Flight, DoesNotDependOnHowLooseMajorantsAre) {
  EXPECT_GT(p_value_with_majorants_times(2), proof::kFalseAlarmRate);
  EXPECT_GT(p_value_with_majorants_times(10), proof::kFalseAlarmRate);
}

/// From almost nothing in a voxel to a wall, distances in cells.
TEST(Flight, IsRightForAnyOpticalDepthOfAVoxel) {
  struct Case {
    double per_voxel;
    int flights;
  };
  // From outside, a flight takes about sqrt(depth of a voxel) tentative collisions.
  const std::vector<Case> cases{{1e-12, 1000},
                                {1e-6, proof::samples(300'000)},
                                {1e-3, proof::samples(20'000)},
                                {1, 2000},
                                {1e3, 2000},
                                {1e6, 200},
                                {1e9, 1},
                                {1e12, 1}};
  proof::Family family;
  std::uint64_t stream = 2000;
  std::size_t turn = 0;
  for (const char* name : {"constant", "one_voxel_on_a_border"}) {
    const Field& f = field(name);
    ++turn;
    for (const Choice& c : choices()) {
      ++turn;
      for (const auto& [per_voxel, flights] : cases) {
        const Volume v = make_test_volume(f, per_voxel, c.depth, c.tracker);
        for (int ray = 0; ray < kRays; ++ray) {
          ++stream;
          // A million collisions each: on a commit every choice comes from outside once or twice.
          if (per_voxel > 1e9 && ray < 2 && !proof::has_turn(turn + std::size_t(ray), 3)) continue;
          const int count = ray == 2 ? std::max(200, flights) : flights;  // starts inside: short
          const Aim a = aim(f, v, kTrilinear, ray, 0);
          const auto h = sample_flights<kTrilinear>(v, a, count, stream, c.tracker);
          family.add(name + (", ray " + std::to_string(ray)) + ", " + c.name + ", " +
                         std::to_string(per_voxel) + " per voxel",
                     h.p_value());
        }
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A plateau with spikes: almost all of the density is the minorant of its leaf, where a control
/// part too large would do most harm.
TEST(Flight, ControlPartIsNotTooLarge) {
  const Field f = make_field("plateau", {0, 0, 0}, {41, 41, 41}, [](Vec3i p) {
    return p.x % 6 == 3 && p.y % 6 == 3 && p.z % 6 == 3 ? 1.0 : 0.5;
  });
  const Volume v = make_test_volume(f, 1, 16);
  proof::Family family;
  for (int ray = 0; ray < kRays; ++ray) {
    const Aim a = aim(f, v, kTrilinear, ray, kDepth);
    const auto h = sample_flights<kTrilinear>(v, a, 200'000, 20'000 + std::uint64_t(ray),
                                              Tracker::decomposition);
    family.add("ray " + std::to_string(ray), h.p_value());
  }
  EXPECT_TRUE(family.passes());
}

TEST(Flight, LeavesSpaceWithoutExtinction) {
  const Field& f = field("gaussian");
  const Aim a = aim(f, make_test_volume(f, 1, std::nullopt), kTrilinear, 0, 0);
  const Volume v = make_test_volume(f, 0, std::nullopt);
  Rng rng(kSeed, 1, 1);
  Tally count;
  Cursor cursor = a.cursor;
  Walk walk(v.density.octree, cursor, a.direction);
  EXPECT_FALSE(free_flight<Tracker::delta>(walk, exact<kTrilinear>(v), rng, count).collided);
  EXPECT_EQ(count.lookups, 0u);
  EXPECT_EQ(count.segments, 0u);
}

}  // namespace flight_test
}  // namespace pvol::test
