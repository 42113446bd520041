// How much noise counts in each pixel: estimates of the importance, pictures that keep their means
// by it, and less noise beside the brightness of pixels.
#include "render/engine/estimate_pixels.h"

#include <gtest/gtest.h>

#include "pvol/render/plan.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/guide/importance.h"
#include "render/path/film_layers.h"
#include "support/lit_scenes.h"
#include "support/pictures.h"

namespace pvol::test {
namespace pixel_importance_test {

using detail::estimate_pixel_importance;
using detail::PathSetup;
using detail::PixelImportance;

TEST(PixelImportance, IsLinearBetweenCentresOfCells) {
  const PixelImportance p{2, 3, {1, 3, 5, 7, 9, 11}};
  EXPECT_EQ(p.of(0.25, 1 / 6.0), 1);
  EXPECT_EQ(p.of(0.75, 1 / 6.0), 3);
  EXPECT_FLOAT_EQ(p.of(0.5, 0.5), 6);
  EXPECT_FLOAT_EQ(p.of(0.25, 1 / 3.0), 3);
  EXPECT_EQ(p.of(0, 0), 1);
  EXPECT_EQ(p.of(1, 1), 11);
  const PixelImportance one{1, 1, {4}};
  EXPECT_EQ(one.of(0.3, 0.9), 4);
}

/// A thick puff with the sun beside it, on the left: its right half is dark.
CloudScene half_dark() {
  CloudScene s = sunny();
  s.medium = component(2, Rgb(0.98f), 0.5);
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights = {Sun{{-1, 0.2, 0.3}, Rgb(3.0f), 0}};
  s.options.width = s.options.height = 64;
  s.options.samples = 16;
  return s;
}

/// A scene ready for rendering, with its guide and with the importance of pixels or without.
struct Prepared {
  Volume volume;
  RenderPlan plan;
  PathSetup setup;
  Prepared(CloudScene& s, bool by_pixels)
      : volume(volume_of(s)),
        plan(pvol::plan(std::span(&volume, 1), s.scene(), {.force = true, .forecast = false})),
        setup(plan) {
    detail::guide_paths(plan, setup);
    if (by_pixels) setup.pixel_importance = estimate_pixel_importance(setup);
  }
  Prepared(const Prepared&) = delete;
  Prepared& operator=(const Prepared&) = delete;

  struct Rendered {
    Film film;
    Counts counts;
  };
  [[nodiscard]] Rendered render() const {
    const RenderOptions& o = setup.options;
    Rendered r{detail::make_film(setup), {}};
    detail::TileRenderer tiles(setup);
    constexpr int kEdge = 8;  // so that few samples wait at once
    for (int y = 0; y < o.height; y += kEdge) {
      for (int x = 0; x < o.width; x += kEdge) {
        EXPECT_TRUE(tiles.render({x, y, kEdge, kEdge}, {.all = o.samples}, r.film, r.counts));
      }
    }
    return r;
  }
};

/// So that merged parts are the bytes of the whole.
TEST(PixelImportance, OfAPartIsThatOfTheWhole) {
  CloudScene s = half_dark();
  const Prepared whole(s, true);
  RenderOptions& o = s.options;
  o.part_begin = 5, o.part_end = 9;
  o.crop_x = 8, o.crop_y = 16, o.crop_width = 20, o.crop_height = 30;
  const Prepared part(s, true);
  ASSERT_NE(whole.setup.pixel_importance, nullptr);
  ASSERT_NE(part.setup.pixel_importance, nullptr);
  EXPECT_EQ(part.setup.pixel_importance->of_cell, whole.setup.pixel_importance->of_cell);
}

TEST(PixelImportance, IsLargeWhereThePictureIsDark) {
  CloudScene s = half_dark();
  const Prepared p(s, true);
  ASSERT_NE(p.setup.pixel_importance, nullptr);
  const PixelImportance& i = *p.setup.pixel_importance;
  EXPECT_EQ(std::size_t(i.columns) * std::size_t(i.rows), i.of_cell.size());
  EXPECT_EQ(i.columns, 8);  // a pixel for 64 times its 16 samples
  EXPECT_LT(i.of(0.3, 0.5), 1);
  EXPECT_GT(i.of(0.65, 0.5), 1.5f * i.of(0.3, 0.5));
  for (const float of_cell : i.of_cell) {
    EXPECT_GE(of_cell, 1 / 8.0f);
    EXPECT_LE(of_cell, 8);
  }
}

TEST(PixelImportance, IsThatOfTheWholePictureInItsParts) {
  CloudScene s = half_dark();
  const Film whole = render(volume_of(s), s).film;
  s.options.crop_x = 20, s.options.crop_y = 24, s.options.crop_width = 30,
  s.options.crop_height = 16;
  s.options.threads = 3;
  const Film part = render(volume_of(s), s).film;
  EXPECT_TRUE(same_bytes(part, crop_of(whole, 20, 24, 30, 16)));
}

TEST(PixelImportance, OfFewSamplesIsLeftOut) {
  CloudScene s = half_dark();
  s.options.samples = 15;
  EXPECT_EQ(Prepared(s, true).setup.pixel_importance, nullptr);
}

/// Block by block and as a whole, in lights whose rays are drawn by it and over a surface.
TEST(PixelImportance, KeepsTheMean) {
  proof::Family family;
  proof::Moments all;
  for (const bool surface : {false, true}) {
    CloudScene s = half_dark();
    s.lights.emplace_back(PointLight{{20, 60, 18}, Rgb(3e3f)});
    if (surface) s.surfaces = {PlaneSurface{{0, -4, 0}, {0, 1, 0}}};
    s.options.samples = proof::samples(160);
    const Volume v = volume_of(s);
    const RenderResult guided = render(v, s);
    s.options.guide = GuideUse::off;
    s.options.samples *= 2;
    ++s.options.seed;
    const RenderResult plain = render(v, s);
    const std::string name = surface ? "over a surface" : "alone";
    compare(guided.film, plain.film, name, family);
    all.add(compare(average(guided.film), average(plain.film), name, family));
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Mean over the pixels of variance over squared brightness, with a floor under that.
double relative_variance(const Film& film, const Film& reference) {
  const double mean = average(reference).mean.y;
  double sum = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const PixelSums& p = reference.pixels[i];
    const double value = p.sum.y / p.samples, floor = 0.01 * mean;
    sum += variance_of_mean(film.pixels[i]).y / (value * value + floor * floor);
  }
  return sum / double(film.pixels.size());
}

/// At the same number of collisions.
TEST(PixelImportance, MakesLessNoiseBesideTheBrightnessOfPixels) {
  CloudScene s = half_dark();
  s.options.samples = 64;
  s.options.count = true;
  const Prepared plain(s, false), by_pixels(s, true);
  s.options.samples = proof::samples(512u);
  s.options.seed = 9;
  const Film reference = Prepared(s, true).render().film;
  const auto cost = [&](const Prepared& p) {
    const Prepared::Rendered r = p.render();
    return double(r.counts.collisions) * relative_variance(r.film, reference);
  };
  EXPECT_LT(cost(by_pixels), 0.8 * cost(plain));
}

/// Of pixels so bright that none of their paths is split.
TEST(PixelImportance, DoesNotEndPathsOfBrightPixels) {
  CloudScene s = half_dark();
  s.options.count = true;
  Prepared p(s, false);
  const auto collisions = [&](float importance) {
    p.setup.pixel_importance =
        std::make_shared<const PixelImportance>(PixelImportance{1, 1, {importance}});
    return double(p.render().counts.collisions);
  };
  const double bright = collisions(1 / 32.0f);
  EXPECT_GT(bright, 1e4);
  EXPECT_NEAR(collisions(1 / 256.0f) / bright, 1, 0.05);
}

/// A ground and a wall that a lamp lights, all of this albedo: mean over the pixels of the relative
/// variance of a sample.
double relative_noise_of_room(float albedo) {
  CloudScene s = sunny();
  s.medium.extinction = 1e-3;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights = {PointLight{{60, 25, -10}, Rgb(1e3f)}};
  s.surfaces = {PlaneSurface{{0, -10, 0}, {0, 1, 0}, {.albedo = Rgb(albedo)}},
                PlaneSurface{{0, 0, -40}, {0, 0, 1}, {.albedo = Rgb(albedo)}}};
  s.options.guide = GuideUse::off;
  const Volume v = volume_of(s);
  s.camera = {.position = {60, 10, 60}, .target = {60, -5, -40}, .fov = 50};
  s.options.samples = 256;
  const Film film = render(v, s).film;
  s.options.samples = 2048;
  s.options.seed = 5;
  return s.options.samples * relative_variance(film, render(v, s).film) / 8;
}

/// Roulette takes a dark surface that the camera sees for as bright as a white one.
TEST(PixelImportance, OfDarkSurfacesMakesUpForTheirAlbedo) {
  const double dark = relative_noise_of_room(0.1f), grey = relative_noise_of_room(0.5f);
  EXPECT_LT(dark, 0.25 * grey);  // 0.12, and 0.39 without
}

}  // namespace pixel_importance_test
}  // namespace pvol::test
