// Every tracker on every field, under bounds that hold and bounds that do not, and where numbers
// end.
#include "pvol/track/tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pvol/track/transmittance.h"
#include "support/flights.h"
#include "support/segment_list.h"
#include "support/statistics.h"

namespace pvol::test {
namespace tracker_test {

constexpr auto kTrilinear = LookUp::trilinear;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Weighted flights against their law. Weights of all flights have the mean 1: nothing is lost. The
/// weighted histogram of distances has the law's. And the compensated count, weight (1 where it
/// collided, minus the optical depth flown), has the mean 0, as counts of a Poisson process have:
/// of all tests it finds an error in the rate from the fewest flights.
class WeightedFlights {
 public:
  explicit WeightedFlights(double optical_depth) : collides_(-std::expm1(-optical_depth)) {}

  /// `depth_flown` is the optical depth to the collision, or through all of the cloud.
  void add(const Flight& f, double depth_flown) {
    const double weight = double(f.weight);
    all_.add(weight);
    count_.add(weight * ((f.collided ? 1 : 0) - depth_flown));
    const double u = -std::expm1(-depth_flown) / collides_;
    const auto bin = f.collided ? std::min(kBins - 1, std::size_t(u * double(kBins))) : kBins;
    for (std::size_t i = 0; i <= kBins; ++i) bins_[i].add(i == bin ? weight : 0);
  }

  /// `rounding` is relative, of probabilities.
  void judge(const std::string& name, proof::Family& family) const {
    constexpr double kRounding = 3e-6;
    family.add(name + ", weights", proof::mean_p_value(all_, 1, kRounding));
    family.add(name + ", count", proof::mean_p_value(count_, 0, kRounding));
    for (std::size_t i = 0; i <= kBins; ++i) {
      const double expected = i < kBins ? collides_ / double(kBins) : 1 - collides_;
      family.add(name + ", bin " + std::to_string(i),
                 proof::mean_p_value(bins_[i], expected, kRounding));
    }
  }

 private:
  static constexpr std::size_t kBins = 8;
  double collides_;
  proof::Moments all_, count_;
  std::array<proof::Moments, kBins + 1> bins_;  // the last: those that left
};

/// How bounds are changed, and how deep a cloud the weights then bear.
struct Bounds {
  const char* name;
  float hi, lo;
  double depth;
  bool hold;
};
constexpr Bounds kBounds[] = {{"as they are", 1, 1, 2, true},
                              {"majorant x 2", 2, 1, 2, true},
                              {"majorant x 10", 10, 1, 2, true},
                              {"majorant x 0.8", 0.8f, 0.5f, 1, false},
                              {"majorant x 0.3", 0.3f, 0.1f, 0.15, false},
                              {"minorant x 1.5", 2, 1.5f, 1, false}};

/// Flights of one tracker through all fields along rays of one optical depth.
template <Tracker kTracker>
void test_tracker(const Bounds& bounds, int flights, proof::Family& family) {
  WeightedFlights all(bounds.depth);
  std::uint64_t stream = 0;
  bool all_weigh_one = true;
  for (const Field& f : fields()) {
    const Volume v = make_test_volume(f, 1, ++stream % 2 == 0 ? std::nullopt : std::optional(16));
    const auto medium = exact<kTrilinear>(v);
    for (int ray = 0; ray < kRays; ++ray) {
      const Aim a = aim(f, v, kTrilinear, ray, bounds.depth);
      for (int i = 0; i < flights; ++i) {
        Rng rng(kSeed, 100 * stream + std::uint64_t(ray), std::uint64_t(i));
        NoTally none;
        Walk walk(v.density.octree, a.cursor, a.direction);
        ScaledSegments<Walk> segments{walk, bounds.hi, bounds.lo};
        const Flight flight = free_flight<kTracker>(segments, medium, rng, none);
        all.add(flight, flight.collided ? a.oracle.optical_depth(flight.t) : bounds.depth);
        all_weigh_one &= std::abs(flight.weight - 1) < 1e-5f;
      }
    }
  }
  all.judge(bounds.name + (", tracker " + std::to_string(int(kTracker))), family);
  EXPECT_TRUE(all_weigh_one || !bounds.hold);
}

TEST(Trackers, FollowTheLawOfFreeFlights) {
  proof::Family family;
  const int kFlights = proof::samples<int>(6000);
  for (const Bounds& bounds : kBounds) {
    if (bounds.hold) {
      test_tracker<Tracker::delta>(bounds, kFlights, family);
      test_tracker<Tracker::decomposition>(bounds, kFlights, family);
    }
    test_tracker<Tracker::weighted_delta>(bounds, kFlights, family);
    test_tracker<Tracker::weighted_decomposition>(bounds, kFlights, family);
  }
  test_tracker<Tracker::regular>(kBounds[0], kFlights, family);
  EXPECT_TRUE(family.passes());
}

/// A slab of extinction 1 under bounds of its own: many flights for little.
template <Tracker kTracker>
void test_slab(float lo, float hi, double depth, int flights, proof::Family& family) {
  const PlainField one{[](const Segment&, const LatticePoint&) { return 1.0f; }};
  WeightedFlights all(depth);
  SegmentList list{{{0, 0.5 * depth, lo, hi, 0}, {0.5 * depth, depth, lo, hi, 0}}};
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, 31 + std::uint64_t(kTracker), std::uint64_t(i));
    NoTally none;
    list.at = 0;
    const Flight f = free_flight<kTracker>(list, one, rng, none);
    all.add(f, f.collided ? f.t : depth);
  }
  all.judge(std::to_string(lo) + " to " + std::to_string(hi), family);
}

TEST(Trackers, WithWeightsAreRightUnderBoundsThatDoNotHold) {
  proof::Family family;
  const int kFlights = proof::samples<int>(2'000'000);
  test_slab<Tracker::weighted_delta>(0, 0.7f, 1, kFlights, family);
  test_slab<Tracker::weighted_delta>(0, 0.3f, 0.2, kFlights, family);
  test_slab<Tracker::weighted_decomposition>(0.4f, 0.8f, 1, kFlights, family);
  test_slab<Tracker::weighted_decomposition>(1.2f, 2, 1, kFlights, family);
  EXPECT_TRUE(family.passes());
}

/// The minorant is the medium: a control part too large by 1 % is one of the whole extinction.
TEST(Trackers, TakeTheMinorantForWhatItIs) {
  proof::Family family;
  const int kFlights = proof::samples<int>(600'000);
  test_slab<Tracker::delta>(1, 2, 2, kFlights, family);
  test_slab<Tracker::decomposition>(1, 2, 2, kFlights, family);
  test_slab<Tracker::weighted_decomposition>(1, 2, 2, kFlights, family);
  EXPECT_TRUE(family.passes());
}

/// With bounds that hold, look-ups and nulls of the weighted trackers are those of the analog ones.
TEST(Trackers, WithWeightsDecideAsAnalogOnesDo) {
  for (const Field& f : fields()) {
    const Volume v = make_test_volume(f, 1, 16);
    const auto medium = exact<kTrilinear>(v);
    const Aim a = aim(f, v, kTrilinear, 0, 2);
    int different = 0;
    constexpr int kFlights = 2000;
    for (int i = 0; i < kFlights; ++i) {
      const auto fly = [&]<Tracker kTracker>() {
        Rng rng(kSeed, 41, std::uint64_t(i));
        Walk walk(v.density.octree, a.cursor, a.direction);
        Tally tally;
        const Flight flight = free_flight<kTracker>(walk, medium, rng, tally);
        return std::array{flight.t, double(tally.lookups), double(tally.null_collisions)};
      };
      different += fly.operator()<Tracker::delta>() != fly.operator()<Tracker::weighted_delta>();
      different += fly.operator()<Tracker::decomposition>() !=
                   fly.operator()<Tracker::weighted_decomposition>();
    }
    EXPECT_LE(different, 2) << f.name;  // of 4000, where rounding decides
  }
}

constexpr Tracker kAll[] = {Tracker::delta, Tracker::decomposition, Tracker::weighted_delta,
                            Tracker::weighted_decomposition};

/// `f(tracker, flight, rng)` for flights through segments of a medium of extinction 1.
template <class F>
void fly_all(const std::vector<Segment>& segments, int flights, const F& f) {
  const PlainField one{[](const Segment&, const LatticePoint&) { return 1.0f; }};
  for (const Tracker tracker : kAll) {
    with_tracker(tracker, [&](auto constant) {
      if constexpr (decltype(constant)::value != Tracker::regular) {
        for (int i = 0; i < flights; ++i) {
          Rng rng(kSeed, 51, std::uint64_t(i));
          SegmentList list{segments};
          Tally tally;
          f(tracker, free_flight<decltype(constant)::value>(list, one, rng, tally), tally);
        }
      }
    });
  }
}

/// u near 1 where every tentative collision is real: the null part, of probability 0, is not
/// chosen.
TEST(TrackerEdges, NothingIsNullWhereTheMajorantIsTheMedium) {
  fly_all({{0, 1e3, 1, 1, 0}}, 200'000, [](Tracker, const Flight& f, const Tally& tally) {
    ASSERT_TRUE(f.collided && f.weight == 1);
    ASSERT_EQ(tally.null_collisions, 0u);
  });
  constexpr float kLast = 0x1.fffffep-1f;  // the largest u
  Rng rng(kSeed, 1, 1);
  for (int i = 0; i < 1'000'000; ++i) {
    const float hi = std::exp2(200 * rng.uniform() - 100);
    ASSERT_LT(kLast * hi, hi);
    float weight = 1;
    ASSERT_TRUE(detail::weighted_choice(hi, 0, kLast, weight));
    ASSERT_EQ(weight, 1.0f);
  }
}

TEST(TrackerEdges, SegmentsOfNoLengthAreNothing) {
  const std::vector<Segment> plain{{0, 1, 0.5f, 2, 0}, {1, 2, 0.5f, 4, 0}};
  const std::vector<Segment> more{{0, 0, 0, 1e30f, 0}, plain[0], {1, 1, 9, 9, 0},
                                  {1, 1, 0, 1e30f, 0}, plain[1], {2, 2, 1, 1, 0}};
  std::vector<Flight> flights;
  fly_all(plain, 2000, [&](Tracker, const Flight& f, const Tally&) { flights.push_back(f); });
  std::size_t i = 0;
  fly_all(more, 2000, [&](Tracker, const Flight& f, const Tally&) {
    EXPECT_EQ(f.t, flights[i].t);
    EXPECT_EQ(f.weight, flights[i].weight);
    ++i;
  });
}

TEST(TrackerEdges, CollisionsLieOnTheirSegment) {
  for (const double start : {0.0, 1e-6, 1e6, 1e12}) {
    for (const double length : {1e-9, 1.0, 1e9}) {
      const float rate = float(3 / length);
      const double end = start + length, slack = 1e-6 * length + 1e-15 * end;
      fly_all({{start, end, 0, rate, 0}}, 1000, [&](Tracker, const Flight& f, const Tally&) {
        EXPECT_TRUE(f.collided ? f.t >= start && f.t <= end + slack : f.t == kInfinity) << f.t;
      });
    }
  }
}

/// A medium without end: flights are finite, nothing passes, and no estimate is NaN.
TEST(TrackerEdges, EndlessSegmentsAreOpaque) {
  fly_all({{1, kInfinity, 0.5f, 2, 0}}, 2000, [](Tracker, const Flight& f, const Tally&) {
    EXPECT_TRUE(f.collided && std::isfinite(f.t) && std::isfinite(f.weight));
  });
  const PlainField one{[](const Segment&, const LatticePoint&) { return 1.0f; }};
  for (const float lo : {0.0f, 0.5f, 1.0f}) {
    for (std::uint64_t i = 0; i < 200; ++i) {
      Rng rng(kSeed, 61, i);
      NoTally none;
      const float hi = lo == 1 ? 1.0f : 2.0f;
      SegmentList a{{{0, kInfinity, lo, hi, 0}}}, b = a, c = a;
      EXPECT_EQ((transmittance<Transmittance::ratio, Tracker::delta>(a, one, rng, none)), 0);
      EXPECT_EQ((transmittance<Transmittance::analog, Tracker::delta>(b, one, rng, none)), 0);
      EXPECT_EQ((transmittance<Transmittance::residual_ratio, Tracker::delta>(c, one, rng, none)),
                0);
    }
  }
}

/// Components of a direction that are 0 and -0 are the same to every tracker.
TEST(TrackerEdges, NegativeZerosInDirectionsAreZeros) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, std::nullopt);
  const auto medium = exact<kTrilinear>(v);
  const Cursor cursor =
      make_cursor(v.density.octree, v.density.octree.support().lo + Vec3d(0, 20.5, 21));
  const auto test = [&](auto constant) {
    for (std::uint64_t i = 0; i < 500; ++i) {
      Rng rng(kSeed, 71, i), same = rng;
      NoTally none;
      Walk plus(v.density.octree, cursor, widen(Vec3f(0.1f, 0.0f, 0.0f)));
      Walk minus(v.density.octree, cursor, widen(Vec3f(0.1f, -0.0f, -0.0f)));
      constexpr Tracker kTracker = decltype(constant)::value;
      const Flight a = free_flight<kTracker>(plus, medium, rng, none);
      const Flight b = free_flight<kTracker>(minus, medium, same, none);
      ASSERT_EQ(a.collided, b.collided);
      ASSERT_EQ(a.t, b.t);
    }
  };
  for (const Tracker tracker : kAll) with_tracker(tracker, test);
  with_tracker(Tracker::regular, test);
}

}  // namespace tracker_test
}  // namespace pvol::test
