// Rays of the C API: against the C++ API, which has proofs of its own, to the bit where numbers
// are pvol's own, and against closed forms where they are the caller's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "capi/capi_fields.h"
#include "pvol/trackers.h"
#include "pvol/volume/batch.h"
#include "support/statistics.h"

namespace pvol::test {
namespace rays_test {

using proof::Family;
using proof::Moments;

constexpr pvol_interpolation kInterpolations[] = {PVOL_TRILINEAR, PVOL_NEAREST, PVOL_TRICUBIC};
LookUp look_up_of(pvol_interpolation i) {
  return i == PVOL_TRILINEAR ? LookUp::trilinear
         : i == PVOL_NEAREST ? LookUp::nearest
                             : LookUp::tricubic;
}

TEST(CapiRays, AreThoseOfTheCppApi) {
  const Smoke smoke;
  for (const pvol_interpolation interpolation : kInterpolations) {
    api::Volume v;
    v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(5);
    v.set_interpolation(interpolation).commit();
    const Volume other = make_same(smoke, 5, look_up_of(interpolation));
    Rng rng(1, 2, 3);
    int collided = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
      const pvol_ray ray = random_ray(rng, smoke.n);
      api::Random mine(7, 8, i);
      Rng theirs(7, 8, i);
      const auto t = v.flight(ray, mine);
      const Flight flight = sample_flight(other, same(ray), ray.t_max, theirs);
      ASSERT_EQ(t.has_value(), flight.collided);
      if (t) {
        EXPECT_EQ(*t, flight.t);
      }
      collided += flight.collided;
      for (const auto& [mine_is, theirs_is] :
           {std::pair{PVOL_RATIO, Transmittance::ratio},
            std::pair{PVOL_ANALOG, Transmittance::analog},
            std::pair{PVOL_RESIDUAL_RATIO, Transmittance::residual_ratio}}) {
        EXPECT_EQ(v.transmittance(ray, mine_is, mine),
                  sample_transmittance(other, same(ray), ray.t_max, theirs, theirs_is));
      }
      EXPECT_EQ(mine.used, theirs.state().counter);
      double depth;
      const int has_depth = pvol_optical_depth(v.get(), &ray, &depth);
      if (interpolation == PVOL_TRICUBIC) {
        EXPECT_EQ(has_depth, PVOL_BAD_RAY);
      } else {
        EXPECT_EQ(std::exp(-depth), exact_transmittance(other, same(ray), ray.t_max));
      }
    }
    EXPECT_GT(collided, 100);
  }
}

TEST(CapiRays, WalksAreThoseOfTheCppApi) {
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 5);
  const Volume other = make_same(smoke, 5);
  Rng rng(4, 5, 6);
  int segments = 0;
  for (int i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    api::Walk walk = v.enter(ray);
    auto theirs = enter(other, same(ray), ray.t_max);
    while (const auto s = walk.next()) {
      const auto o = theirs->next();
      ASSERT_TRUE(o);
      EXPECT_EQ(s->t0, o->t0);
      EXPECT_EQ(s->t1, o->t1);
      EXPECT_EQ(s->lo, o->lo);
      EXPECT_EQ(s->hi, o->hi);
      ++segments;
      visit_field(other, [&](const auto& field) {
        NoTally none;
        const double t = s->t0 + double(rng.uniform()) * (s->t1 - s->t0);
        const float mu = field.extinction(*o, theirs->point(t), none);
        EXPECT_EQ(walk.extinction(t), mu);
        EXPECT_NEAR(walk.density(t) * 5, mu, 1e-6f * mu);
        for (const float x : {0.0f, 0.999f * mu, mu, 1.001f * mu, s->hi}) {
          EXPECT_EQ(walk.exceeds(t, x), x < mu);
        }
        const api::Vec at = walk.place(t);
        const double len = std::hypot(ray.d[0], ray.d[1], ray.d[2]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_NEAR(at[axis], ray.o[axis] + t / len * ray.d[axis], 1e-5);
        }
        EXPECT_NEAR(v.extinction(at), mu, 1e-3f * s->hi);
      });
    }
    EXPECT_FALSE(theirs && theirs->next());
  }
  EXPECT_GT(segments, 300);
}

/// What is looked up belongs to the leaf of the flight's end, not to that of the last segment.
TEST(CapiRays, FlightsAfterSegmentsEndInLeavesOfTheirOwn) {
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 5);
  Rng rng(9, 9, 9);
  int collided = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    api::Random random(3, 4, i);
    api::Walk walk = v.enter(ray), other = v.enter(ray);
    (void)walk.next();
    const auto t = walk.flight(random);
    if (!t) continue;
    ++collided;
    while (const auto s = other.next()) {
      if (*t <= s->t1) break;
    }
    const float mu = other.extinction(*t);
    EXPECT_NEAR(walk.extinction(*t), mu, 1e-4f * mu);
    EXPECT_NEAR(walk.density(*t), other.density(*t), 1e-4f * mu);
    EXPECT_TRUE(walk.exceeds(*t, 0.999f * mu));
    EXPECT_FALSE(walk.exceeds(*t, 1.001f * mu));
  }
  EXPECT_GT(collided, 50);
}

TEST(CapiRays, WalksAreCopiedByAssignment) {
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 5);
  const pvol_ray ray = ray_between({-5, 18, 21}, {30, 20, 19});
  pvol_walk a, b;
  ASSERT_EQ(pvol_enter(v.get(), &ray, &a), 1);
  pvol_segment s, again;
  ASSERT_EQ(pvol_next(&a, &s), 1);
  b = a;
  pvol_walk moved;
  std::memcpy(&moved, &b, sizeof b);
  while (pvol_next(&a, &s) == 1) {
    ASSERT_EQ(pvol_next(&moved, &again), 1);
    EXPECT_EQ(s.t0, again.t0);
    EXPECT_EQ(pvol_walk_extinction(&a, s.t0), pvol_walk_extinction(&moved, s.t0));
  }
  EXPECT_EQ(pvol_next(&moved, &again), 0);
  ASSERT_EQ(pvol_next(&b, &again), 1) << "copies go their own ways";
}

TEST(CapiRays, BadOnesAreTold) {
  const api::Volume v = make_smoke(Smoke());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  api::Random random(1, 2, 3);
  for (const pvol_ray& bad :
       {api::ray({0, 0, 0}, {0, 0, 0}), api::ray({nan, 0, 0}, {1, 0, 0}),
        api::ray({0, 0, 0}, {1, nan, 0}), api::ray({0, api::kInfinity, 0}, {0, 1, 0}),
        api::ray({0, 0, 0}, {1, 0, 0}, nan)}) {
    double t = 7, depth = 7;
    float passed = 7;
    pvol_walk walk;
    EXPECT_EQ(pvol_sample_flight(v.get(), &bad, &random, &t), PVOL_BAD_RAY);
    EXPECT_EQ(pvol_sample_transmittance(v.get(), &bad, PVOL_RATIO, &random, &passed), PVOL_BAD_RAY);
    EXPECT_EQ(pvol_optical_depth(v.get(), &bad, &depth), PVOL_BAD_RAY);
    EXPECT_EQ(pvol_enter(v.get(), &bad, &walk), PVOL_BAD_RAY);
    pvol_segment s;
    EXPECT_EQ(pvol_next(&walk, &s), 0);
  }
  const pvol_ray good = ray_between({-5, 20, 20}, {20, 20, 20});
  pvol_walk walk;
  ASSERT_EQ(pvol_enter(v.get(), &good, &walk), 1);
  double t;
  while (pvol_walk_flight(&walk, &random, &t) != 1) ASSERT_EQ(pvol_enter(v.get(), &good, &walk), 1);
  const double none[3] = {0, 0, 0};
  EXPECT_EQ(pvol_resume(&walk, t, none, 1), PVOL_BAD_RAY);
}

/// Directions as short and as long as doubles are: the rays are those of length 1.
TEST(CapiRays, DirectionsOfAnyLengthAreNormalised) {
  const api::Volume v = make_smoke(Smoke());
  const pvol_ray ray = ray_between({-5, 18, 21}, {40, 20, 17});
  double depth = 0;
  ASSERT_EQ(pvol_optical_depth(v.get(), &ray, &depth), 1);
  ASSERT_GT(depth, 0.1);
  for (const double length : {1e-320, 1e-161, 1e-155, 1e-3, 1e160, 1e307}) {
    pvol_ray other = ray;
    for (double& d : other.d) d *= length;
    double of_other = 0;
    ASSERT_EQ(pvol_optical_depth(v.get(), &other, &of_other), 1) << length;
    EXPECT_NEAR(of_other, depth, (length < 1e-310 ? 1e-2 : 1e-9) * depth) << length;
  }
}

TEST(CapiRays, ClosedFormsOfTricubicVolumesAreRefused) {
  const Smoke smoke;
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set_interpolation(PVOL_TRICUBIC).commit();
  api::Random random(1, 2, 3);
  for (const pvol_ray& ray :
       {ray_between({-5, 20, 20}, {20, 20, 20}), ray_between({-50, -50, -50}, {-60, -50, -50})}) {
    float passed = 7;
    double depth = 7;
    EXPECT_EQ(pvol_sample_transmittance(v.get(), &ray, PVOL_EXACT, &random, &passed), PVOL_BAD_RAY);
    EXPECT_EQ(pvol_optical_depth(v.get(), &ray, &depth), PVOL_BAD_RAY);
    EXPECT_EQ(passed, 7);
    EXPECT_EQ(depth, 7);
  }
}

/// As a C program may pass it.
pvol_estimator unknown_estimator() {
  const int value = 9;
  pvol_estimator e;
  std::memcpy(&e, &value, sizeof e);
  return e;
}

TEST(CapiRays, NullPointersAndUnknownNamesAreBad) {
  const api::Volume owner = make_smoke(Smoke());
  const pvol_volume* const v = owner.get();
  const pvol_ray good = ray_between({-5, 20, 20}, {20, 20, 20});
  api::Random random(1, 2, 3);
  double t = 7;
  float passed = 7;
  pvol_walk walk;
  EXPECT_EQ(pvol_sample_flight(v, nullptr, &random, &t), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_sample_flight(v, &good, nullptr, &t), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_sample_flight(v, &good, &random, nullptr), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_sample_transmittance(v, nullptr, PVOL_RATIO, &random, &passed), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_sample_transmittance(v, &good, PVOL_RATIO, &random, nullptr), PVOL_BAD_RAY);
  const pvol_estimator unknown = unknown_estimator();
  EXPECT_EQ(pvol_sample_transmittance(v, &good, unknown, &random, &passed), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_optical_depth(v, nullptr, &t), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_optical_depth(v, &good, nullptr), PVOL_BAD_RAY);
  float range[2];
  const double corner[3] = {0, 0, 0};
  EXPECT_EQ(pvol_extinction_range(v, nullptr, corner, range), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_extinction_range(v, corner, nullptr, range), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_extinction_range(v, corner, corner, nullptr), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_shell_spans(v, nullptr, nullptr, 0), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_shell_spans(v, &good, nullptr, 1), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_shell_spans(v, &good, nullptr, 0), 1) << "how many there are";
  double lo[3];
  EXPECT_EQ(pvol_box(v, lo, nullptr), 0);
  EXPECT_EQ(pvol_density(v, nullptr), 0);
  EXPECT_EQ(pvol_extinction(v, nullptr), 0);
  EXPECT_EQ(pvol_value(v, 0, nullptr), 0);
  EXPECT_EQ(pvol_enter(v, &good, nullptr), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_enter(v, nullptr, &walk), PVOL_BAD_RAY);
  ASSERT_EQ(pvol_enter(v, &good, &walk), 1);
  const double nan = std::numeric_limits<double>::quiet_NaN(), along[3] = {1, 0, 0};
  EXPECT_EQ(pvol_resume(&walk, nan, along, 1), PVOL_BAD_RAY);
  EXPECT_EQ(pvol_resume(&walk, 1, nullptr, 1), PVOL_BAD_RAY);
  EXPECT_TRUE(std::isnan(pvol_walk_transmittance(&walk, unknown, &random)));
}

TEST(CapiBatches, OfWhatIsNotThereAreRefused) {
  const api::Volume owner = make_smoke(Smoke());
  const pvol_volume* const v = owner.get();
  const double origin[3] = {-5, 20, 20}, direction[3] = {1, 0, 0};
  const pvol_streams streams{};
  double t = 7;
  float passed = 7;
  pvol_rays rays{};
  rays.count = 1;
  rays.origins.values = origin, rays.origins.type = PVOL_DOUBLE;
  rays.directions.values = direction, rays.directions.type = PVOL_DOUBLE;
  ASSERT_EQ(pvol_flights(v, &rays, &streams, &t), 0u);
  EXPECT_EQ(pvol_flights(v, nullptr, &streams, &t), 0u);
  EXPECT_EQ(pvol_flights(v, &rays, &streams, nullptr), 1u);
  EXPECT_EQ(pvol_flights(v, &rays, nullptr, &t), 1u);
  EXPECT_TRUE(std::isnan(t));
  EXPECT_EQ(pvol_transmittances(v, &rays, PVOL_RATIO, nullptr, &passed), 1u);
  EXPECT_TRUE(std::isnan(passed));
  passed = 7;
  EXPECT_EQ(pvol_transmittances(v, &rays, unknown_estimator(), &streams, &passed), 1u);
  EXPECT_TRUE(std::isnan(passed));
  EXPECT_EQ(pvol_optical_depths(v, &rays, nullptr), 1u);
  t = 7;
  rays.directions.type = pvol_type(3);
  EXPECT_EQ(pvol_flights(v, &rays, &streams, &t), 1u);
  EXPECT_TRUE(std::isnan(t));
}

TEST(CapiRays, ThatMissGoOnNowhere) {
  const api::Volume v = make_smoke(Smoke(80));
  const pvol_ray miss = ray_between({-50, -50, -50}, {-60, -50, -50});
  pvol_walk walk;
  ASSERT_EQ(pvol_enter(v.get(), &miss, &walk), 0);
  double place[3] = {0, 0, 0};
  pvol_walk_place(&walk, 1, place);
  EXPECT_TRUE(std::isnan(place[0]) && std::isnan(place[2]));
  const double direction[3] = {1, 0, 0};
  EXPECT_EQ(pvol_resume(&walk, 0, direction, 1), PVOL_BAD_RAY);
  pvol_segment s;
  double t;
  api::Random random(1, 2, 3);
  EXPECT_EQ(pvol_next(&walk, &s), 0);
  EXPECT_EQ(pvol_walk_flight(&walk, &random, &t), 0);
  EXPECT_EQ(pvol_walk_transmittance(&walk, PVOL_RATIO, &random), 1);
  EXPECT_EQ(pvol_walk_optical_depth(&walk), 0);
  EXPECT_EQ(pvol_walk_extinction(&walk, 0), 0);
  EXPECT_EQ(pvol_walk_exceeds(&walk, 0, 0), 0);
}

/// Flights that start at a place and end where a ray's t_max is, by all kinds of numbers, against
/// the exact transmittance; the mean distance of those that collide against its integral.
class NumbersOfTheCaller : public testing::Test {
 protected:
  Smoke smoke_;
  api::Volume volume_ = make_smoke(smoke_, 1.5);
  pvol_ray ray_ = ray_between({-3, 17, 23}, {38, 21, 19}, 2.4);
  double exact_ = 0;

  void SetUp() override {
    double depth;
    ASSERT_EQ(pvol_optical_depth(volume_.get(), &ray_, &depth), 1);
    exact_ = std::exp(-depth);
    ASSERT_GT(exact_, 0.1);
    ASSERT_LT(exact_, 0.9);
  }

  /// make(i) is the i-th flight's numbers.
  template <class Make>
  void expect_unbiased(const Make& make) {
    constexpr std::uint64_t kFlights = 200'000;
    Family family;
    Moments passes;
    for (std::uint64_t i = 0; i < kFlights; ++i) {
      pvol_random r = make(3 * i);
      passes.add(volume_.flight(ray_, r) ? 0 : 1);
    }
    family.add("flights", proof::mean_p_value(passes, exact_));
    for (const pvol_estimator e : {PVOL_RATIO, PVOL_ANALOG, PVOL_RESIDUAL_RATIO}) {
      Moments passed;
      for (std::uint64_t i = 0; i < kFlights / 4; ++i) {
        pvol_random r = make(3 * i + 1 + std::uint64_t(e));
        passed.add(double(volume_.transmittance(ray_, e, r)));
      }
      family.add("estimator " + std::to_string(e), proof::mean_p_value(passed, exact_));
    }
    EXPECT_TRUE(family.passes());
    EXPECT_LT(5 * std::sqrt(passes.variance_of_mean()), 0.02) << "small errors are found";
  }
};

TEST_F(NumbersOfTheCaller, OfAFunction) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  auto next = [&] { return uniform(engine); };
  expect_unbiased([&](std::uint64_t) -> pvol_random { return api::Random::of(next); });
}

TEST_F(NumbersOfTheCaller, OfAnArrayAndThenOfTheStream) {
  std::mt19937 engine(2);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const std::uint32_t count : {1u, 2u, 3u, 8u}) {
    std::vector<float> numbers(count);
    expect_unbiased([&](std::uint64_t i) -> pvol_random {
      for (float& x : numbers) x = std::min(uniform(engine), 0x1.fffffep-1f);
      pvol_random r = api::Random(3, count, i);
      r.numbers = numbers.data(), r.count = count;
      return r;
    });
  }
}

TEST_F(NumbersOfTheCaller, StratifiedOnesMakeLessNoise) {
  // The first number is the depth of the first tentative collision: in strata it halves the noise
  // of flights in a medium that is nearly homogeneous.
  const std::vector<float> even(16 * 16 * 16, 1);
  api::Volume v;
  v.set(PVOL_DENSITY, api::array(even.data(), {{16, 16, 16}})).set_extinction(0.1).commit();
  const pvol_ray ray = api::ray({2, 7.5, 7.5}, {1, 0, 0}, 10);
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto variance_of = [&](bool strata) {
    Moments means;
    for (std::uint64_t round = 0; round < 300; ++round) {
      double sum = 0;
      for (int i = 0; i < 64; ++i) {
        float x = strata ? (float(i) + uniform(engine)) / 64 : uniform(engine);
        pvol_random r = api::Random(5, round, std::uint64_t(i));
        r.numbers = &x, r.count = 1;
        sum += v.flight(ray, r) ? 0 : 1;
      }
      means.add(sum / 64);
    }
    EXPECT_NEAR(means.mean(), std::exp(-1.0), 0.015);
    return means.variance();
  };
  EXPECT_LT(variance_of(true), 0.1 * variance_of(false));
}

TEST_F(NumbersOfTheCaller, BadOnesDoNoHarm) {
  for (const double x : {-1.0, 0.0, 1.0, 2.0, std::nan(""), api::kInfinity, -api::kInfinity}) {
    int calls = 0;
    auto next = [&] {
      // Were it always 0, flights would not end.
      return ++calls % 101 == 0 ? 0.999 : x;
    };
    pvol_random r = api::Random::of(next);
    const auto t = volume_.flight(ray_, r);
    EXPECT_TRUE(!t || (*t >= 0 && *t <= ray_.t_max)) << x;
    const float passed = volume_.transmittance(ray_, PVOL_RATIO, r);
    EXPECT_TRUE(passed >= 0 && passed <= 1) << x;
  }
}

TEST(CapiPaths, GoOnWhereTheyCollided) {
  // In a ball of a medium that scatters evenly and absorbs nothing, each path leaves; the mean
  // number of collisions against paths of the C++ API with numbers of its own.
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 8);
  const Volume other = make_same(smoke, 8);
  const auto turn = [](double a, double b) {
    const double z = 2 * a - 1, r = std::sqrt(1 - z * z), phi = 6.283185307179586 * b;
    return api::Vec{r * std::cos(phi), r * std::sin(phi), z};
  };
  Moments mine, theirs;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const pvol_ray ray = ray_between({-5, 14, 20}, {30, 22, 19});
    api::Random random(1, 1, i);
    api::Walk walk = v.enter(ray);
    int collisions = 0;
    while (const auto t = walk.flight(random)) {
      ++collisions;
      const double a = random.uniform(), b = random.uniform();
      ASSERT_TRUE(walk.resume(*t, turn(a, b)));
    }
    mine.add(collisions);

    Rng rng(proof::seeded(2), 2, i);
    collisions = 0;
    Vec3d o(ray.o[0], ray.o[1], ray.o[2]), d(ray.d[0], ray.d[1], ray.d[2]);
    for (;;) {
      const Flight f = sample_flight(other, {o, d}, api::kInfinity, rng);
      if (!f.collided) break;
      ++collisions;
      o = o + d / length(d) * f.t;
      const auto [a, b] = rng.uniform2();
      const api::Vec next = turn(double(a), double(b));
      d = {next[0], next[1], next[2]};
    }
    theirs.add(collisions);
  }
  EXPECT_GT(mine.mean(), 2);
  Family family;
  family.add("collisions", proof::equal_means_p_value(mine, theirs));
  EXPECT_TRUE(family.passes()) << mine.mean() << " and " << theirs.mean();
}

TEST(CapiChromatic, EachChannelIsItsOwnExtinction) {
  const Smoke smoke;
  const std::array<float, 3> share{1, 0.5f, 0.1f};
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(4);
  v.set_extinction_color(share).commit();
  const pvol_ray ray = ray_between({-3, 17, 23}, {38, 21, 19}, 2.4);
  double depth;
  ASSERT_EQ(pvol_optical_depth(v.get(), &ray, &depth), 1);
  Family family;
  std::array<Moments, 3> passed, left;
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    pvol_walk walk;
    api::Random random(6, 7, i);
    ASSERT_EQ(pvol_enter(v.get(), &ray, &walk), 1);
    float t[3];
    pvol_walk_transmittance_rgb(&walk, &random, t);
    ASSERT_EQ(pvol_enter(v.get(), &ray, &walk), 1);
    const float one[3] = {1, 1, 1};
    float weight[3];
    double at;
    const int collided = pvol_walk_flight_rgb(&walk, one, &random, &at, weight);
    for (std::size_t c = 0; c < 3; ++c) {
      passed[c].add(double(t[c]));
      left[c].add(collided ? 0 : double(weight[c]));
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const double exact = std::exp(-depth * double(share[c]));
    family.add("transmittance of channel " + std::to_string(c),
               proof::mean_p_value(passed[c], exact, 1e-6));
    family.add("flights of channel " + std::to_string(c),
               proof::mean_p_value(left[c], exact, 1e-6));
  }
  EXPECT_TRUE(family.passes());
}

TEST(CapiBatches, AreThoseOfTheCppApi) {
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 5);
  const Volume other = make_same(smoke, 5);
  const BatchField field(other);
  constexpr std::size_t kRays = 3001;
  std::vector<float> o, d;
  Rng rng(8, 8, 8);
  for (std::size_t i = 0; i < kRays; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    for (int axis = 0; axis < 3; ++axis)
      o.push_back(float(ray.o[axis])), d.push_back(float(ray.d[axis]));
  }
  d[300] = d[301] = d[302] = 0;  // a bad one
  pvol_rays rays{};
  rays.count = kRays;
  rays.origins = api::vectors(o.data());
  rays.directions = api::vectors(d.data());
  pvol_streams streams{};
  streams.seed = 3;
  std::vector<double> t(kRays), expected(kRays), depths(kRays);
  std::vector<float> passed(kRays), expected_passed(kRays);
  EXPECT_EQ(v.flights(rays, streams, {t.data(), kRays}), 1u);
  EXPECT_EQ(v.transmittances(rays, PVOL_RATIO, streams, {passed.data(), kRays}), 1u);
  EXPECT_EQ(v.optical_depths(rays, {depths.data(), kRays}), 1u);
  const RayBatch batch{kRays, {o.data(), false, 12, 4}, {d.data(), false, 12, 4}};
  (void)sample_flights(field, batch, {.seed = 3}, expected.data());
  (void)sample_transmittances(field, batch, {.seed = 3}, Transmittance::ratio,
                              expected_passed.data());
  EXPECT_EQ(std::memcmp(t.data(), expected.data(), kRays * sizeof(double)), 0);
  EXPECT_EQ(std::memcmp(passed.data(), expected_passed.data(), kRays * sizeof(float)), 0);
  EXPECT_TRUE(std::isnan(t[100]) && std::isnan(depths[100]));
  for (std::size_t i = 0; i < kRays; ++i) {
    if (i == 100) continue;
    const Ray ray{{double(o[3 * i]), double(o[3 * i + 1]), double(o[3 * i + 2])},
                  {double(d[3 * i]), double(d[3 * i + 1]), double(d[3 * i + 2])}};
    EXPECT_NEAR(std::exp(-depths[i]), exact_transmittance(other, ray, api::kInfinity), 1e-12);
  }
  api::Volume uncommitted;
  EXPECT_EQ(uncommitted.flights(rays, streams, {t.data(), kRays}), kRays);
  EXPECT_TRUE(std::isnan(t[0]) && std::isnan(t[kRays - 1]));
}

TEST(CapiBatches, LengthsArePackedFloatsOrDoubles) {
  const Smoke smoke;
  const api::Volume v = make_smoke(smoke, 5);
  constexpr std::size_t kRays = 300;
  std::vector<double> o, d, doubles;
  std::vector<float> floats;
  Rng rng(8, 8, 9);
  for (std::size_t i = 0; i < kRays; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    o.insert(o.end(), ray.o, ray.o + 3), d.insert(d.end(), ray.d, ray.d + 3);
    floats.push_back(6 * rng.uniform());
    doubles.push_back(double(floats.back()));
  }
  const RayBatch batch{kRays,
                       {o.data(), true, 3 * sizeof(double), sizeof(double)},
                       {d.data(), true, 3 * sizeof(double), sizeof(double)},
                       {doubles.data(), true, sizeof(double)}};
  std::vector<double> t(kRays), expected(kRays);
  (void)sample_flights(BatchField(make_same(smoke, 5)), batch, {.seed = 3}, expected.data());
  pvol_rays rays{};
  rays.count = kRays;
  rays.origins = api::vectors(o.data()), rays.directions = api::vectors(d.data());
  pvol_streams streams{};
  streams.seed = 3;
  for (const pvol_vectors& lengths : {api::vectors(floats.data()), api::vectors(doubles.data())}) {
    rays.t_max = lengths;
    EXPECT_EQ(v.flights(rays, streams, {t.data(), kRays}), 0u);
    EXPECT_EQ(t, expected);
  }
}

}  // namespace rays_test
}  // namespace pvol::test
