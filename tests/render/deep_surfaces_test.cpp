// Deep pictures with surfaces: that they add up to the picture, closed forms, and a scene that is
// put together in depth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/bodies.h"
#include "support/meshes.h"
#include "support/statistics.h"
#include "support/surface_pixel.h"

namespace pvol::test {
namespace deep_surfaces_test {

std::vector<DeepSample> samples_of(const Film& film, std::size_t pixel, double error) {
  return deep_samples(film.deep, pixel, film.pixels[pixel].samples, error);
}

/// The cube on the ground, with things that stick out of it.
CloudScene cube_on_ground(Visibility ball, Visibility plane) {
  CloudScene s;
  s.medium = component(0.2, Rgb(0.9f), 0.3);
  s.camera.position = {40, 20, 30};
  s.camera.target = {6, 5, 6};
  s.camera.fov = 40;
  s.environment = GradientSky{};
  s.lights = {Sun{{1, 2, 0.5}, Rgb(3.0f), 1}};
  s.surfaces = {ground(0.4, plane), BallSurface{{11, 6, 9}, 4, {Rgb(0.7f), ball}}};
  s.options.width = 16, s.options.height = 12;
  s.options.look_up = LookUp::nearest;
  s.options.samples = 40;
  s.options.deep = true;
  return s;
}

Film film_of(const CloudScene& s, const Field& f = cube()) {
  return render(make_volume(f.grid, build_pyramid(f.grid), s), s).film;
}

bool is_tidy(const std::vector<DeepSample>& samples) {
  double end = 0;
  return std::ranges::all_of(samples, [&](const DeepSample& s) {
    const bool after = s.z >= end && s.z <= s.z_back && s.alpha >= 0 && s.alpha <= 1;
    end = s.z_back;
    return after;
  });
}

/// Without its background, whether the camera sees one or not.
TEST(DeepSurfaces, AddUpToThePicture) {
  for (const Visibility ball : {Visibility::surface, Visibility::holdout}) {
    for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
      CloudScene s = cube_on_ground(ball, Visibility::surface);
      s.options.guide = guide;
      const Film film = film_of(s);
      s.options.background = false;
      const Film cut_out = film_of(s);
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        const PixelSums& p = cut_out.pixels[i];
        for (const double error : {0.0, 0.05}) {
          const auto samples = samples_of(film, i, error);
          ASSERT_TRUE(is_tidy(samples));
          const DeepValue all = flatten(samples);
          ASSERT_NEAR(all.alpha, p.alpha / p.samples, 1e-12) << i;
          ASSERT_LT(length(all.colour - mean(p)), 1e-9 * (1 + length(mean(p)))) << i;
        }
      }
    }
  }
}

/// A catcher's alpha is noisy, and cannot be less than nothing: of each pixel it is the picture's,
/// or 0.
TEST(DeepSurfaces, AddUpToThePictureOfACatcher) {
  CloudScene s = cube_on_ground(Visibility::holdout, Visibility::shadow_catcher);
  s.environment = ConstantSky{Rgb(0.4f)};
  s.options.samples = 500;
  s.options.guide = GuideUse::off;  // paths that know the background take other random numbers
  const Film film = film_of(s);
  s.options.background = false;
  const Film cut_out = film_of(s);
  Vec3d flat, deep;
  double flat_alpha = 0, deep_alpha = 0;
  int several = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const auto samples = samples_of(film, i, 0.01);
    ASSERT_TRUE(is_tidy(samples));
    const DeepValue all = flatten(samples);
    deep += all.colour, deep_alpha += all.alpha;
    flat += mean(cut_out.pixels[i]);
    flat_alpha += cut_out.pixels[i].alpha / cut_out.pixels[i].samples;
    double of_surfaces = 0;
    for (const DeepSurface& of : film.deep.surfaces[i]) of_surfaces += of.alpha;
    several += film.deep.surfaces[i].size() > 1;
    const double expected = cut_out.pixels[i].alpha - std::min(of_surfaces, 0.0);
    ASSERT_NEAR(all.alpha, expected / cut_out.pixels[i].samples, 1e-9) << i;
  }
  EXPECT_GT(several, 20) << "intervals of depth in a pixel";
  EXPECT_GT(flat_alpha, 10);
  EXPECT_NEAR(deep_alpha, flat_alpha, 0.03 * flat_alpha);
  EXPECT_LT(length(deep - flat), 1e-6 * length(flat));
}

/// Where a pixel has met a catcher alone, whose noise is below nothing, it covers nothing.
TEST(DeepSurfaces, NoiseBelowNothingCoversNothing) {
  DeepFilm film;
  film.front = 1, film.back = 9, film.bins = 4;
  film.pixels.resize(1), film.surfaces.resize(1);
  film.add_surface(0, 5, Vec3d(0.0), -0.25);
  for (const DeepSample& s : deep_samples(film, 0, 8, 0)) EXPECT_EQ(s.alpha, 0);
  film.add(0, 2, Vec3d(0.5));
  const DeepValue all = flatten(deep_samples(film, 0, 8, 0));
  EXPECT_DOUBLE_EQ(all.alpha, 1.0 / 8);
  EXPECT_DOUBLE_EQ(all.colour.x, 0.5 / 8);
}

/// A wall amid the cube: before it the transmittance of what is there, at it all the rest, behind
/// it nothing, though it is amid a bin.
TEST(DeepSurfaces, TheMediumLiesBeforeTheWall) {
  CloudScene s;
  s.medium = component(0.12, Rgb(0.0f), 0, Rgb(1.0f, 2.0f, 3.0f));
  s.camera.fov = 1e-3;
  s.camera.position = {3, 6, 62.5};
  s.camera.target = {3, 6, 0};
  s.environment = ConstantSky{Rgb(0.7f)};
  s.surfaces = {PlaneSurface{{0, 0, 6}, {0, 0, 1}, {Rgb(0.0f)}}};
  s.options.width = s.options.height = 1;
  s.options.look_up = LookUp::nearest;
  s.options.samples = 40'000;
  s.options.deep = true;
  s.options.deep_bins = 14;
  const Film film = film_of(s);
  for (const double error : {0.0, 0.02}) {
    const auto samples = samples_of(film, 0, error);
    ASSERT_GE(samples.size(), 2u);
    const DeepSample& wall = samples.back();
    EXPECT_NEAR(wall.z, 56.5, 1e-6);
    EXPECT_EQ(wall.z_back, wall.z);
    EXPECT_NEAR(wall.alpha, 1, 1e-12);
    EXPECT_EQ(wall.colour, Vec3d(0.0));
    EXPECT_LE(samples[samples.size() - 2].z_back, wall.z);
    const double depth = 0.12 * 6.5, open = std::exp(-depth);
    const double noise = 4 * std::sqrt(open * (1 - open) / s.options.samples);
    EXPECT_NEAR(seen_before(samples, wall.z).alpha, 1 - open, noise);
    EXPECT_NEAR(seen_before(samples, 53.0).alpha, -std::expm1(-0.12 * 3), noise + error);
    EXPECT_EQ(flatten(samples).alpha, 1);
  }
}

/// A black ball in a glowing cube: a deep picture of the cube, whose camera does not see the ball,
/// and one of the ball alone, are that of both.
TEST(DeepSurfaces, ScenesRenderedApartAreOneSceneInDepth) {
  CloudScene s;
  s.camera.position = {8, 9, 60};
  s.camera.target = {7, 7, 0};
  s.camera.fov = 22;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 12;
  s.options.look_up = LookUp::nearest;
  s.options.threads = 1;
  const BallSurface ball{{6, 6, 7}, 4, {Rgb(0.0f)}};  // amid the cube, as the camera sees it
  const Body glowing = component(0.1, Rgb(0.0f), 0, Rgb(3.0f, 1.0f, 0.5f));
  std::array<proof::Moments, 2> together, apart;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CloudScene one = s;
    one.options.samples = proof::samples(300u, 2u);
    one.options.seed = seed;
    one.medium = glowing;
    one.surfaces = {ball};
    const Film both = film_of(one);
    one.options.seed = 1000 + seed;
    one.options.deep = true;
    std::get<BallSurface>(one.surfaces[0]).material.visible_camera = false;
    const Film cloud = film_of(one);
    one.options.seed = 2000 + seed;
    one.medium = far_away();
    one.surfaces = {ball};
    const Film balls = film_of(one);
    DeepValue a, b;
    for (std::size_t i = 0; i < both.pixels.size(); ++i) {
      a.colour += mean(both.pixels[i]);
      a.alpha += both.pixels[i].alpha / both.pixels[i].samples;
      const auto medium = samples_of(cloud, i, 0.001), surface = samples_of(balls, i, 0);
      const DeepValue all = flatten(medium);
      double open = 1;
      for (const DeepSample& at : surface) {
        const double share = open * at.alpha;  // of the pixel, of the ball at this depth
        b.colour += seen_before(medium, at.z).colour * share;
        b.alpha += share;
        open -= share;
      }
      b.colour += all.colour * open;
      b.alpha += all.alpha * open;
    }
    together[0].add(a.colour.x), apart[0].add(b.colour.x);
    together[1].add(a.alpha), apart[1].add(b.alpha);
  }
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_GT(together[c].mean(), 1);
    EXPECT_NEAR(apart[c].mean() / together[c].mean(), 1, 0.005) << c;
  }
}

/// Depths that agree to a tenth of a per cent are one surface; where there is no room for more,
/// the nearest takes them in, and nothing is lost.
TEST(DeepSurfaces, ThatAreManyShareRoom) {
  DeepFilm f{10, 14, 3, std::vector<std::vector<DeepBin>>(1),
             std::vector<std::vector<DeepSurface>>(1)};
  for (const double depth : {20.0, 20.001, 40.0, 5.0}) f.add_surface(0, depth, Vec3d(1), 1);
  ASSERT_EQ(f.surfaces[0].size(), 3u);
  EXPECT_EQ(f.surfaces[0][1].count, 2u);
  for (const double depth : {1.0, 21.0, 39.0, 1000.0}) f.add_surface(0, depth, Vec3d(1), 1);
  ASSERT_EQ(f.surfaces[0].size(), 3u);
  EXPECT_EQ(f.surfaces[0][0].count, 2u);
  EXPECT_EQ(f.surfaces[0][1].count, 3u);
  EXPECT_EQ(f.surfaces[0][2].count, 3u);
  const auto samples = deep_samples(f, 0, 10, 0);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].z, 3);
  EXPECT_NEAR(flatten(samples).alpha, 0.8, 1e-12);
  EXPECT_NEAR(flatten(samples).colour.x, 0.8, 1e-12);
}

/// Of a bin that a surface divides, where others see past it.
TEST(DeepSurfaces, DivideWhatLiesOnBothSides) {
  DeepFilm f{10, 14, 4, std::vector<std::vector<DeepBin>>(1),
             std::vector<std::vector<DeepSurface>>(1)};
  f.pixels[0] = {{Vec3d(512), 512, 1}, {Vec3d(64), 64, 3}};
  for (int k = 0; k < 256; ++k) f.add_surface(0, 11.5, Vec3d(0), 1);
  const auto samples = deep_samples(f, 0, 1024, 0);
  ASSERT_EQ(samples.size(), 4u);
  const double half = std::sqrt(0.5);  // of the bin's 1/2 on either side
  EXPECT_NEAR(samples[0].alpha, 1 - half, 1e-12);
  EXPECT_EQ(samples[0].z_back, 11.5);
  EXPECT_EQ(samples[1].z, 11.5);
  EXPECT_EQ(samples[2].z, 11.5);
  EXPECT_EQ(samples[2].z_back, 12);
  EXPECT_NEAR(flatten(samples).alpha, (512 + 64 + 256) / 1024.0, 1e-12);
}

}  // namespace deep_surfaces_test
}  // namespace pvol::test
