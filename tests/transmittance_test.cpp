// Transmittance estimates against Beer and Lambert's law.
#include "pvol/track/transmittance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "flights.h"
#include "segment_list.h"
#include "statistics.h"

namespace pvol::test {
namespace {

constexpr auto kTrilinear = Interpolation::trilinear;

/// Estimates along one ray, added to `m`.
template <Transmittance kEstimator>
void add_samples(const Volume& v, const Aim& a, Tracker tracker, int rays, std::uint64_t stream,
                 proof::Moments& m) {
  with_tracker(tracker, [&](auto constant) {
    for (int i = 0; i < rays; ++i) {
      Rng rng(kSeed, stream, std::uint64_t(i));
      Cursor cursor = a.cursor;
      Walk walk(v.octree, cursor, a.direction);
      NoTally none;
      const float t = transmittance<kEstimator, decltype(constant)::value>(
          walk, Exact<kTrilinear>{v}, rng, none);
      EXPECT_TRUE(t >= 0 && t <= 1) << t;
      m.add(double(t));
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

template <Transmittance kEstimator>
void test_all(std::uint64_t stream) {
  proof::Family family, together;
  proof::Moments all;  // of rays of one optical depth: a bias that each ray hides shows in the sum
  for (const Field& f : fields()) {
    for (const Choice& c : choices()) {
      const Volume v = make_test_volume(f, 1, c.depth, c.tracker);
      for (int ray = 0; ray < kRays; ++ray) {
        for (const double depth : {1e-12, 1e-3, 0.3, 2.0, 6.0, 20.0}) {
          const Aim a = aim(f, v, kTrilinear, ray, depth);
          const auto m = sample<kEstimator>(v, a, c.tracker, 1000, ++stream);
          family.add(f.name + ", " + c.name + ", ray " + std::to_string(ray) + ", optical depth " +
                         std::to_string(depth),
                     p_value(m, a.oracle.transmittance()));
        }
        constexpr double kDepth = 1;
        const Aim a = aim(f, v, kTrilinear, ray, kDepth);
        add_samples<kEstimator>(v, a, c.tracker, 4000, ++stream, all);
      }
    }
  }
  together.add("all", p_value(all, std::exp(-1.0)));
  EXPECT_TRUE(family.passes());
  EXPECT_TRUE(together.passes());
}

TEST(Transmittance, RatioFollowsBeerAndLambert) { test_all<Transmittance::ratio>(0); }

TEST(Transmittance, AnalogFollowsBeerAndLambert) { test_all<Transmittance::analog>(100'000); }

/// A slab of extinction 1 under a majorant of 20: many small factors, so that the roulette plays.
TEST(Transmittance, RouletteIsUnbiased) {
  proof::Family family;
  for (const double depth : {1.0, 3.0, 5.0}) {
    proof::Moments m;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
      Rng rng(kSeed, 77, i);
      SegmentList slab{{{0, depth, 0, 20, 0}}};
      NoTally none;
      const auto one = [](const Segment&, const LatticePoint&) { return 1.0f; };
      m.add(double(transmittance<Transmittance::ratio, Tracker::delta>(slab, one, rng, none)));
    }
    family.add("depth " + std::to_string(depth), proof::mean_p_value(m, std::exp(-depth)));
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

}  // namespace
}  // namespace pvol::test
