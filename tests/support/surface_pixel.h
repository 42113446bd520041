// One pixel that sees a surface, against closed forms.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "support/bodies.h"
#include "support/statistics.h"

namespace pvol::test {

/// A small cube that is out of the way, for scenes that are about surfaces alone.
inline Body far_away() { return component(1, Rgb(0.5f), 0, Rgb(0.0f), translation({0, 0, 1e5})); }

inline PlaneSurface ground(double albedo, Visibility visibility = Visibility::surface) {
  return {{0, 0, 0}, {0, 1, 0}, {Rgb(float(albedo)), visibility}};
}

/// One pixel, whose samples are a camera's only ray. The scene's first body is to be made.
struct Pixel {
  CloudScene scene;
  Field const* field = &cube();

  Pixel(const Body& body, Vec3d from, Vec3d to) {
    scene.medium = body;
    scene.camera.position = from;
    scene.camera.target = to;
    scene.camera.up = {0.1, 0.2, 1};
    scene.camera.fov = 1e-4;
    scene.environment = ConstantSky{Rgb(0.0f)};
    scene.options.width = scene.options.height = 1;
    scene.options.samples = 20'000;
    scene.options.look_up = LookUp::nearest;
    scene.options.threads = 1;
  }
  [[nodiscard]] RenderResult result() const {
    return render(make_volume(field->grid, build_pyramid(field->grid), scene), scene);
  }
  [[nodiscard]] PixelSums sums() const { return result().film.pixels.front(); }
};

/// A catcher half in the light: a black ball hides 36 % of a sky of this colour, and not the sun,
/// which brings as much irradiance as the whole sky of its colour would.
inline Pixel catcher_below_a_ball(const Environment& sky, Rgb sun) {
  Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
  p.scene.surfaces = {ground(0.0, Visibility::shadow_catcher),
                      BallSurface{{0, 2, 0}, 1.2, {Rgb(0.0f)}}};
  p.scene.environment = sky;
  p.scene.lights = {Sun{{1, 0.5, 0}, sun * float(std::numbers::pi * std::sqrt(5.0)), 0}};
  p.scene.options.samples = 60'000;
  return p;
}

/// Where a sample's values are all the same, rounding is what is left.
inline void expect_mean(const PixelSums& p, double expected, const std::string& name,
                        proof::Family& family) {
  const double error = std::sqrt(variance_of_mean(p).x), off = mean(p).x - expected;
  const double rounding = 2e-6 * std::abs(expected);
  if (std::abs(off) <= rounding) return family.add(name, 1);
  ASSERT_GT(error, 0) << name << ": " << mean(p).x << " instead of " << expected;
  EXPECT_LT(error, 0.012 * std::abs(expected)) << name << ": too few samples to tell";
  family.add(name, proof::normal_p_value((std::abs(off) - rounding) / error));
}

/// Alpha of a pixel, whose samples' noise the film does not keep: the standard error is at most
/// that of samples in [-1, 1].
inline void expect_alpha(const PixelSums& p, double expected) {
  EXPECT_NEAR(p.alpha / p.samples, expected, 5 / std::sqrt(double(p.samples)));
}

}  // namespace pvol::test
