// Statistics of the calls that other renderers make: flights, transmittances and paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "support/placed_clouds.h"
#include "support/statistics.h"

namespace pvol::test {
namespace embed_flights_test {

TEST(Embed, FlightsFollowTheExtinction) {
  proof::Family family;
  std::uint64_t stream = 1000;
  for_clouds([&](const PlacedCloud& cloud, const std::string& name) {
    proof::Histogram places(20);
    proof::Moments left;  // over the exact share of each ray
    for (int i = 0; i < 2000; ++i) {
      Rng rng(kPlacedSeed, stream, std::uint64_t(i));
      const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
      const RayOracle oracle = cloud.oracle(ray, t_max);
      const Flight f = sample_flight(cloud.volume, ray, t_max, rng);
      ASSERT_EQ(f.weight, 1) << name;
      const double t = oracle.transmittance();
      left.add((f.collided ? 0 : 1) - t);
      if (f.collided) {
        ASSERT_TRUE(f.t >= 0 && f.t <= t_max) << name;
        ASSERT_GT(extinction_at(cloud.volume, ray.at(f.t)) + 1e-5f * float(cloud.extinction), 0);
        places.add(std::clamp(oracle.cdf(f.t) / (1 - t), 0.0, 1.0));
      }
    }
    ++stream;
    family.add(name + ", places", places.uniform_p_value());
    family.add(name + ", left", proof::mean_p_value(left, 0, 1e-6));
  });
  EXPECT_TRUE(family.passes());
}

TEST(Embed, TransmittanceEstimatesFollowBeerAndLambert) {
  proof::Family family;
  std::uint64_t stream = 2000;
  for_clouds([&](const PlacedCloud& cloud, const std::string& name) {
    using enum Transmittance;
    for (const Transmittance estimator : {analog, ratio, residual_ratio, regular}) {
      proof::Moments excess;  // over the exact value, of many rays
      for (int i = 0; i < 800; ++i) {
        Rng rng(kPlacedSeed, stream, std::uint64_t(i));
        const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
        const float t = sample_transmittance(cloud.volume, ray, t_max, rng, estimator);
        ASSERT_TRUE(t >= -1e-6f && t <= 1 + 1e-6f) << name;
        excess.add(double(t) - exact_transmittance(cloud.volume, ray, t_max));
      }
      ++stream;
      family.add(name + ", " + std::to_string(int(estimator)),
                 proof::mean_p_value(excess, 0, 1e-6));
    }
  });
  EXPECT_TRUE(family.passes());
}

TEST(Embed, PathsGoOnWhereTheyCollided) {
  // Whether a flight leaves is chance with a known variance. The normal law takes many that do not.
  constexpr double kEnough = 20;
  proof::Family family;
  double all = 0, variance_of_all = 0;
  std::uint64_t stream = 8;
  for_clouds([&](const PlacedCloud& cloud, const std::string& name) {
    double more = 0, variance = 0;  // flights that left beyond what was to be expected
    ++stream;
    for (int i = 0; i < 400; ++i) {
      Rng rng(kPlacedSeed, stream, std::uint64_t(i));
      const Ray ray = cloud.aim(0, rng).ray;
      auto walk = enter(cloud.volume, ray);
      visit_field(cloud.volume, [&](const auto& field) {
        NoTally none;
        const Flight f = free_flight<Tracker::decomposition>(*walk, field, rng, none);
        if (!f.collided) return;
        const Vec3d on = PlacedCloud::random_direction(rng);
        const double t_max = 10 * cell_length(cloud.to_world);
        const Cursor here = walk->cursor_at(f.t);
        RayWalk next = resume(cloud.volume, here, on, t_max);
        const double t = exact_transmittance(cloud.volume, {ray.at(f.t), on}, t_max);
        if constexpr (CellField<std::remove_cvref_t<decltype(field)>>) {
          EXPECT_NEAR(std::exp(-optical_depth(next, field, none)), t, 2 * kRounding) << name;
        }
        RayWalk again = resume(cloud.volume, here, on, t_max);
        const Flight g = free_flight<Tracker::delta>(again, field, rng, none);
        EXPECT_TRUE(!g.collided || g.t <= t_max);
        more += (g.collided ? 0 : 1) - t;
        variance += t * (1 - t);
      });
    }
    if (variance > kEnough) family.add(name, proof::normal_p_value(more / std::sqrt(variance)));
    all += more, variance_of_all += variance;
  });
  EXPECT_GT(variance_of_all, kEnough);
  family.add("all", proof::normal_p_value(all / std::sqrt(variance_of_all)));
  EXPECT_TRUE(family.passes());
}

}  // namespace embed_flights_test
}  // namespace pvol::test
