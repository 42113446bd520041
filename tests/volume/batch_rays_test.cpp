// What batches read and whom they serve: arrays of every kind, bad rays, any volume.
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <memory>

#include "pvol/density/recipe.h"
#include "support/batches.h"

namespace pvol::test {
namespace batch_rays_test {

class BatchRays : public Batch {};
INSTANTIATE_TEST_SUITE_P(Kernels, BatchRays,
                         ::testing::Values(KernelKind::scalar, KernelKind::sse4, KernelKind::neon,
                                           KernelKind::avx2, KernelKind::avx512),
                         [](const auto& of) { return std::string(name(of.param)); });

// Arrays.

/// A ray in somebody's struct, where nothing is aligned.
#pragma pack(push, 1)
struct Packed {
  char tag;
  float t_max;
  float o[3];
  char more[2];
  double d[3];
};
#pragma pack(pop)

TEST_P(BatchRays, ReadsFloatsAndDoublesAtAnyStride) {
  const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 0.5);
  const BatchField f = ready(cloud);
  constexpr std::size_t n = 100;
  Rays rays = aimed(cloud, n, 36);
  std::vector<Packed> packed(n);
  std::vector<float> columns(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    Packed& p = packed[n - 1 - i];  // from the last one down
    p.t_max = float(std::min(rays.t_max[i], 1e30));
    for (int axis = 0; axis < 3; ++axis) {
      p.o[axis] = float(rays.o[i][axis]);
      columns[std::size_t(axis) * n + i] = float(rays.d[i][axis]);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    Packed& p = packed[n - 1 - i];
    const auto d = [&](std::size_t axis) { return double(columns[axis * n + i]); };
    rays.t_max[i] = double(p.t_max);
    rays.o[i] = {double(p.o[0]), double(p.o[1]), double(p.o[2])};
    rays.d[i] = {d(0), d(1), d(2)};
    for (std::size_t axis = 0; axis < 3; ++axis) p.d[2 - axis] = d(axis);  // z first
  }
  const Answers plain = answers(f, rays.batch(), {});
  constexpr auto kSize = std::ptrdiff_t(sizeof(Packed)), kFloat = std::ptrdiff_t(sizeof(float));
  const auto* const last = reinterpret_cast<const char*>(&packed.back());
  const VectorArray origins{last + offsetof(Packed, o), false, -kSize, kFloat};
  const VectorArray directions{last + offsetof(Packed, d) + 2 * sizeof(double), true, -kSize,
                               -std::ptrdiff_t(sizeof(double))};
  const NumberArray t_max{last + offsetof(Packed, t_max), false, -kSize};
  EXPECT_TRUE(answers(f, {n, origins, directions, t_max}, {}) == plain);
  const VectorArray by_column{columns.data(), false, kFloat, std::ptrdiff_t(n) * kFloat};
  EXPECT_TRUE(answers(f, {n, origins, by_column, t_max}, {}) == plain);
}

/// No t_max is an infinite one.
TEST_P(BatchRays, RaysWithoutEndGoOn) {
  const PlacedCloud cloud(field("gaussian"), {}, 0.5);
  Rays rays = aimed(cloud, 500, 37);
  rays.t_max.assign(500, kFar);
  RayBatch bare = rays.batch();
  bare.t_max = {};
  EXPECT_TRUE(answers(ready(cloud), bare, {}) == answers(ready(cloud), rays.batch(), {}));
}

// Rays that are bad, or meet nothing.

TEST_P(BatchRays, BadRaysAreNumbered) {
  const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 0.5);
  const BatchField f = ready(cloud);
  const double nan = std::nan("");
  Rays rays = aimed(cloud, 40, 38);
  const Answers good = answers(f, rays.batch(), {});
  rays.d[3] = {0, -0.0, 0}, rays.d[5] = {nan, 0, 1}, rays.d[7] = {kFar, 0, 0};
  rays.o[11] = {0, nan, 0}, rays.o[13] = {0, 0, -kFar}, rays.o[17] = Vec3d(DBL_MAX);
  rays.t_max[19] = nan;
  std::vector<double> t(40);
  std::vector<float> a(40), r(40), e(40);
  EXPECT_EQ(sample_flights(f, rays.batch(), {}, t.data()), 7u);
  EXPECT_EQ(sample_transmittances(f, rays.batch(), {}, kAnalog, a.data()), 7u);
  EXPECT_EQ(sample_transmittances(f, rays.batch(), {}, kRatio, r.data()), 7u);
  EXPECT_EQ(sample_transmittances(f, rays.batch(), {}, Transmittance::regular, e.data()), 7u);
  for (const std::size_t i : {3u, 5u, 7u, 11u, 13u, 17u, 19u}) {
    EXPECT_TRUE(std::isnan(t[i]) && std::isnan(a[i]) && std::isnan(r[i]) && std::isnan(e[i])) << i;
    t[i] = good.t[i], a[i] = good.analog[i], r[i] = good.ratio[i];
  }
  EXPECT_TRUE((Answers{t, a, r}) == good);
}

TEST_P(BatchRays, DirectionsMayHaveAnyLength) {
  const PlacedCloud cloud(field("constant"), placements()[1].to_world, 0.2);
  const BatchField f = ready(cloud);
  Rays rays = aimed(cloud, 500, 39);
  const std::vector<double> t = flights(f, rays.batch(), {});
  for (const double scale : {0x1p-1020, 0x1p-700, 0x1p-3, 0x1p700, 0x1p1022}) {
    Rays longer = rays;
    for (Vec3d& d : longer.d) d = d * scale;
    const std::vector<double> same = flights(f, longer.batch(), {});
    for (std::size_t i = 0; i < t.size(); ++i) {
      ASSERT_EQ(std::isinf(t[i]), std::isinf(same[i])) << scale;
      if (std::isinf(t[i])) continue;
      ASSERT_NEAR(t[i], same[i], 1e-3) << scale;
    }
  }
}

TEST_P(BatchRays, RaysThatMeetNothingSeeThrough) {
  const PlacedCloud cloud(field("gaussian"), {}, 1);
  const Vec3d centre = cloud.volume.density.world_box.centre();
  Rays rays;
  rays.add({centre + Vec3d(1000, 0, 0), {1, 0, 0}}, kFar);
  rays.add({centre + Vec3d(1000, 0, 0), {-1, 0, 0}}, 900);
  rays.add({centre, {1, 2, 3}}, 0);
  rays.add({centre, {1, 2, 3}}, -1);
  rays.add({centre + Vec3d(1e300, 0, 0), {1, 2, 3}}, kFar);
  // Along an axis, on either side of the box.
  for (const double beside : {-30, 30}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d off, along;
      off[axis] = beside, along[(axis + 1) % 3] = 1;
      rays.add({centre + off, along}, kFar);
    }
  }
  const std::size_t n = rays.o.size();
  const Answers all = answers(ready(cloud), rays.batch(), {});
  EXPECT_TRUE(all == (Answers{std::vector<double>(n, kFar), std::vector<float>(n, 1),
                              std::vector<float>(n, 1)}));
  EXPECT_TRUE(answers(ready(cloud), {}, {}) == Answers{});
}

// Single calls.

/// Those of any estimator, of any volume.
void expect_as_by_single_calls(const BatchField& f, const Volume& v, const Rays& rays) {
  const BatchNumbers n{.seed = 6, .first = 10, .sample = 2};
  using enum Transmittance;
  std::vector<Transmittance> estimators{ratio, analog, residual_ratio};
  if (v.density.look_up == kTrilinear && !v.density.map) estimators.push_back(regular);
  for (const Transmittance e : estimators) {
    if (f.kernel() != KernelKind::scalar && (e == ratio || e == analog)) continue;
    const std::vector<float> t = through(f, rays.batch(), n, e);
    for (std::size_t i = 0; i < t.size(); ++i) {
      Rng rng(6, 10 + i, 2);
      ASSERT_EQ(t[i], sample_transmittance(v, {rays.o[i], rays.d[i]}, rays.t_max[i], rng, e));
    }
  }
  if (f.kernel() != KernelKind::scalar) return;
  const std::vector<double> t = flights(f, rays.batch(), n);
  for (std::size_t i = 0; i < t.size(); ++i) {
    Rng rng(6, 10 + i, 2);
    ASSERT_EQ(t[i], sample_flight(v, {rays.o[i], rays.d[i]}, rays.t_max[i], rng).t);
  }
}

TEST_P(BatchRays, AnswersAsSingleCallsDo) {
  const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 0.5);
  expect_as_by_single_calls(ready(cloud), cloud.volume, aimed(cloud, 500, 35));
}

// Volumes that lanes do not serve.

void expect_scalar(const Volume& v, const std::string& reason, const Rays& rays) {
  const BatchField f(v);
  EXPECT_EQ(f.kernel(), KernelKind::scalar);
  EXPECT_NE(f.reason().find(reason), std::string::npos) << f.reason();
  EXPECT_NE(error_of([&] { BatchField(v, KernelKind::avx2); }), "");
  expect_as_by_single_calls(f, v, rays);
}

TEST(BatchesOfAnyVolume, TakeTheScalarKernelWhereLanesDoNotServe) {
  const PlacedCloud plain(field("gaussian"), placements()[1].to_world, 0.5);
  const Rays rays = aimed(plain, 200, 40);
  const auto with = [&](const VolumeOptions& o) {
    return PlacedCloud(plain.field, plain.to_world, 0.5, o).volume;
  };
  expect_scalar(with({.homogenise = 0.1}), "homogenised", rays);
  const PlacedCloud thick(plain.field, plain.to_world, 1e6);
  expect_scalar(thick.volume, "thick", rays);
  const Field nothing = make_field("nothing", {0, 0, 0}, {9, 9, 9}, [](Vec3i) { return 0; });
  expect_scalar(PlacedCloud(nothing, {}, 1).volume, "empty", rays);
}

TEST(BatchesOfAnyVolume, RefuseWhatEstimatesNothing) {
  const PlacedCloud cubic(field("gaussian"), {}, 1, {.look_up = LookUp::tricubic});
  const BatchField f(cubic.volume);
  float t;
  for (const auto e : {Transmittance::automatic, Transmittance::regular}) {
    EXPECT_THROW((void)sample_transmittances(f, {}, {}, e, &t), Error);
  }
}

}  // namespace batch_rays_test
}  // namespace pvol::test
