// Transmittance estimates against Beer and Lambert's law.
#include "pvol/track/transmittance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <type_traits>

#include "support/estimators.h"
#include "support/flights.h"
#include "support/segment_list.h"
#include "support/statistics.h"

namespace pvol::test {
namespace transmittance_test {

constexpr auto kTrilinear = LookUp::trilinear;

/// Near the mean of each segment along the ray; beside it, so that no factor is 1.
struct MeanControl {
  const RayOracle& oracle;
  explicit MeanControl(const Aim& a) : oracle(a.oracle) {}
  [[nodiscard]] float operator()(const Segment& s) const {
    const double depth = oracle.optical_depth(s.t1) - oracle.optical_depth(s.t0);
    return float(0.9 * depth / (s.t1 - s.t0));
  }
};

/// What the library takes by default.
struct DefaultControl : MinorantControl {
  explicit DefaultControl(const Aim&) {}
};

/// Estimates along one ray, added to each of `sums`.
template <Transmittance kEstimator, class Control = DefaultControl, class... Sums>
void add_samples(const Volume& v, const Aim& a, Tracker tracker, int rays, std::uint64_t stream,
                 Sums&... sums) {
  constexpr bool kAtMostOne = std::is_same_v<Control, DefaultControl>;
  const auto medium = exact<kTrilinear>(v);
  const Control control(a);
  with_tracker(tracker, [&](auto constant) {
    for (int i = 0; i < rays; ++i) {
      Rng rng(kSeed, stream, std::uint64_t(i));
      Walk walk(v.density.octree, a.cursor, a.direction);
      NoTally none;
      const float t =
          transmittance<kEstimator, decltype(constant)::value>(walk, medium, rng, none, control);
      EXPECT_TRUE(t >= 0 && (t <= 1 || !kAtMostOne)) << t;
      (sums.add(double(t)), ...);
    }
  });
}

template <Transmittance kEstimator>
proof::Moments sample(const Volume& v, const Aim& a, Tracker tracker, int rays,
                      std::uint64_t stream) {
  proof::Moments m;
  add_samples<kEstimator>(v, a, tracker, rays, stream, m);
  return m;
}

/// t-test, or Markov's inequality for estimates that are almost always 0 or almost always 1.
double p_value(const proof::Moments& m, double transmittance) {
  constexpr double kFewest = 20;  // events for the t-test's normal law
  const double n = double(m.count());
  if (n * transmittance >= kFewest && n * (1 - transmittance) >= kFewest) {
    return proof::mean_p_value(m, transmittance, 1e-6 * transmittance);
  }
  // Markov: the mean exceeds k times its expectation with probability 1/k at most.
  const double deviation = std::min(m.mean(), 1 - m.mean());
  const double expected = std::min(transmittance, 1 - transmittance);
  return deviation > 0 ? std::min(1.0, expected / deviation) : 1;
}

/// Each field, ray and optical depth by itself, depths in turns on a commit; and all rays of one
/// depth together, those of each tracker as well. `each` and `pooled` are the rays of one test.
template <Transmittance kEstimator, class Control = DefaultControl>
void test_all(const std::vector<Choice>& trackers, int each, int pooled, std::uint64_t stream) {
  proof::Family family, together;
  // Of rays of one optical depth: a bias that each ray hides shows in the sum.
  proof::Moments all;
  std::map<Tracker, proof::Moments> of_tracker;
  std::size_t number = 0;
  for (const Field& f : fields()) {
    for (const Choice& c : trackers) {
      ++number;
      const Volume v = make_test_volume(f, 1, c.depth, c.tracker);
      for (int ray = 0; ray < kRays; ++ray) {
        std::size_t turn = number + std::size_t(ray);
        for (const double depth : {1e-12, 1e-3, 0.3, 2.0, 6.0, 20.0}) {
          ++stream;
          if (!proof::has_turn(turn++, 3)) continue;
          const Aim a = aim(f, v, kTrilinear, ray, depth);
          proof::Moments m;
          add_samples<kEstimator, Control>(v, a, c.tracker, each, stream, m);
          // Above 1, estimates have no law for rare events; deep rays are such.
          if (!std::is_same_v<Control, DefaultControl> && depth > 3) continue;
          family.add(f.name + ", " + c.name + ", ray " + std::to_string(ray) + ", optical depth " +
                         std::to_string(depth),
                     p_value(m, a.oracle.transmittance()));
        }
        constexpr double kDepth = 1;
        const Aim a = aim(f, v, kTrilinear, ray, kDepth);
        add_samples<kEstimator, Control>(v, a, c.tracker, proof::samples(pooled), ++stream,
                                         of_tracker[c.tracker], all);
      }
    }
  }
  together.add("all", p_value(all, std::exp(-1.0)));
  for (const auto& [tracker, m] : of_tracker) {
    together.add(label(tracker), p_value(m, std::exp(-1.0)));
  }
  EXPECT_TRUE(family.passes());
  EXPECT_TRUE(together.passes());
}

TEST(Transmittance, RatioFollowsBeerAndLambert) {
  test_all<Transmittance::ratio>(choices(), 1000, 4000, 0);
}

TEST(Transmittance, AnalogFollowsBeerAndLambert) {
  test_all<Transmittance::analog>(choices(), 1000, 4000, 100'000);
}

/// Estimators that do not ask for the tracker, over two cuts.
const std::vector<Choice> kCuts{{"by cost", Tracker::delta, std::nullopt},
                                {"at depth 2", Tracker::delta, 2}};

TEST(Transmittance, ResidualRatioFollowsBeerAndLambert) {
  test_all<Transmittance::residual_ratio>(kCuts, 1000, 6000, 200'000);
}

TEST(Transmittance, ResidualRatioWithAMeanFollowsBeerAndLambert) {
  test_all<Transmittance::residual_ratio, MeanControl>(kCuts, 1000, 6000, 300'000);
}

TEST(Transmittance, RegularIsExact) { test_all<Transmittance::regular>(kCuts, 2, 2, 400'000); }

/// The control in closed form: no look-up and no variance where bounds are the medium.
TEST(Transmittance, ResidualRatioIsExactWhereBoundsAre) {
  const PlainField one{[](const Segment&, const LatticePoint&) { return 1.0f; }};
  SegmentList slab{{{0, 1, 1, 1, 0}, {1, 1.5, 1, 1, 0}}};
  Rng rng(kSeed, 1, 1);
  Tally tally;
  const float t =
      transmittance<Transmittance::residual_ratio, Tracker::delta>(slab, one, rng, tally);
  EXPECT_NEAR(double(t), std::exp(-1.5), 1e-7);
  EXPECT_EQ(tally.lookups, 0u);
}

/// Weighted trackers: the estimates bear majorants that are too low, and any tracker loose ones.
TEST(Transmittance, DoesNotDependOnHowTightMajorantsAre) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, std::nullopt);
  proof::Family family;
  const auto test = [&]<Transmittance kEstimator, Tracker kTracker>(float hi, float lo,
                                                                    double depth) {
    const Aim a = aim(f, v, kTrilinear, 0, depth);
    const auto medium = exact<kTrilinear>(v);
    proof::Moments m;
    for (std::uint64_t i = 0; i < 50'000; ++i) {
      Rng rng(kSeed, 81, i);
      Walk walk(v.density.octree, a.cursor, a.direction);
      ScaledSegments<Walk> segments{walk, hi, lo};
      NoTally none;
      m.add(double(transmittance<kEstimator, kTracker>(segments, medium, rng, none)));
    }
    family.add("majorant x " + std::to_string(hi),
               proof::mean_p_value(m, a.oracle.transmittance(), 1e-6));
  };
  using enum Transmittance;
  for (const float hi : {2.0f, 10.0f}) {
    test.operator()<ratio, Tracker::delta>(hi, 1, 1);
    test.operator()<analog, Tracker::delta>(hi, 1, 1);
    test.operator()<residual_ratio, Tracker::delta>(hi, 1, 1);
  }
  test.operator()<ratio, Tracker::weighted_delta>(0.3f, 0.1f, 0.15);
  test.operator()<residual_ratio, Tracker::weighted_delta>(0.3f, 0.1f, 0.15);
  test.operator()<analog, Tracker::weighted_delta>(0.3f, 0.1f, 0.15);
  test.operator()<analog, Tracker::weighted_decomposition>(0.3f, 0.1f, 0.15);
  EXPECT_TRUE(family.passes());
}

/// A slab of extinction 1 under a majorant of 20: many small factors, so that the roulette plays.
TEST(Transmittance, RouletteIsUnbiased) {
  const PlainField one{[](const Segment&, const LatticePoint&) { return 1.0f; }};
  proof::Family family;
  for (const double depth : {1.0, 3.0, 5.0}) {
    proof::Moments m;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
      Rng rng(kSeed, 77, i);
      SegmentList slab{{{0, depth, 0, 20, 0}}};
      NoTally none;
      m.add(double(transmittance<Transmittance::ratio, Tracker::delta>(slab, one, rng, none)));
    }
    family.add("depth " + std::to_string(depth), proof::mean_p_value(m, std::exp(-depth)));
    proof::Moments residual;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
      Rng rng(kSeed, 78, i);
      SegmentList halves{{{0, 0.5 * depth, 0.8f, 3, 0}, {0.5 * depth, depth, 0.8f, 3, 0}}};
      NoTally none;
      residual.add(double(
          transmittance<Transmittance::residual_ratio, Tracker::delta>(halves, one, rng, none)));
    }
    family.add("residual, depth " + std::to_string(depth),
               proof::mean_p_value(residual, std::exp(-depth)));
  }
  EXPECT_TRUE(family.passes());
}

TEST(Transmittance, ProofFindsAnErrorOfOnePerCent) {
  const Field& f = field("gaussian");
  const Volume v = make_test_volume(f, 1, std::nullopt);
  const Aim a = aim(f, v, kTrilinear, 0, 2);
  const proof::Moments m = sample<Transmittance::ratio>(v, a, Tracker::delta, 400'000, 99);
  EXPECT_GT(p_value(m, a.oracle.transmittance()), proof::kFalseAlarmRate);
  EXPECT_LT(p_value(m, std::exp(-1.01 * a.oracle.optical_depth())), 1e-6);
}

TEST(Transmittance, RatioVariesLessThanAnalog) {
  const Field& f = field("sparse");
  const Volume v = make_test_volume(f, 1, std::nullopt);
  const Aim a = aim(f, v, kTrilinear, 0, 1);
  EXPECT_LT(sample<Transmittance::ratio>(v, a, Tracker::delta, 20'000, 5).variance(),
            sample<Transmittance::analog>(v, a, Tracker::delta, 20'000, 6).variance());
}

TEST(Transmittance, IsOneWithoutExtinctionAndNothingBehindAWall) {
  const Field& f = field("constant");
  const Aim a = aim(f, make_test_volume(f, 1, 16), kTrilinear, 2, 0);
  const auto clear =
      sample<Transmittance::ratio>(make_test_volume(f, 0, 16), a, Tracker::delta, 100, 1);
  EXPECT_EQ(clear.mean(), 1);
  for (const double wall : {1e3, 1e6, 1e12}) {
    const auto dark =
        sample<Transmittance::ratio>(make_test_volume(f, wall, 16), a, Tracker::delta, 100, 2);
    EXPECT_EQ(dark.mean(), 0) << wall;
  }
}

}  // namespace transmittance_test
}  // namespace pvol::test
