// Pictures of clouds in motion: against closed forms, against averages of still pictures, and what
// must not change.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "pvol/render/render.h"
#include "pvol/volume/motion.h"
#include "render/path/camera_rays.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/velocities.h"

namespace pvol::test {
namespace motion_blur_test {

/// A body with soft, uneven edges, from 0 to 28 along each axis.
const Field& puff() {
  static const Field f = make_field("puff", {0, 0, 0}, {28, 28, 28}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(14)) * 0.09;
    return std::clamp(2 * (1 - dot(d, d) + 0.3 * std::sin(0.9 * p.x) * std::sin(0.7 * p.y)), 0.0,
                      1.0);
  });
  return f;
}

/// A block of 16^3 samples of 1: along each axis the density climbs from -1 to 0, and falls from 15
/// to 16.
const Field& block() {
  static const Field f = make_field("block", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}
double block_profile(double y) { return std::clamp(std::min(y + 1, 16 - y), 0.0, 1.0); }

VelocityGrid everywhere(Vec3d velocity) {
  return make_velocity({-40, -40, -40}, {64, 64, 64}, [=](Vec3i) { return velocity; });
}
VelocityGrid swirl() {
  return make_velocity({-8, -8, -8}, {40, 40, 40}, [](Vec3i p) {
    return Vec3d(p.y - 14, 14 - p.x, 6 * std::sin(0.4 * p.x)) * (p.z > 14 ? 0.8 : -0.3);
  });
}

Volume moving(const Field& f, const CloudScene& s, const VelocityGrid& v, double seconds = 1) {
  const Pyramid p = build_pyramid(f.grid, s.options.look_up);
  return make_moving(make_volume(f.grid, p, s), p, f.grid.index_to_world,
                     {v, seconds, s.camera.shutter}, s.volume_options());
}

CloudScene scene_of(Shutter shutter) {
  CloudScene s;
  s.medium.extinction = 0.5;
  s.medium.albedo = Rgb(0.95f);
  s.environment = ConstantSky{Rgb(0.5f)};
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.camera.position = {14, 20, 110};
  s.camera.target = {14, 14, 14};
  s.camera.shutter = shutter;
  s.options.width = s.options.height = 16;
  s.options.samples = 256;
  s.options.threads = 1;
  return s;
}

TEST(MotionBlur, EveryPixelOfTheFurnaceIsTheSky) {
  for (const Tracker tracker : kTrackers) {
    if (tracker == Tracker::regular) continue;
    for (const LookUp look_up : {LookUp::nearest, LookUp::trilinear, LookUp::tricubic}) {
      CloudScene s = scene_of({-0.5, 0.25});
      s.medium.albedo = Rgb(1.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      s.lights.clear();
      s.options.tracker = tracker;
      s.options.look_up = look_up;
      s.options.samples = 8;
      const Volume v = moving(puff(), s, swirl());
      ASSERT_NE(v.density.motion, nullptr);
      std::vector<std::vector<Volume>> scenes{{v}};
      if (!is_weighted(tracker)) {  // beside one that stands still
        s.medium.object_to_world = translation({9, 3, -20});
        scenes.push_back({v, make_volume(puff().grid, build_pyramid(puff().grid, look_up), s)});
      }
      for (const auto& volumes : scenes) {
        double scattered = 0;
        for (const PixelSums& p : render(volumes, s).film.pixels) {
          EXPECT_EQ(mean(p), Vec3d(1.0)) << label(tracker) << ", " << name(look_up);
          scattered += p.alpha;
        }
        EXPECT_GT(scattered, 100);
      }
    }
  }
}

/// Through a block that moves across the view, as seen from so far that rays are parallel.
TEST(MotionBlur, TransmittanceAndEmissionAreTheirMeansOverTime) {
  proof::Family family;
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 0.75}, Shutter{0.5, 0.5}}) {
    for (const double place : {15.2, 8.0, -2.5, 21.0}) {
      for (const bool emits : {false, true}) {
        CloudScene s = scene_of(shutter);
        s.medium.extinction = 0.11;
        s.medium.albedo = Rgb(0.0f);
        s.medium.emission = Rgb(emits ? 1.0f : 0.0f);
        s.environment = ConstantSky{Rgb(emits ? 0.0f : 1.0f)};
        s.lights.clear();
        s.camera.position = {8, place, 1e5};
        s.camera.target = {8, place, 0};
        s.camera.fov = 1e-9;
        s.options.width = s.options.height = 4;
        s.options.samples = proof::samples(8192);
        const double speed = 13;
        const Volume v = moving(block(), s, everywhere({2, speed, 0.5}));
        double expected = 0;
        constexpr int kSteps = 20'000;
        for (int i = 0; i < kSteps; ++i) {
          const double t = shutter.at((i + 0.5) / kSteps);
          const double depth = s.medium.extinction * 16 * block_profile(place - speed * t);
          expected += (emits ? 1 - std::exp(-depth) : std::exp(-depth)) / kSteps;
        }
        compare(average(render(v, s).film), {Vec3d(expected), Vec3d(1e-14)},
                "at " + std::to_string(place), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// All of a cloud that moves the same way looks as the average of pictures of it at other places.
TEST(MotionBlur, AUniformVelocityIsATranslation) {
  proof::Family family;
  const Vec3d velocity(17, -9, 5);
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0.75, 0.75}}) {
    CloudScene s = scene_of(shutter);
    s.options.samples = proof::samples(2048);
    const Film blurred = render(moving(puff(), s, everywhere(velocity * 24), 1.0 / 24), s).film;
    CloudScene still = s;
    still.options.samples = 64;
    still.options.guide = GuideUse::off;
    const Film sum = over_shutter(shutter, 32, [&](double time, std::uint64_t seed) {
      still.options.seed = seed;
      still.medium.object_to_world = translation(velocity * time);
      return render(make_volume(puff().grid, build_pyramid(puff().grid), still), still).film;
    });
    compare(blurred, sum, "shutter from " + std::to_string(shutter.open), family);
  }
  EXPECT_TRUE(family.passes());
}

/// Placements turn velocities, too.
TEST(MotionBlur, VelocitiesAreThoseOfTheFileHoweverItIsPlaced) {
  Affine turned;  // x to y, and twice as large
  turned.m = {Vec3d{0, -2, 0}, Vec3d{2, 0, 0}, Vec3d{0, 0, 2}};
  CloudScene s = scene_of({1, 1}), still = s;
  s.medium.object_to_world = turned;
  still.medium.object_to_world = translation({0, 12, 0}) * turned;
  s.camera.target = still.camera.target = {-28, 30, 28};
  s.camera.position = still.camera.position = {-28, 30, 200};
  s.options.samples = still.options.samples = proof::samples(1024);
  proof::Family family;
  compare(render(moving(puff(), s, everywhere({6, 0, 0})), s).film,
          render(make_volume(puff().grid, build_pyramid(puff().grid), still), still).film, "turned",
          family);
  EXPECT_TRUE(family.passes());
}

TEST(MotionBlur, EstimatorsAgree) {
  proof::Family family;
  std::optional<Film> first;
  std::uint64_t seed = 4;
  for (const Tracker tracker : {Tracker::decomposition, Tracker::delta, Tracker::weighted_delta}) {
    for (const Transmittance t :
         {Transmittance::analog, Transmittance::ratio, Transmittance::residual_ratio}) {
      CloudScene s = scene_of({-0.5, 0.5});
      s.options.samples = proof::samples(256u);
      s.options.tracker = tracker;
      s.options.transmittance = t;
      s.options.seed = ++seed;
      const Film film = render(moving(puff(), s, swirl()), s).film;
      if (first) compare(*first, film, std::string(name(tracker)) + ", " + name(t), family);
      if (!first) first = film;
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Velocities elsewhere leave the picture the same on average, though bounds were made anew.
TEST(MotionBlur, WhatDoesNotMoveLooksStill) {
  CloudScene s = scene_of({-0.5, 0.5});
  const VelocityGrid far =
      make_velocity({96, 96, 96}, {104, 104, 104}, [](Vec3i) { return Vec3d(1); });
  const Volume v = moving(puff(), s, far);
  ASSERT_NE(v.density.motion, nullptr);
  s.options.seed = 3;
  proof::Family family;
  CloudScene still = s;
  still.camera.shutter = {};
  compare(render(v, s).film,
          render(make_volume(puff().grid, build_pyramid(puff().grid), still), still).film,
          "far away", family);
  EXPECT_TRUE(family.passes());
}

TEST(MotionBlur, AClosedShutterChangesNothing) {
  CloudScene s = scene_of({});
  s.options.samples = 16;
  const Volume still = make_volume(puff().grid, build_pyramid(puff().grid), s);
  const Film expected = render(still, s).film;
  EXPECT_TRUE(same_bytes(render(moving(puff(), s, swirl()), s).film, expected));
  // Nor does an open one before what has no velocities.
  s.camera.shutter = {-0.5, 0.5};
  s.camera.fps = 30;
  EXPECT_TRUE(same_bytes(render(still, s).film, expected));
}

TEST(MotionBlur, SamplesHaveTimesOfTheirOwnInEachPartOfTheShutter) {
  CloudScene s = scene_of({0.25, 1.25});
  const Volume v = moving(puff(), s, swirl());
  const RenderPlan p = plan(std::span(&v, 1), s.scene());
  EXPECT_TRUE(p.kernel.moving);
  const detail::PathSetup setup(p);
  std::set<float> first;
  proof::Moments mean;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      first.insert(detail::sample_time(setup, {x, y, 0}));
      for (const std::uint32_t start : {0u, 64u, 1024u}) {
        std::set<int> parts;
        for (std::uint32_t i = 0; i < 64; ++i) {
          const double t = double(detail::sample_time(setup, {x, y, start + i}));
          EXPECT_GE(t, 0.25);
          EXPECT_LE(t, 1.25);
          parts.insert(int((t - 0.25) * 64 * (1 - 1e-6)));
          mean.add(t);
        }
        EXPECT_GE(parts.size(), 63u) << "but for rounding at the ends";
      }
    }
  }
  EXPECT_EQ(first.size(), 64u);
  EXPECT_NEAR(mean.mean(), 0.75, 1e-3);
}

TEST(MotionBlur, ThePlanSaysWhatItTakes) {
  CloudScene s = scene_of({-0.5, 0.5});
  s.options.micro_bounds = MicroBoundsUse::edge_2;
  const Volume v = moving(puff(), s, swirl());
  EXPECT_EQ(v.density.micro.edge, 0);
  const auto refused = [&](const CloudScene& with) {
    return error_of([&] { (void)plan(std::span(&v, 1), with.scene()); });
  };
  const RenderPlan p = plan(std::span(&v, 1), s.scene());
  const Volume still = make_volume(puff().grid, build_pyramid(puff().grid), s);
  EXPECT_EQ(p.kernel.kind, plan(std::span(&still, 1), s.scene()).kernel.kind);
  EXPECT_TRUE(p.warnings.empty()) << p.warnings.front();
  const auto changed = [&](const auto& change) {
    CloudScene with = s;
    change(with);
    return refused(with);
  };
  EXPECT_TRUE(says(changed([](auto& c) { c.options.transmittance = Transmittance::regular; }),
                   "motion.regular_tracking_regular"));
  EXPECT_TRUE(says(changed([](auto& c) { c.options.tracker = Tracker::regular; }),
                   "motion.regular_tracking_regular"));
  EXPECT_TRUE(says(changed([](auto& c) { c.camera.shutter.close = 1; }),
                   "motion.volume_of_another_shutter"));
  const Volume fast = moving(puff(), s, everywhere({100, 0, 0}));
  const RenderPlan doubtful = plan(std::span(&fast, 1), s.scene());
  ASSERT_FALSE(doubtful.warnings.empty());
  EXPECT_TRUE(says(doubtful.warnings.back(), "motion.shutter_open_medium"));
}

}  // namespace motion_blur_test
}  // namespace pvol::test
