// Surfaces that some kinds of rays do not meet, and catchers in coloured light.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "pvol/render/near_lights.h"
#include "support/surface_pixel.h"

namespace pvol::test {
namespace surface_visibility_test {

constexpr double kPi = std::numbers::pi;

/// What arrives on black ground below a white ball at height h from an even sky by the ball alone:
/// it is lit by the sky above the horizon and scatters once.
double thrown_by_a_ball(double radius, double height) {
  const double rim = std::asin(radius / height);
  double sum = 0;
  constexpr int kSteps = 20'000;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = (i + 0.5) / kSteps * rim, cosine = std::cos(angle), sine = std::sin(angle);
    const double to_hit =
        height * cosine - std::sqrt(radius * radius - height * height * sine * sine);
    const double up = (to_hit * cosine - height) / radius;  // of the normal there
    sum += (1 + up) / 2 * cosine * sine;
  }
  return 2 * kPi * sum * rim / kSteps;
}

/// A ball above the ground that some kinds of rays do not meet, under skies that are found by
/// chance or sampled besides: the light that is missing and the light that it throws, apart.
TEST(SurfaceVisibility, KindsOfRaysMeetWhatTheyAreToMeet) {
  proof::Family family;
  const double hidden = 0.36, thrown = thrown_by_a_ball(1.2, 2) / kPi;
  const Environment skies[] = {ConstantSky{Rgb(0.5f)},
                               ImageSky{4, 2, std::vector<Rgb>(8, Rgb(0.5f))}};
  for (const Environment& sky : skies) {
    for (const bool shadow : {true, false}) {
      for (const bool light : {true, false}) {
        for (const float albedo : {0.0f, 1.0f}) {
          Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
          BallSurface ball{{0, 2, 0}, 1.2, {Rgb(albedo)}};
          ball.material.visible_shadow = shadow;
          ball.material.visible_light = light;
          p.scene.surfaces = {ground(0.8), ball};
          p.scene.environment = sky;
          p.scene.options.max_bounces = 2;
          p.scene.options.samples = 60'000;
          const double expected =
              0.8 * 0.5 * ((shadow ? 1 - hidden : 1) + (light ? thrown * double(albedo) : 0));
          expect_mean(p.sums(), expected,
                      std::string(shadow ? "shadow, " : "no shadow, ") +
                          (light ? "light, " : "no light, ") + std::to_string(albedo) +
                          (std::holds_alternative<ImageSky>(sky) ? ", sampled" : ""),
                      family);
        }
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// The camera sees what is behind a surface that it does not see, and its shadow there.
TEST(SurfaceVisibility, WhatTheCameraDoesNotSeeCastsItsShadow) {
  for (const bool visible : {true, false}) {
    Pixel p(far_away(), {0, 9, 0.01}, {0, 0, 0});
    BallSurface ball{{0, 2, 0}, 1.2, {Rgb(0.0f)}};
    ball.material.visible_camera = visible;
    p.scene.surfaces = {ground(0.8), ball};
    p.scene.environment = ConstantSky{Rgb(0.5f)};
    const PixelSums sums = p.sums();
    EXPECT_NEAR(mean(sums).x, visible ? 0 : 0.8 * 0.5 * 0.64, 0.01);
    EXPECT_EQ(sums.alpha, sums.samples);
  }
}

/// A black surface that casts no shadow takes nothing away from what a cloud before it scatters:
/// neither onto the ground, nor within itself where rays look ahead before they fly.
TEST(SurfaceVisibility, VolumesBeforeWhatCastsNoShadowScatterAsIfItWereNotThere) {
  proof::Family family;
  for (const bool by_channel : {false, true}) {
    PixelSums sums[2];
    for (const bool walled : {false, true}) {
      const Body cloud = component(0.3, Rgb(0.9f), 0, {}, translation({-6, 3, -6}));
      Pixel p(cloud, by_channel ? Vec3d(60, 9, 0) : Vec3d(9, 0.5, 0),
              by_channel ? Vec3d(0, 9, 0) : Vec3d(0, 0, 0));
      p.scene.lights = {Sun{{1, 0.4, 0.2}, Rgb(3.0f), 0}};
      p.scene.options.max_bounces = 6;
      p.scene.options.samples = 60'000;
      p.scene.options.seed = walled;
      p.scene.surfaces = {ground(by_channel ? 0.0 : 0.8)};
      PlaneSurface wall{{0, 30, 0}, {0, 1, 0}, {Rgb(0.0f)}};
      wall.material.visible_shadow = false;
      if (walled) p.scene.surfaces.push_back(wall);
      Medium medium = cloud.medium();
      if (by_channel) medium.extinction_color = Rgb(1.0f, 0.6f, 0.3f);
      const Volume volume = pvol::make_volume(cube().grid, build_pyramid(cube().grid), medium,
                                              p.scene.volume_options());
      sums[walled] = render(volume, p.scene).film.pixels.front();
    }
    const Vec3d off = mean(sums[1]) - mean(sums[0]);
    const Vec3d squared = variance_of_mean(sums[0]) + variance_of_mean(sums[1]);
    for (int c = 0; c < 3; ++c) {
      EXPECT_LT(std::sqrt(squared[c]), 0.02 * mean(sums[0])[c]) << "too few samples to tell";
      family.add((by_channel ? "by channel " : "grey ") + std::to_string(c),
                 proof::normal_p_value(std::abs(off[c]) / std::sqrt(squared[c])));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A lamp in the plane of a ceiling that not all rays meet lights the ground as if it hung free.
TEST(SurfaceVisibility, LampsLieOnWallsOfEveryKind) {
  proof::Family family;
  for (const bool shadow : {true, false}) {
    for (const bool light : {true, false}) {
      for (const double tilt : {0.0, 0.3}) {
        const Vec3d down = normalize(Vec3d(tilt, -1, 0.5 * tilt)), middle(0.3, 2, 0.1);
        const AreaLight lamp{.position = middle,
                             .direction = down,
                             .size = {1.6, 1.1},
                             .radiance = Rgb(2.0f),
                             .visible_camera = false};
        Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
        PlaneSurface ceiling{middle, down, {Rgb(0.0f)}};
        ceiling.material.visible_shadow = shadow;
        ceiling.material.visible_light = light;
        p.scene.surfaces = {ground(0.8), ceiling};
        p.scene.lights = {lamp};
        p.scene.options.max_bounces = 1;
        p.scene.options.samples = 60'000;
        const Rgb irradiance = AreaSource(lamp).on_plane({0, 0, 0}, {0, 1, 0});
        expect_mean(p.sums(), 0.8 / kPi * double(irradiance.x),
                    std::string(shadow ? "shadow, " : "no shadow, ") +
                        (light ? "light, " : "no light, ") + std::to_string(tilt),
                    family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A holdout whose shadow the photograph has already casts none on the catcher.
TEST(SurfaceVisibility, AHoldoutWithoutAShadowLeavesTheCatcherLit) {
  for (const bool shadow : {true, false}) {
    for (const Environment& sky : {Environment(ConstantSky{Rgb(0.5f)}),
                                   Environment(ImageSky{4, 2, std::vector<Rgb>(8, Rgb(0.5f))})}) {
      Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
      BallSurface ball{{0, 2, 0}, 1.2, {Rgb(0.0f), Visibility::holdout}};
      ball.material.visible_shadow = shadow;
      p.scene.surfaces = {ground(0.0, Visibility::shadow_catcher), ball};
      p.scene.environment = sky;
      p.scene.lights = {PointLight{{-3, 8, 0}, Rgb(9.0f), "", 1}};
      p.scene.options.background = false;
      p.scene.options.samples = 60'000;
      const PixelSums sums = p.sums();
      if (shadow) {
        EXPECT_GT(sums.alpha / sums.samples, 0.2);
      } else {
        expect_alpha(sums, 0);
      }
      EXPECT_EQ(mean(sums), Vec3d(0.0));
    }
  }
}

/// Where a ball hides a red sky, the light of a blue sun is left: photographs are multiplied by it,
/// and the sky that is seen through.
TEST(SurfaceVisibility, ShadowsOnACatcherHaveTheColourOfTheLightThatIsLeft) {
  const Rgb sky(0.9f, 0.2f, 0.1f), sun(0.1f, 0.3f, 1.0f);
  const Environment skies[] = {ConstantSky{sky}, ImageSky{4, 2, std::vector<Rgb>(8, sky)}};
  for (const Environment& environment : skies) {
    Pixel p = catcher_below_a_ball(environment, sun);
    p.scene.options.aovs.add(Aov::transmittance_rgb);
    const Film film = p.result().film;
    ASSERT_EQ(film.layers.size(), 1u);
    ASSERT_EQ(film.layers[0].name, "transmittance_rgb");
    const Vec3d through = value(film.layers[0], film, 0), seen = mean(film.pixels[0]);
    for (int c = 0; c < 3; ++c) {
      const double of_sky = double(sky[c]), of_sun = double(sun[c]);
      const double expected = (0.64 * of_sky + of_sun) / (of_sky + of_sun);
      EXPECT_NEAR(through[c], expected, 0.01) << c;
      EXPECT_NEAR(seen[c], of_sky * through[c], 1e-5) << c;
    }
    // Alpha is that of the luminance.
    const double y = double(luminance(Rgb(Vec3f(through) * (sky + sun))));
    EXPECT_NEAR(film.pixels[0].alpha / film.pixels[0].samples, 1 - y / double(luminance(sky + sun)),
                1e-5);
  }
}

/// Of a colour that no light has, a photograph is dimmed as by the luminance.
TEST(SurfaceVisibility, ShadowsOnACatcherDimColoursWithoutLightByItsLuminance) {
  const Rgb sky(0.9f, 0.0f, 0.0f), sun(0.3f, 0.5f, 0.0f);
  Pixel p = catcher_below_a_ball(ConstantSky{sky}, sun);
  p.scene.options.aovs.add(Aov::transmittance_rgb);
  const Film film = p.result().film;
  const Vec3d through = value(film.layers.at(0), film, 0);
  const double of_all = double(luminance(sky + sun)), hidden = 0.36 * double(luminance(sky));
  EXPECT_NEAR(through.x, (0.64 * 0.9 + 0.3) / 1.2, 0.01);
  EXPECT_NEAR(through.y, 1, 0.01);
  EXPECT_NEAR(through.z, (of_all - hidden) / of_all, 0.01);
}

}  // namespace surface_visibility_test
}  // namespace pvol::test
