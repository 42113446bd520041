// Layers that are parts of a film's colour, filtered with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "pvol/render/denoise.h"
#include "support/known_film.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace colour_parts_test {

Truth lit_truth() {
  Truth t;
  t.width = 72, t.height = 64, t.samples = 16, t.noise = 0.4;
  t.depth = [](int x, int y) { return 5 + std::cos(0.2 * x) + std::cos(0.15 * y); };
  t.light = [](int x, int y) {
    return (x < 30 ? 0.6 : 1.2) * (1.5 + 0.5 * std::sin(0.2 * x) * std::sin(0.15 * y));
  };
  return t;
}

/// Where the sun is in shadow, much of the light is the sky's.
double of_sky(int x, int) { return x < 30 ? 0.7 : 0.35; }

/// Largest difference of the sum of layers from the colour, over the colour.
double off_sum(const Film& film, const std::vector<std::string>& names) {
  double most = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    Vec3d sum;
    for (const Layer& l : film.layers) {
      if (std::ranges::find(names, l.name) != names.end()) sum += value(l, film, i);
    }
    const Vec3d is = mean(film.pixels[i]);
    for (int c = 0; c < 3; ++c)
      most = std::max(most, std::abs(sum[c] - is[c]) / std::max(1e-12, is[c]));
  }
  return most;
}

/// Of a layer that has a part of the light.
double error_of_part(const Truth& t, const Film& film, const std::string& name,
                     const std::function<double(int, int)>& part) {
  Truth own = t;
  own.light = [&](int x, int y) { return t.light(x, y) * part(x, y); };
  std::vector<Vec3d> values;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    values.push_back(value(layer(film, name), film, i));
  }
  return error(own, values);
}

TEST(ColourParts, SumUpToTheFilteredPicture) {
  const Truth t = lit_truth();
  for (const double fireflies : {0.0, 1000.0}) {
    Film film = make(t);
    if (fireflies > 0) add_fireflies(film, t, fireflies, 300);
    add_parts(film, t, "sky", "sun_1", of_sky);
    add_parts(film, t, "single", "multiple",
              [](int, int y) { return 0.5 + 0.3 * std::sin(0.1 * y); });
    const Film filtered = with_colour(film, denoise(film));
    EXPECT_LT(off_sum(film, {"sky", "sun_1"}), 1e-12);
    EXPECT_LT(off_sum(filtered, {"sky", "sun_1"}), 1e-12) << fireflies;
    EXPECT_LT(off_sum(filtered, {"single", "multiple"}), 1e-12) << fireflies;
  }
}

TEST(ColourParts, ComeNearerToTheTruth) {
  const Truth t = lit_truth();
  Film film = make(t);
  add_parts(film, t, "sky", "sun_1", of_sky);
  const Film filtered = with_colour(film, denoise(film));
  const auto rest = [](int x, int y) { return 1 - of_sky(x, y); };
  EXPECT_LT(error_of_part(t, filtered, "sky", of_sky), 0.5 * error_of_part(t, film, "sky", of_sky));
  EXPECT_LT(error_of_part(t, filtered, "sun_1", rest), 0.5 * error_of_part(t, film, "sun_1", rest));
}

/// The light of fireflies stays with the layer that has it.
TEST(ColourParts, KeepTheLightOfTheirFireflies) {
  const Truth t = lit_truth();
  Film film = make(t);
  add_parts(film, t, "sky", "sun_1", [](int, int) { return 0.5; });
  Film bright = film;
  const std::vector<std::size_t> at = add_fireflies(bright, t, 1000, 300);
  for (const std::size_t i : at) {
    bright.layers.back().sums[i] += bright.pixels[i].sum - film.pixels[i].sum;
  }
  const Film filtered = with_colour(bright, denoise(bright));
  for (const char* name : {"sky", "sun_1"}) {
    double noisy = 0, is = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      noisy += value(layer(bright, name), bright, i).x,
          is += value(layer(filtered, name), filtered, i).x;
    }
    EXPECT_NEAR(is / noisy, 1, 0.02) << name;
  }
}

TEST(ColourParts, AreNeverNegativeAndOtherLayersStay) {
  const Truth t = lit_truth();
  Film film = make(t);
  add_parts(film, t, "sky", "sun_1", [](int x, int) { return x < 30 ? 0.0 : 0.02; });
  const Film filtered = with_colour(film, denoise(film));
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    ASSERT_GE(min_component(value(layer(filtered, "sky"), filtered, i)), 0);
  }
  for (const char* name : {"half_1", "half_2", "depth", "normal", "albedo"}) {
    EXPECT_EQ(layer(filtered, name).sums, layer(film, name).sums) << name;
  }
}

TEST(ColourParts, StayWhereThePictureIsLeft) {
  Truth t = lit_truth();
  t.alpha = [](int x, int) { return x < 10 ? 0.0 : 1.0; };
  Film film = make(t);
  add_parts(film, t, "sky", "sun_1", of_sky);
  const Film filtered = with_colour(film, denoise(film));
  for (std::size_t i = 0; i < film.pixels.size(); i += 72) {
    ASSERT_EQ(value(layer(filtered, "sky"), filtered, i), value(layer(film, "sky"), film, i));
  }
}

/// On a real picture, whose layers the renderer makes: each against many samples.
TEST(ColourParts, OfACloudSumUpAndComeNearerToManySamples) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 48;
  s.environment = ConstantSky{Rgb(0.3f, 0.4f, 0.6f)};
  s.options.aovs = denoising_aovs();
  s.options.aovs.add(Aov::lights), s.options.aovs.add(Aov::scattering);
  s.options.samples = proof::samples(1024u);
  s.options.seed = 77;
  const Film reference = run(cloud(), s).film;
  s.options.samples = 16;
  s.options.seed = 1;
  const Film film = run(cloud(), s).film;
  const Film filtered = with_colour(film, denoise(film));
  EXPECT_LT(off_sum(filtered, {"sky", "sun_1", "emission"}), 1e-9);
  EXPECT_LT(off_sum(filtered, {"unscattered", "single", "multiple"}), 1e-9);
  for (const char* name : {"sky", "sun_1", "single", "multiple"}) {
    double before = 0, after = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const double truth = value(layer(reference, name), reference, i).y;
      before += std::pow(value(layer(film, name), film, i).y - truth, 2);
      after += std::pow(value(layer(filtered, name), filtered, i).y - truth, 2);
    }
    EXPECT_LT(after, 0.5 * before) << name;
  }
}

}  // namespace colour_parts_test
}  // namespace pvol::test
