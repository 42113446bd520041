// Batches of rays with every kernel: against the laws that single rays follow, and against
// themselves.
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <memory>
#include <thread>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/math/field_map.h"
#include "pvol/trackers.h"
#include "pvol/volume/make_volume.h"
#include "support/batches.h"
#include "support/recipes.h"
#include "support/simd_kernels.h"
#include "support/statistics.h"

namespace pvol::test {
namespace batch_test {

INSTANTIATE_TEST_SUITE_P(Kernels, Batch,
                         ::testing::Values(KernelKind::scalar, KernelKind::sse4, KernelKind::neon,
                                           KernelKind::avx2, KernelKind::avx512),
                         [](const auto& of) { return std::string(name(of.param)); });

// Laws.

/// Over fields and placements of every kind, rays from inside and outside, whole and cut off: each
/// cloud by its p-value, and all together to 0.3 %.
void follow_the_law(KernelKind kernel, LookUp look_up) {
  const std::size_t kEach = proof::samples<std::size_t>(6000);
  proof::Family family;
  proof::Moments left_all, analog_all, ratio_all;
  double exact_all = 0, left_sum = 0, analog_sum = 0, ratio_sum = 0;
  std::uint64_t sample = 0;
  for_clouds(
      [&](const PlacedCloud& cloud, const std::string& name) {
        const BatchField f(cloud.volume, kernel);
        ASSERT_EQ(f.kernel(), kernel);
        const Rays rays = aimed(cloud, 3 * kKinds, 20);
        proof::Histogram places(20);
        proof::Moments left, analog, ratio;
        for (std::size_t i = 0; i < rays.o.size(); ++i) {
          const Ray ray{rays.o[i], rays.d[i]};
          const RayOracle oracle = cloud.oracle(ray, rays.t_max[i]);
          const double exact = oracle.transmittance();
          const RayBatch batch = again(ray, rays.t_max[i], kEach);
          const auto numbers = [&] {
            return BatchNumbers{.seed = kPlacedSeed, .sample = ++sample};
          };
          const std::vector<double> t = flights(f, batch, numbers());
          const std::vector<float> a = through(f, batch, numbers(), kAnalog);
          const std::vector<float> r = through(f, batch, numbers(), kRatio);
          for (std::size_t k = 0; k < kEach; ++k) {
            const bool leaves = std::isinf(t[k]);
            left.add(double(leaves) - exact), left_all.add(double(leaves) - exact);
            analog.add(double(a[k]) - exact), analog_all.add(double(a[k]) - exact);
            ratio.add(double(r[k]) - exact), ratio_all.add(double(r[k]) - exact);
            left_sum += leaves, analog_sum += double(a[k]), ratio_sum += double(r[k]);
            exact_all += exact;
            ASSERT_TRUE(a[k] == 0 || a[k] == 1);
            ASSERT_TRUE(r[k] >= 0 && r[k] <= 1);
            if (leaves) continue;
            ASSERT_TRUE(t[k] >= 0 && t[k] <= rays.t_max[i]) << name;
            if (k < kEach / 8) places.add(std::clamp(oracle.cdf(t[k]) / (1 - exact), 0.0, 1.0));
          }
        }
        family.add(name + ", places", places.uniform_p_value());
        family.add(name + ", left", proof::mean_p_value(left, 0, 1e-6));
        family.add(name + ", analog", proof::mean_p_value(analog, 0, 1e-6));
        family.add(name + ", ratio", proof::mean_p_value(ratio, 0, 1e-6));
      },
      {.look_up = look_up});
  family.add("left", proof::mean_p_value(left_all, 0, 1e-6));
  family.add("analog", proof::mean_p_value(analog_all, 0, 1e-6));
  family.add("ratio", proof::mean_p_value(ratio_all, 0, 1e-6));
  EXPECT_TRUE(family.passes());
  EXPECT_NEAR(left_sum / exact_all, 1, 0.003);
  EXPECT_NEAR(analog_sum / exact_all, 1, 0.003);
  EXPECT_NEAR(ratio_sum / exact_all, 1, 0.003);
}

TEST_P(Batch, FollowsBeerAndLambertTrilinear) { follow_the_law(GetParam(), kTrilinear); }
TEST_P(Batch, FollowsBeerAndLambertNearest) { follow_the_law(GetParam(), kNearest); }

/// Flights and ratios along one ray through the middle of a field, of this optical depth.
void add_one_ray(KernelKind kernel, const Field& of, LookUp look_up, double depth,
                 proof::Family& family) {
  const PlacedCloud one(of, placements()[1].to_world, 1, {.look_up = look_up});
  const Vec3d d{10, 3, 0.1};
  const Ray ray{one.volume.density.world_box.centre() - d * 50.0, d};
  const double extinction = depth / one.oracle(ray).optical_depth();
  const PlacedCloud cloud(of, one.to_world, extinction, {.look_up = look_up});
  const BatchField f(cloud.volume, kernel);
  const std::size_t kRays = proof::samples<std::size_t>(600'000);
  proof::Moments left, ratio;
  for (const double t : flights(f, again(ray, kFar, kRays), {.seed = proof::seeded(8)}))
    left.add(std::isinf(t));
  for (const float t : through(f, again(ray, kFar, kRays), {.seed = proof::seeded(9)}, kRatio)) {
    ratio.add(double(t));
  }
  const double exact = exact_transmittance(cloud.volume, ray, kFar);
  const std::string name = of.name + ", depth " + std::to_string(depth);
  family.add(name + ", flights", proof::mean_p_value(left, exact, 1e-5 * exact));
  family.add(name + ", ratio", proof::mean_p_value(ratio, exact, 1e-5 * exact));
}

/// 1, but for a lattice point of each leaf.
Field with_corners(const std::string& name, double density) {
  return make_field(name, {0, 0, 0}, {64, 64, 64},
                    [=](Vec3i p) { return (p.x | p.y | p.z) % 8 == 0 ? density : 1.0; });
}

/// Where transmittances are products of many factors, and end by the roulette.
TEST_P(Batch, FollowsBeerAndLambertInTheDark) {
  const Field loose = with_corners("loose bounds", 4);
  proof::Family family;
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    add_one_ray(GetParam(), field("gaussian"), look_up, 6, family);
    add_one_ray(GetParam(), loose, look_up, 4, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Nearly everywhere the extinction is one of the bounds of its leaf: what is wrong with a bound
/// shows.
TEST_P(Batch, FollowsBeerAndLambertAtItsBounds) {
  const Field spikes = with_corners("spikes", 1.4), dips = with_corners("dips", 0.6);
  proof::Family family;
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    add_one_ray(GetParam(), spikes, look_up, 2, family);
    add_one_ray(GetParam(), dips, look_up, 2, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Loose bounds before nothing, far from the corner of their box, where rounding carries a few
/// tentative collisions in a thousand rays across the face: into a leaf without a majorant.
TEST_P(Batch, PassesFromLooseBoundsIntoNothing) {
  const Field sparks = make_field("sparks", {0, 0, 0}, {4000, 8, 8}, [](Vec3i p) {
    return p == Vec3i(0, 1, 1) || p == Vec3i(3970, 1, 1) || p == Vec3i(3990, 6, 6) ? 1 : 0;
  });
  const PlacedCloud cloud(sparks, {}, 10);
  const Ray between{{3965, 4.3, 4.3}, {1, 0, 0}};
  ASSERT_EQ(exact_transmittance(cloud.volume, between, kFar), 1);
  for (const Transmittance estimator : {kRatio, kAnalog}) {
    const auto t = through(ready(cloud), again(between, kFar, 20'000), {.seed = 5}, estimator);
    EXPECT_EQ(std::ranges::count(t, 1.0f), 20'000);
  }
}

/// A slab between planes: what collides lies in it, give or take a few ulps of the way inside.
TEST_P(Batch, DistancesAreThoseOfTheWorld) {
  const Field slab = make_field("slab", {0, 0, 0}, {200, 8, 8},
                                [](Vec3i p) { return p.x >= 150 && p.x < 153 ? 1 : 0; });
  const Affine placement = scaling(Vec3d(0.25));
  const PlacedCloud cloud(slab, placement, 2, {.look_up = kNearest});
  const BatchField f = ready(cloud);
  for (const double away : {0.0, 100.0}) {
    const Ray ray{{1 - away, 1, 1}, {3, 0, 0}};
    const std::vector<double> t = flights(f, again(ray, kFar, 20'000), {.seed = 4});
    const double begin = 149.5 * 0.25 - ray.o.x, end = begin + 0.75;
    double least = kFar, most = 0;
    for (const double at : t) {
      if (std::isinf(at)) continue;
      least = std::min(least, at), most = std::max(most, at);
    }
    const double ulps = 4 * 50 * FLT_EPSILON;
    EXPECT_GE(least, begin - ulps);
    EXPECT_LE(most, end + ulps);
    EXPECT_LT(least, begin + 1e-3);
    EXPECT_GT(most, end - 1e-3);
  }
}

// Independence.

TEST_P(Batch, CompanyChangesNoBit) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    const PlacedCloud cloud(field("sparse"), placements()[2].to_world, 0.6, {.look_up = look_up});
    const BatchField f = ready(cloud);
    const Rays rays = aimed(cloud, 5000, 30);
    const BatchNumbers numbers{.seed = 5, .first = 1000, .sample = 3};
    const Answers whole = answers(f, rays.batch(), numbers);
    for (const std::size_t step : {std::size_t(1), std::size_t(7), std::size_t(1025)}) {
      Answers parts;
      for (std::size_t at = 0; at < 5000; at += step) {
        BatchNumbers n = numbers;
        n.first += at;
        parts.append(answers(f, rays.part(at, std::min(step, 5000 - at)), n));
      }
      EXPECT_TRUE(parts == whole) << step;
    }
    // In another order, among rays of other streams.
    Rays mixed;
    std::vector<std::uint64_t> streams;
    for (std::size_t k = 0; k < 5000; ++k) {
      const std::size_t i = k * 1237 % 5000;
      mixed.add({rays.o[i], rays.d[i]}, rays.t_max[i]);
      streams.push_back(1000 + i);
    }
    const Answers other =
        answers(f, mixed.batch(), {.seed = 5, .first = 77, .sample = 3, .streams = streams.data()});
    for (std::size_t k = 0; k < 5000; ++k) {
      const std::size_t i = k * 1237 % 5000;
      EXPECT_EQ(other.t[k], whole.t[i]);
      EXPECT_EQ(other.analog[k], whole.analog[i]);
      EXPECT_EQ(other.ratio[k], whole.ratio[i]);
    }
  }
}

TEST_P(Batch, ThreadsShareAField) {
  const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 0.5);
  const std::unique_ptr<const BatchField> f = std::make_unique<BatchField>(ready(cloud));
  const Rays rays = aimed(cloud, 8000, 31);
  const Answers whole = answers(*f, rays.batch(), {});
  std::vector<Answers> parts(4);
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < 4; ++k) {
      threads.emplace_back([&, k] {
        const BatchField mine = *f;
        parts[k] = answers(mine, rays.part(k * 2000, 2000), {.first = k * 2000});
      });
    }
  }
  Answers together;
  for (const Answers& part : parts) together.append(part);
  EXPECT_TRUE(together == whole);
}

TEST_P(Batch, MicroBoundsChangeNoBit) {
  const auto with = [&](MicroBoundsUse use) {
    const PlacedCloud cloud(field("contrast"), placements()[1].to_world, 0.5,
                            {.micro_bounds = use});
    return answers(ready(cloud), aimed(cloud, 3000, 32).batch(), {});
  };
  const Answers plain = with(MicroBoundsUse::none);
  EXPECT_TRUE(with(MicroBoundsUse::edge_2) == plain);
  EXPECT_TRUE(with(MicroBoundsUse::codes) == plain);
  EXPECT_TRUE(with(MicroBoundsUse::edge_1) == plain);
}

/// The same random numbers decide both.
TEST_P(Batch, AnalogIsWhetherAFlightLeaves) {
  const PlacedCloud cloud(field("gaussian"), {}, 0.5);
  const Answers all = answers(ready(cloud), aimed(cloud, 3000, 33).batch(), {});
  for (std::size_t i = 0; i < 3000; ++i) ASSERT_EQ(all.analog[i], float(std::isinf(all.t[i])));
}

/// Of fields that lanes ask one by one, rays end where single rays do.
TEST_P(Batch, HasTheMeansOfSingleRaysForEveryKindOfLookUp) {
  const auto map = std::make_shared<const FieldMap>(
      FieldMap{.ramp = {{{0, 0}, {0.2f, 1.5f}, {0.5f, 0}, {1, 0.7f}}, true}});
  const auto recipe = std::make_shared<const Recipe>(make_sample());
  const VoxelGrid& grid = field("contrast").grid;
  const Medium medium{.extinction = 0.3}, thick{.extinction = 2};
  const std::pair<std::string, Volume> volumes[] = {
      {"tricubic", make_volume(grid, medium, {.look_up = LookUp::tricubic})},
      {"mapped", make_volume(grid, medium, {.map = map})},
      {"recipe", make_volume(recipe, build_pyramid(*recipe), thick, {})},
  };
  proof::Family family;
  for (const auto& [what, v] : volumes) {
    const BatchField f(std::make_shared<const Volume>(v), GetParam());
    ASSERT_EQ(f.kernel(), GetParam()) << what;
    const Vec3d middle = v.density.world_box.centre();
    const Ray ray{middle - Vec3d(50, 20, 30), normalize(Vec3d(50, 20.3, 30.1))};
    const std::size_t rays = proof::samples<std::size_t>(100'000);
    const double far = 1000;
    const RayBatch batch = again(ray, far, rays);
    const std::vector<double> t = flights(f, batch, {.seed = 3});
    const std::vector<float> r = through(f, batch, {.seed = 4}, kRatio);
    proof::Moments left, ratio, distance, single_left, single_distance;
    for (std::size_t i = 0; i < rays; ++i) {
      left.add(std::isinf(t[i])), ratio.add(double(r[i]));
      if (!std::isinf(t[i])) distance.add(t[i]);
      Rng rng(proof::seeded(5), 0, i);
      const Flight one = sample_flight(v, ray, far, rng);
      single_left.add(!one.collided);
      if (one.collided) single_distance.add(one.t);
    }
    EXPECT_GT(single_left.mean(), 0.01) << what;
    EXPECT_LT(single_left.mean(), 0.99) << what;
    family.add(what + ", left", proof::equal_means_p_value(left, single_left));
    family.add(what + ", ratio", proof::equal_means_p_value(ratio, single_left));
    family.add(what + ", distance", proof::equal_means_p_value(distance, single_distance));
  }
  EXPECT_TRUE(family.passes());
}

TEST(Batches, KernelsOfEveryWidthGiveTheSameBits) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    const PlacedCloud cloud(field("contrast"), placements()[2].to_world, 1, {.look_up = look_up});
    std::vector<Answers> all;
    const std::vector<KernelKind> kernels = fusing_kernels();
    if (kernels.size() < 2) GTEST_SKIP() << "the machine has one such kernel at most";
    for (const KernelKind kernel : kernels) {
      all.push_back(answers(BatchField(cloud.volume, kernel), aimed(cloud, 5000, 34).batch(), {}));
    }
    EXPECT_TRUE(all[0] == all[1]);
  }
}

}  // namespace batch_test
}  // namespace pvol::test
