// Trackers, the squeeze and whole images of tricubic fields.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "pvol/embed.h"
#include "pvol/error.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/render/render.h"
#include "pvol/trackers.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/field_proof.h"
#include "support/flights.h"
#include "support/pictures.h"

namespace pvol::test {
namespace tricubic_tracking_test {

constexpr auto kTricubic = LookUp::tricubic;
constexpr double kDepth = 2;

Volume make_tricubic(const Field& f, std::optional<int> depth) {
  return make_test_volume(f, 1, depth, Tracker::delta, kTricubic);
}

TEST(TricubicTracking, FollowsTheOpticalDepth) {
  proof::Family family, together;
  std::map<std::string, FlightHistogram> sums;
  std::uint64_t stream = 0;
  for (const Field& f : fields()) {
    for (const std::optional<int> depth : {std::optional<int>(16), std::optional<int>()}) {
      const Volume v = make_tricubic(f, depth);
      for (int ray = 0; ray < kRays; ++ray) {
        const Aim a = aim(f, v, kTricubic, ray, kDepth);
        prove(v.density.octree, a, exact<kTricubic>(v), proof::samples(2000, 2),
              f.name + ", ray " + std::to_string(ray), stream, family, sums);
      }
    }
  }
  for (const auto& [name, sum] : sums) together.add(name, sum.p_value());
  EXPECT_TRUE(family.passes());
  EXPECT_TRUE(together.passes());
}

/// Bounds of the wider kernel under look-ups of the narrower one.
TEST(TricubicTracking, BoundsServeTrilinearLookups) {
  proof::Family family;
  std::map<std::string, FlightHistogram> sums;
  std::uint64_t stream = 50'000;
  for (const char* name : {"gaussian", "sparse", "tiles_128"}) {
    const Field& f = field(name);
    const Volume v = pvol::make_volume(f.grid, build_pyramid(f.grid, kTricubic),
                                       CloudScene{}.medium.medium(), VolumeOptions{});
    const Aim a = aim(f, v, LookUp::trilinear, 0, kDepth);
    prove(v.density.octree, a, exact<LookUp::trilinear>(v), 4000, name, stream, family, sums);
  }
  EXPECT_TRUE(family.passes());
}

/// Over six fields and three rays each.
double p_value_with_extinction_times(float factor) {
  std::optional<FlightHistogram> sum;
  std::uint64_t stream = 10'000;
  for (const char* name : {"gaussian", "linear", "exponential", "sparse", "tiles_8", "far"}) {
    const Volume v = make_tricubic(field(name), std::nullopt);
    for (int ray = 0; ray < kRays; ++ray) {
      const Aim a = aim(field(name), v, kTricubic, ray, kDepth);
      const PlainField wrong{[&](const Segment& s, const LatticePoint& p) {
        return factor * exact<kTricubic>(v).source(s, p);
      }};
      if (!sum) sum.emplace(a.oracle);
      sum->add(sample_flights<Tracker::delta>(v.density.octree, a, wrong, proof::samples(60'000),
                                              ++stream));
    }
  }
  return sum->p_value();
}

/// On a commit of two, by as many flights as are to find them there.
TEST(TricubicTracking, TheProofFindsAnErrorOfOnePerCent) {
  EXPECT_GT(p_value_with_extinction_times(1), proof::kFalseAlarmRate);
  EXPECT_LT(p_value_with_extinction_times(proof::runs_all() ? 0.99f : 0.98f), 1e-6);
}

TEST(TricubicSqueeze, IsBitIdenticalToPlainTracking) {
  for (const Field& f : fields()) {
    SCOPED_TRACE(f.name);
    const Volume v = make_tricubic(f, 16);
    const BrickExtinction<kTricubic> source{v.density.bricks(), v.density.octree, v.density.scale};
    const MicroBounds one = build_micro_bounds(v.density.bricks(), 1),
                      two = build_micro_bounds(v.density.bricks(), 2);
    const SqueezedField<CubeBounds, BrickExtinction<kTricubic>> single{source, {one}};
    const SqueezedField<CubeBounds, BrickExtinction<kTricubic>> cubes{source, {two}};
    for (int ray = 0; ray < kRays; ++ray) {
      const Aim a = aim(f, v, kTricubic, ray, kDepth);
      const PlainField plain{source};
      const double fine = compare_flights<Tracker::delta>(v.density.octree, a, plain, single, 2000);
      const double coarse =
          compare_flights<Tracker::delta>(v.density.octree, a, plain, cubes, 2000);
      (void)compare_flights<Tracker::decomposition>(v.density.octree, a, plain, single, 2000);
      if (f.name == "gaussian") {
        EXPECT_LT(fine, 0.25);
        EXPECT_LT(coarse, 0.45);
      }
    }
  }
}

CloudScene small_scene(Tracker tracker) {
  CloudScene s;
  s.medium.extinction = 0.8;
  s.options.tracker = tracker;
  s.options.look_up = kTricubic;
  s.options.width = s.options.height = 24;
  s.options.samples = 8;
  return s;
}

/// In single cells, 2^3 of them, and none, with every analog tracker.
TEST(TricubicSqueeze, LeavesEveryImageAsItIs) {
  const Field& f = field("gaussian");
  const Pyramid p = build_pyramid(f.grid, kTricubic);
  for (const Tracker tracker : {Tracker::delta_global, Tracker::delta, Tracker::decomposition}) {
    CloudScene s = small_scene(tracker);
    std::optional<Film> first;
    std::uint64_t lookups = ~std::uint64_t(0);
    for (const auto micro :
         {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1}) {
      s.options.micro_bounds = micro;
      s.options.count = true;
      const Volume v = make_volume(f.grid, p, s);
      s.camera = frame(v.density.world_box, 1);
      const RenderResult r = render(v, s);
      if (!first) first = r.film;
      EXPECT_TRUE(same_bytes(*first, r.film)) << label(tracker);
      EXPECT_LT(r.counts.path.lookups, lookups) << label(tracker);
      lookups = r.counts.path.lookups;
    }
  }
}

TEST(TricubicImages, AreTheSkyInAFurnace) {
  for (const char* name : {"gaussian", "tiles_8", "contrast"}) {
    const Field& f = field(name);
    for (const Tracker tracker : kTrackers) {
      if (tracker == Tracker::regular) continue;
      CloudScene s = small_scene(tracker);
      s.medium.albedo = Rgb(1.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      const Volume v = make_volume(f.grid, build_pyramid(f.grid, kTricubic), s);
      s.camera = frame(v.density.world_box, 1);
      double scattered = 0;
      for (const PixelSums& p : render(v, s).film.pixels) {
        // Weights move by the rounding of look-ups above their majorants, if at all.
        EXPECT_NEAR(mean(p).y, 1, is_weighted(tracker) ? 1e-3 : 0) << name << label(tracker);
        scattered += p.alpha;
      }
      EXPECT_GT(scattered, 100);
    }
  }
}

TEST(TricubicImages, HaveNoClosedForm) {
  const Field& f = field("gaussian");
  CloudScene s = small_scene(Tracker::regular);
  const Volume v = make_volume(f.grid, build_pyramid(f.grid, kTricubic), s);
  s.camera = frame(v.density.world_box, 1);
  EXPECT_THROW((void)render(v, s), Error);
  s.options.tracker = Tracker::delta;
  s.options.transmittance = Transmittance::regular;
  EXPECT_THROW((void)render(v, s), Error);
  const Ray ray{{-30, 0, 0}, {1, 0, 0}};
  Rng rng(1, 2, 3);
  EXPECT_THROW((void)exact_transmittance(v, ray, 100), Error);
  EXPECT_THROW((void)sample_transmittance(v, ray, 100, rng, Transmittance::regular), Error);
}

TEST(TricubicEmbedding, LooksUpAndEstimates) {
  const Field& f = field("gaussian");
  const Volume v = make_volume(f.grid, {.extinction = 0.3}, {.look_up = kTricubic});
  Rng rng(kSeed, 3, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d p = random_point_near_density(f, rng);
    EXPECT_NEAR(double(density_at(v, p)), density_at(f, kTricubic, p), 1e-5);
  }
  const Ray ray{{-40, 1.3, 2.1}, {1, 0, 0}};
  const RayOracle oracle(f, kTricubic, ray, 0.3);
  proof::Moments m;
  for (int i = 0; i < 20'000; ++i) m.add(double(sample_transmittance(v, ray, 1e9, rng)));
  EXPECT_GT(proof::mean_p_value(m, oracle.transmittance()), proof::kFalseAlarmRate);
}

}  // namespace tricubic_tracking_test
}  // namespace pvol::test
