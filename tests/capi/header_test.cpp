// The C++17 header (pvol/pvol.hpp): its owners and values are those of the C calls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "capi/capi_fields.h"

namespace pvol::test {
namespace header_test {

TEST(CapiHeader, RangesDepthsAndSpansAreThoseOfC) {
  const Smoke smoke;
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(3);
  EXPECT_FALSE(v.extinction_range({0, 0, 0}, {1, 1, 1})) << "not committed";
  v.set_shell(true).commit();
  Rng rng(1, 2, 3);
  std::size_t inside = 0;
  for (int i = 0; i < 100; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    double depth;
    ASSERT_EQ(pvol_optical_depth(v.get(), &ray, &depth), 1);
    EXPECT_EQ(v.optical_depth(ray), depth);
    pvol_span spans[4], same[4];
    const std::size_t count = v.shell_spans(ray, {spans, 4});
    ASSERT_EQ(int(count), pvol_shell_spans(v.get(), &ray, same, 4));
    for (std::size_t k = 0; k < std::min<std::size_t>(count, 4); ++k) {
      EXPECT_EQ(std::pair(spans[k].t0, spans[k].t1), std::pair(same[k].t0, same[k].t1));
    }
    inside += count;
  }
  EXPECT_GT(inside, 0u);
  const auto box = v.box();
  ASSERT_TRUE(box);
  float range[2];
  ASSERT_EQ(pvol_extinction_range(v.get(), box->first.data(), box->second.data(), range), 1);
  EXPECT_EQ(v.extinction_range(box->first, box->second), (std::array{range[0], range[1]}));
  EXPECT_FALSE(v.extinction_range(box->second, box->first)) << "no box";

  const pvol_ray bad = api::ray({0, 0, 0}, {0, 0, 0});
  EXPECT_FALSE(v.optical_depth(bad));
  EXPECT_EQ(v.shell_spans(bad, {}), 0u);
}

TEST(CapiHeader, ChannelsAreThoseOfC) {
  const Smoke smoke;
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(3);
  const api::Rgb share{1, 0.5f, 0.25f}, throughput{1, 2, 3};
  v.set_extinction_color(share).commit();
  Rng rng(4, 5, 6);
  int collisions = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    api::Walk walk = v.enter(ray), same = walk;
    api::Random random(1, 2, i), other = random;
    const api::RgbFlight f = walk.flight_rgb(throughput, random);
    double t;
    api::Rgb weight, passed;
    const int collided =
        pvol_walk_flight_rgb(same.get(), throughput.data(), &other, &t, weight.data());
    EXPECT_EQ(f.t.has_value(), collided == 1);
    if (f.t) {
      EXPECT_EQ(*f.t, t);
    }
    EXPECT_EQ(f.weight, weight);
    collisions += collided;

    api::Walk through = v.enter(ray), again = through;
    pvol_walk_transmittance_rgb(again.get(), &other, passed.data());
    EXPECT_EQ(through.transmittance_rgb(random), passed);
  }
  EXPECT_GT(collisions, 0);
}

TEST(CapiHeader, FirstNumbersAreTaken) {
  const float numbers[] = {0.125f, 0.75f};
  api::Random random(1, 2, 3), own = random;
  random.begin_with({numbers, 2});
  EXPECT_EQ(random.uniform(), 0.125);
  EXPECT_EQ(random.uniform(), 0.75);
  EXPECT_EQ(random.uniform(), own.uniform()) << "then the stream's";
}

TEST(CapiHeader, TellsOfErrorsAndCancels) {
  api::Volume v;
  std::vector<std::pair<pvol_status, std::string>> heard;
  auto hear = [&](pvol_status status, const char* message) { heard.emplace_back(status, message); };
  v.set_error_function(hear);
  EXPECT_THROW(v.set_extinction(-1), api::Error);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0], (std::pair<pvol_status, std::string>(PVOL_INVALID, pvol_message(v.get()))));

  pvol_bricks bricks{};
  bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = 64;
  bricks.user = &v;
  bricks.fill = [](void* user, const std::int32_t*, float*) {
    static_cast<api::Volume*>(user)->cancel();
    return 0;
  };
  EXPECT_THROW(v.set(PVOL_DENSITY, bricks).commit(), api::Error);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1].first, PVOL_CANCELLED);
  v.set_error_function(nullptr, nullptr);
  EXPECT_THROW(v.set_extinction(-1), api::Error);
  EXPECT_EQ(heard.size(), 2u);

  double t;
  pvol_rays two{};
  two.count = 2;
  EXPECT_THROW((void)v.flights(two, {}, {&t, 1}), api::Error) << "room for one result alone";
}

/// With the same stream: the values of single calls where no lanes serve, else their mean.
TEST(CapiHeader, BatchesHaveTheDistributionOfSingleCalls) {
  const Smoke smoke;
  constexpr std::size_t kRays = 20'000;
  const pvol_ray ray = ray_between({-10, 19, 20}, {20, 20, 19});
  std::vector<double> origins, directions;
  for (std::size_t i = 0; i < kRays; ++i) {
    origins.insert(origins.end(), ray.o, ray.o + 3);
    directions.insert(directions.end(), ray.d, ray.d + 3);
  }
  pvol_rays rays{};
  rays.count = kRays;
  rays.origins = api::vectors(origins.data()), rays.directions = api::vectors(directions.data());
  for (const bool tricubic : {true, false}) {
    api::Volume v;
    v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(0.7);
    v.set_interpolation(tricubic ? PVOL_TRICUBIC : PVOL_TRILINEAR).commit();
    std::vector<double> t(kRays);
    EXPECT_EQ(v.flights(rays, {}, {t.data(), kRays}), 0u);
    double batch = 0, single = 0;
    for (std::uint64_t i = 0; i < kRays; ++i) {
      api::Random random(0, i, 0);
      const double own = v.flight(ray, random).value_or(api::kInfinity);
      batch += std::isinf(t[i]), single += std::isinf(own);
    }
    const double share = single / kRays, sigma = std::sqrt(2 * share * (1 - share) / kRays);
    EXPECT_GT(single, 0);
    EXPECT_NEAR(batch / kRays, share, 5 * sigma);
  }
}

}  // namespace header_test
}  // namespace pvol::test
