// Fires that move with the velocities of their file: against closed forms and what stands still.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pvol/render/render.h"
#include "pvol/volume/motion.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/velocities.h"

namespace pvol::test {
namespace moving_fire_test {

/// A block of 16^3 samples of 1: along each axis it climbs from -1 to 0, and falls from 15 to 16.
const Field& block() {
  static const Field f = make_field("block", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}

/// Smoke, the fire in it and its temperature, each with a lattice of its own extent.
const Field& smoke() {
  static const Field f = make_field("smoke", {0, 0, 0}, {32, 32, 32}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(15)) / 13.0;
    return std::max(0.0, 1 - dot(d, d)) * (1 + 0.5 * std::sin(0.9 * p.x) * std::sin(0.7 * p.y));
  });
  return f;
}
const Field& flame() {
  static const Field f = make_field("flame", {8, 0, 8}, {16, 40, 16}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(15, 20, 15)) * Vec3d(0.2, 0.06, 0.2);
    return std::max(0.0, 1 - dot(d, d));
  });
  return f;
}
const Field& heat() {
  static const Field f = make_field("heat", {0, -8, 0}, {32, 56, 32},
                                    [](Vec3i p) { return 0.6 + 0.4 * std::sin(0.5 * p.y); });
  return f;
}

VelocityGrid everywhere(Vec3d velocity) {
  return make_velocity({-40, -40, -40}, {72, 88, 72}, [=](Vec3i) { return velocity; });
}

Emitter fire_of(const Field& field, const Field* color_by, const Fire& fire, const Affine& place) {
  const Pyramid own = build_pyramid(field.grid);
  const Pyramid other = color_by ? build_pyramid(color_by->grid) : Pyramid{};
  const BoundedGrid colors{color_by ? color_by->grid : field.grid, other};
  return make_emitter(fire, {field.grid, own}, color_by ? &colors : nullptr, place);
}

std::shared_ptr<const Emitter> moving(Emitter fire, const Field& field, const Movement& by) {
  const Pyramid pyramid = build_pyramid(field.grid);
  return std::make_shared<const Emitter>(
      make_moving(std::move(fire), {field.grid, pyramid}, {}, by));
}

/// A fire alone that crosses the view, as seen from so far that rays are parallel.
TEST(MovingFire, AloneIsItsMeanOverTime) {
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 0.75}, Shutter{0.5, 0.5}}) {
    for (const double place : {15.2, 8.0, -2.5, 21.0}) {
      CloudScene s;
      s.environment = ConstantSky{Rgb(0.0f)};
      s.camera = {
          .position = {8, place, 1e5}, .target = {8, place, 0}, .fov = 1e-9, .shutter = shutter};
      s.options.width = s.options.height = 4;
      s.options.samples = proof::samples(8192);
      constexpr double kSpeed = 13;
      const VelocityGrid velocity = everywhere({2, kSpeed, 0.5});
      Volume v = make_volume(VoxelGrid{}, Pyramid{}, s);
      v.fire = moving(fire_of(block(), nullptr, {.intensity = 0.25}, {}), block(),
                      {velocity, 1, shutter});
      ASSERT_NE(v.fire->field.motion, nullptr);
      double expected = 0;
      constexpr int kSteps = 20'000;
      for (int i = 0; i < kSteps; ++i) {
        const double y = place - kSpeed * shutter.at((i + 0.5) / kSteps);
        expected += 0.25 * 16 * std::clamp(std::min(y + 1, 16 - y), 0.0, 1.0) / kSteps;
      }
      const Average a = average(render(v, s).film);
      EXPECT_NEAR(a.mean.x, expected, 5 * std::sqrt(a.variance.x) + 1e-5 * expected)
          << "at " << place << ", shutter from " << shutter.open;
      EXPECT_LE(a.mean.x > 0 ? std::sqrt(a.variance.x) / a.mean.x : 0, 0.02);
    }
  }
}

/// Smoke, its fire and the colours of that move together, and light the smoke.
TEST(MovingFire, InItsSmokeIsTheMeanOfPicturesOverTheShutter) {
  proof::Family family;
  const Vec3d velocity(9, 17, -5);
  const Fire burning{.intensity = 0.5, .kelvin = 2000};
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0.75, 0.75}}) {
    CloudScene s;
    s.medium.extinction = 0.15;
    s.medium.albedo = Rgb(0.8f);
    s.environment = ConstantSky{Rgb(0.0f)};
    s.camera = {.position = {70, 30, 90}, .target = {15, 18, 15}, .shutter = shutter};
    s.options.width = s.options.height = 12;
    s.options.threads = 1;
    const auto picture = [&](const CloudScene& with, bool moves) {
      const Pyramid pyramid = build_pyramid(smoke().grid);
      const Affine& place = with.medium.object_to_world;
      Volume v = make_volume(smoke().grid, pyramid, with);
      Emitter fire = fire_of(flame(), &heat(), burning, place);
      if (!moves) {
        v.fire = std::make_shared<const Emitter>(std::move(fire));
        return render(v, with).film;
      }
      const VelocityGrid wind = everywhere(velocity * 24);
      const Movement by{wind, 1.0 / 24, shutter};
      v = make_moving(std::move(v), pyramid, smoke().grid.index_to_world, by,
                      with.volume_options());
      v.fire = moving(std::move(fire), flame(), by);
      return render(v, with).film;
    };
    s.options.samples = proof::samples(2048);
    const Film blurred = picture(s, true);
    const Film sum = over_shutter(shutter, 32, [&](double time, std::uint64_t seed) {
      CloudScene still = s;
      still.camera.shutter = {};
      still.options.samples = proof::samples(64u), still.options.seed = seed;
      still.medium.object_to_world = translation(velocity * time);
      return picture(still, false);
    });
    EXPECT_GT(average(blurred).mean.x, 0.01);
    compare(blurred, sum, "shutter from " + std::to_string(shutter.open), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(MovingFire, StaysAsItIsWithAClosedShutterOrWithoutVelocities) {
  const VelocityGrid wind = everywhere({1, 2, 3});
  const Emitter still = fire_of(flame(), nullptr, {}, {});
  EXPECT_EQ(moving(still, flame(), {wind, 1, {}})->field.motion, nullptr);
  const VelocityGrid calm = everywhere({0, 0, 0});
  EXPECT_EQ(moving(still, flame(), {calm, 1, {0, 1}})->field.motion, nullptr);
}

TEST(MovingFire, NeedsTheShutterOfTheCamera) {
  CloudScene s;
  s.camera.position = {15, 15, 90}, s.camera.target = {15, 15, 15};
  Volume v = make_volume(VoxelGrid{}, Pyramid{}, s);
  const VelocityGrid wind = everywhere({1, 2, 3});
  v.fire = moving(fire_of(flame(), nullptr, {}, {}), flame(), {wind, 1, {0, 1}});
  EXPECT_TRUE(says(error_of([&] { (void)plan(std::span(&v, 1), s.scene()); }),
                   "motion.volume_of_another_shutter"));
}

}  // namespace moving_fire_test
}  // namespace pvol::test
