// Comparing films: biases of known size are found, and noise is not taken for one.
#include "pvol/measure/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "pvol/error.h"
#include "pvol/measure/student.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/statistics.h"

namespace pvol::measure {
namespace compare_test {

using test::CloudScene;

/// What a sample of a pixel is, in one channel.
using Law = std::function<double(Rng&, int x, int y, int channel)>;

/// Exponential laws whose mean varies over the picture.
double exponential(Rng& rng, int x, int y, int channel) {
  return (1 + 0.5 * std::sin(0.2 * x + channel) * std::cos(0.1 * y)) *
         double(rng.tentative().depth);
}

/// Rare and bright: skewness 14, as with a strong sun behind thin cloud.
double rare(Rng& rng, int, int, int) { return rng.uniform() < 0.005f ? 100 : 0.5; }

Film make_film(const Law& law, int width, int height, std::uint32_t samples, std::uint64_t seed) {
  Film f;
  f.width = f.crop_width = width, f.height = f.crop_height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Rng rng(seed, std::uint64_t(y * width + x), 0);
      PixelSums p;
      p.samples = samples;
      for (std::uint32_t s = 0; s < samples; ++s) {
        const Vec3d v(law(rng, x, y, 0), law(rng, x, y, 1), law(rng, x, y, 2));
        p.sum += v;
        p.sum_squares += v * v;
      }
      f.pixels.push_back(p);
    }
  }
  return f;
}

/// Adds `value` to the expectation of a rectangle.
void add(Film& f, int x, int y, int width, int height, Vec3d value) {
  for (int j = y; j < y + height; ++j) {
    for (int i = x; i < x + width; ++i) {
      PixelSums& p = f.pixels[std::size_t(j * f.crop_width + i)];
      const double n = p.samples;
      p.sum_squares += p.sum * value * 2.0 + value * value * n;
      p.sum += value * n;
    }
  }
}

/// Greyness makes the three channels one, and luminance the same.
double grey(Rng& rng, int, int, int) { return double(rng.uniform()); }

TEST(Compare, MeansErrorsAndDeviationsAreRight) {
  Film a, b;
  a.width = a.crop_width = b.width = b.crop_width = 2;
  a.height = a.crop_height = b.height = b.crop_height = 1;
  // Four samples each: 1, 3, 1, 3 and 2, 2, 6, 6; the second pixel has no variance.
  a.pixels = {{Vec3d(8), Vec3d(20), 0, 4}, {Vec3d(4), Vec3d(4), 0, 4}};
  b.pixels = {{Vec3d(16), Vec3d(80), 0, 4}, {Vec3d(4), Vec3d(4), 0, 4}};
  const FilmComparison r = compare(a, b, {0.95, 0.01});
  for (const ChannelComparison& c : {r.channels[0], r.channels[2], r.luminance}) {
    EXPECT_DOUBLE_EQ(c.mean_a, 1.5);
    EXPECT_DOUBLE_EQ(c.mean_b, 2.5);
    EXPECT_DOUBLE_EQ(c.bias, -1);
    EXPECT_DOUBLE_EQ(c.relative_bias, -0.4);
    EXPECT_DOUBLE_EQ(c.mse, 2);
    EXPECT_DOUBLE_EQ(c.relative_rmse, std::sqrt(2.0) / 2.5);
    // Variances of the means: (4 / 3) / 4 and (16 / 3) / 4.
    EXPECT_NEAR(c.explained_mse, 5.0 / 6, 1e-15);
    EXPECT_NEAR(c.systematic_mse, 7.0 / 6, 1e-15);
    EXPECT_NEAR(c.bias_deviation, std::sqrt(5.0 / 3) / 2, 1e-15);
    // Welch's degrees of freedom: (1/3 + 4/3)^2 / ((1/9) / 3 + (16/9) / 3) = 75 / 17.
    EXPECT_NEAR(c.bias_half_width, student_quantile(0.95, 75.0 / 17) * std::sqrt(5.0 / 3) / 2,
                1e-8);
  }
  ASSERT_TRUE(r.largest);
  EXPECT_EQ(r.largest->x, 0);
  EXPECT_NEAR(r.largest->sigmas, -2 / std::sqrt(5.0 / 3), 1e-12);
}

/// Four blocks, the fewest that have a spread, of one pixel's difference each and no variance:
/// their squares are 0, 1, 4 and 9.
TEST(Compare, TheErrorOfSquaresIsThatOfTheSpreadBetweenBlocks) {
  Film a = make_film([](Rng&, int, int, int) { return 4; }, 16, 16, 4, 1);
  const Film b = a;
  for (int k = 0; k < 4; ++k) add(a, k % 2 * 8 + 3, k / 2 * 8 + 5, 1, 1, Vec3d(k));
  const ChannelComparison c = compare(a, b, {0.95, 0.01}).channels[1];
  EXPECT_NEAR(c.systematic_mse, 14.0 / 256, 1e-12);
  // Their mean is 3.5: the variance of a sum of four is 4 (3.5^2 + 2.5^2 + 0.5^2 + 5.5^2) / 3.
  EXPECT_NEAR(c.systematic_half_width, student_quantile(0.95, 3) * std::sqrt(4 * 49.0 / 3) / 256,
              1e-5);
}

TEST(Compare, EqualFilmsHaveNoBias) {
  const Film a = make_film(exponential, 32, 32, 16, 1);
  const FilmComparison r = compare(a, a);
  EXPECT_EQ(r.luminance.bias, 0);
  EXPECT_EQ(r.luminance.mse, 0);
  ASSERT_TRUE(r.verdict);
  EXPECT_FALSE(r.verdict->detected);
  EXPECT_EQ(r.verdict->regions_p_value, 1);
}

TEST(Compare, RoundingToFloatIsNoBias) {
  Film a = make_film([](Rng&, int, int, int) { return 0.1; }, 64, 64, 64, 1), b = a;
  for (PixelSums& p : b.pixels) {
    p.sum = Vec3d(double(float(0.1))) * 64.0;
    p.sum_squares = p.sum * p.sum / 64.0;
  }
  EXPECT_FALSE(compare(a, b).verdict->detected);
  add(b, 3, 3, 1, 1, Vec3d(1e-6));  // no variance explains even this
  EXPECT_TRUE(compare(a, b).verdict->detected);
}

/// How often films of equal expectation are told apart, and whether intervals hold the truth.
struct Rates {
  std::uint64_t alarms = 0, regions = 0, pixels = 0, holds = 0, systematic_holds = 0, count = 0;
  proof::Moments bias, systematic, of_all_channels;
};

Rates rates_of(const std::function<Film(std::uint64_t)>& film_a,
               const std::function<Film(std::uint64_t)>& film_b, int pairs, double level) {
  Rates r;
  for (int i = 0; i < pairs; ++i) {
    const std::uint64_t seed = 2 * std::uint64_t(i);
    const FilmComparison c = compare(film_a(seed), film_b(seed + 1), {0.9, level});
    ++r.count;
    r.alarms += c.verdict->detected;
    r.regions += c.verdict->regions_p_value < level;
    r.pixels += c.verdict->pixels_p_value < level;
    const ChannelComparison& green = c.channels[1];
    r.holds += std::abs(green.bias) < green.bias_half_width;
    r.systematic_holds += std::abs(green.systematic_mse) < green.systematic_half_width;
    r.bias.add(green.bias);
    r.systematic.add(green.systematic_mse);
    r.of_all_channels.add(c.luminance.systematic_mse);
  }
  return r;
}

/// The probability of at least so many events of this rate, by the exact binomial law.
double at_least(std::uint64_t events, std::uint64_t count, double rate) {
  double sum = 0;
  for (std::uint64_t k = events; k <= count; ++k) {
    sum += std::exp(std::lgamma(double(count) + 1) - std::lgamma(double(k) + 1) -
                    std::lgamma(double(count - k) + 1) + double(k) * std::log(rate) +
                    double(count - k) * std::log1p(-rate));
  }
  return sum;
}

/// No more false alarms than the level allows, unbiased figures, and intervals that hold the truth
/// as often as they promise (90 %).
void expect_honest(const Rates& r, double level) {
  proof::Family family;
  family.add("false alarms", at_least(r.alarms, r.count, level));
  family.add("of regions", at_least(r.regions, r.count, level));
  family.add("of pixels", at_least(r.pixels, r.count, level));
  family.add("bias", proof::mean_p_value(r.bias, 0));
  family.add("systematic MSE", proof::mean_p_value(r.systematic, 0));
  family.add("systematic MSE of all channels", proof::mean_p_value(r.of_all_channels, 0));
  family.add("coverage of the bias", at_least(r.count - r.holds, r.count, 0.1));
  EXPECT_TRUE(family.passes()) << r.alarms << " alarms, " << r.regions << " of regions, "
                               << r.pixels << " of pixels, " << r.holds << " and "
                               << r.systematic_holds << " held of " << r.count;
}

TEST(Compare, FalseAlarmsAreAsRareAsPromised) {
  const auto film = [](std::uint64_t seed) { return make_film(exponential, 40, 32, 16, seed); };
  const Rates r = rates_of(film, film, proof::samples(500), 0.1);
  expect_honest(r, 0.1);
  // Nor far rarer, which would cost power: the tests are nearly independent.
  EXPECT_GT(double(r.alarms), double(r.count) * 0.1 / 3);
  EXPECT_LT(double(r.holds), double(r.count) * 0.95);
  EXPECT_LT(double(r.systematic_holds), double(r.count) * 0.96);
}

TEST(Compare, RareBrightSamplesRaiseNoFalseAlarms) {
  const auto film = [](std::uint64_t seed) { return make_film(rare, 48, 48, 8, seed); };
  expect_honest(rates_of(film, film, proof::samples(500), 0.1), 0.1);
  // The second film has sixteen times the samples: differences are as skew as the first film.
  const auto reference = [](std::uint64_t seed) { return make_film(rare, 48, 48, 128, seed); };
  expect_honest(rates_of(film, reference, proof::samples(120), 0.1), 0.1);
}

/// As at the edge of a flame: skewness 32, and most short films miss what makes the mean.
double flames(Rng& rng, int, int, int channel) {
  return rng.uniform() < 0.001f && channel == 0 ? 500 : 0;
}

/// The reference of the trade has many times the samples of a setting, and all settings have it.
TEST(Compare, ShortFilmsOfSkewedLawsAreNotCalledTooDark) {
  const auto film = [](std::uint64_t seed) { return make_film(flames, 64, 64, 8, seed); };
  Film reference;
  const auto shared = [&](std::uint64_t seed) {
    constexpr std::uint64_t kPairs = 40;
    if (seed / 2 % kPairs == 0) reference = make_film(flames, 64, 64, 512, ~seed);
    return reference;
  };
  const Rates r = rates_of(film, shared, proof::samples(1000), 0.01);
  EXPECT_GT(at_least(r.alarms, r.count, 0.01), 1e-3) << r.alarms << " of " << r.count;
  EXPECT_GT(at_least(r.regions, r.count, 0.01), 1e-3) << r.regions << " of " << r.count;
}

/// The samples of some pixels agree by chance: their variance says little.
TEST(Compare, PixelsOfFewSamplesAreNotCalledSignificant) {
  proof::Family family;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Film few = make_film(grey, 32, 32, 2, 900 + seed);
    const Film many = make_film(grey, 32, 32, 64, 950 + seed);
    for (const bool swapped : {false, true}) {
      const FilmComparison r = swapped ? compare(many, few) : compare(few, many);
      ASSERT_TRUE(r.largest);
      family.add(std::to_string(seed), r.largest->p_value);
      EXPECT_LE(double(r.tails[2].found), 2 + 3 * r.tails[2].expected);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(Compare, AnErrorOfASkewedLawIsFoundAgainstALongReference) {
  const Film reference = make_film(flames, 64, 64, 512, 1);
  for (const double factor : {0.5, 2.0}) {
    const Law wrong = [&](Rng& rng, int x, int y, int c) { return factor * flames(rng, x, y, c); };
    EXPECT_TRUE(
        compare(make_film(wrong, 64, 64, 32, 2), reference, {0.95, 0.001}).verdict->detected)
        << factor;
  }
}

/// A cloud in the sun, few samples a pixel.
class Cloud {
 public:
  Cloud() : volume_(make_scene_and_volume()) {}

  [[nodiscard]] Film render(std::uint64_t seed,
                            std::optional<std::uint32_t> max_bounces = {}) const {
    CloudScene s = scene_;
    s.options.seed = seed;
    s.options.max_bounces = max_bounces;
    return test::render(volume_, s).film;
  }

 private:
  Volume make_scene_and_volume() {
    scene_.medium.extinction = 0.6;
    scene_.medium.albedo = Rgb(0.95f, 0.9f, 0.8f);
    scene_.lights = {Sun{}};
    scene_.options.width = scene_.options.height = 32;
    scene_.options.samples = 16;
    scene_.options.tracker = Tracker::delta;
    field_ = test::make_field("ball", {0, 0, 0}, Vec3i(17), [](Vec3i p) {
      return std::max(0.0, 1 - length(Vec3d(p) - Vec3d(8)) / 8);
    });
    Volume v = make_volume(field_.grid, build_pyramid(field_.grid), scene_);
    scene_.camera = frame(v.density.world_box, 1);
    return v;
  }

  CloudScene scene_;
  test::Field field_;
  Volume volume_;
};

TEST(Compare, RendersWithOtherSeedsAreNotFlagged) {
  const Cloud cloud;
  const auto film = [&](std::uint64_t seed) { return cloud.render(seed); };
  expect_honest(rates_of(film, film, proof::samples(150), 0.1), 0.1);
}

/// Short films of real paths against long ones, as trade compares them: a thin cloud that scatters
/// forwards under a small sun, without guiding and with, and a red fire in it.
TEST(Compare, ShortRendersAreNotCalledBiasedAgainstALongReference) {
  const test::Field f = test::make_field("wisps", {0, 0, 0}, Vec3i(33), [](Vec3i p) {
    return (p.x * 7 + p.y * 5 + p.z * 3) % 11 == 0 ? 1.0 : 0.0;
  });
  const auto scene = [](GuideUse guide, Rgb emission) {
    CloudScene s;
    s.medium.extinction = 0.5;
    s.medium.albedo = Rgb(emission.x > 0 ? 0.3f : 0.99f);
    s.medium.g = 0.9;
    s.medium.emission = emission;
    if (!(emission.x > 0)) s.lights = {Sun{{0.2, 0.3, -1}, Rgb(3.0f), 0}};
    s.environment = ConstantSky{Rgb(0.0f)};
    s.options.width = s.options.height = 32;
    s.options.guide = guide;
    return s;
  };
  const Rgb dark(0.0f), red(40, 0, 0);
  for (CloudScene s :
       {scene(GuideUse::off, dark), scene(GuideUse::on, dark), scene(GuideUse::off, red)}) {
    const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
    s.camera = frame(v.density.world_box, 1);
    const auto film = [&](std::uint64_t seed, std::uint32_t samples) {
      s.options.seed = seed, s.options.samples = samples;
      return test::render(v, s).film;
    };
    Film reference;
    const auto shared = [&](std::uint64_t seed) {
      constexpr std::uint64_t kPairs = 40;
      if (seed / 2 % kPairs == 0) reference = film(~seed, 256);
      return reference;
    };
    const Rates r = rates_of([&](std::uint64_t seed) { return film(seed, 8); }, shared,
                             proof::samples(150), 0.01);
    EXPECT_GT(at_least(r.alarms, r.count, 0.01), 1e-3) << r.alarms << " of " << r.count;
  }
}

TEST(Compare, ABounceLimitIsFound) {
  const Cloud cloud;
  const FilmComparison r = compare(cloud.render(1, 3), cloud.render(2));
  EXPECT_TRUE(r.verdict->detected);
  EXPECT_LT(r.luminance.bias, -r.luminance.bias_half_width);
}

TEST(Compare, ABiasOfOnePercentIsFoundAndMeasured) {
  proof::Moments bias, systematic;
  for (std::uint64_t i = 0; i < 40; ++i) {
    Film a = make_film(grey, 64, 64, 64, 2 * i);
    const Film b = make_film(grey, 64, 64, 64, 2 * i + 1);
    add(a, 0, 0, 64, 64, Vec3d(0.005));
    const FilmComparison r = compare(a, b);
    EXPECT_TRUE(r.verdict->detected) << i;
    EXPECT_LT(r.verdict->worst.p_value, 1e-4);
    bias.add(r.channels[0].bias);
    systematic.add(r.channels[0].systematic_mse);
  }
  proof::Family family;
  family.add("bias", proof::mean_p_value(bias, 0.005));
  family.add("systematic MSE", proof::mean_p_value(systematic, 0.005 * 0.005));
  EXPECT_TRUE(family.passes());
}

TEST(Compare, OppositeErrorsDoNotCancel) {
  Film a = make_film(grey, 64, 64, 64, 5);
  const Film b = make_film(grey, 64, 64, 64, 6);
  add(a, 0, 0, 32, 64, Vec3d(0.01));
  add(a, 32, 0, 32, 64, Vec3d(-0.01));
  const FilmComparison r = compare(a, b);
  EXPECT_LT(std::abs(r.luminance.bias), r.luminance.bias_half_width);
  ASSERT_TRUE(r.verdict->detected);
  EXPECT_EQ(r.verdict->worst.width, 32);
}

TEST(Compare, ErrorsInASmallPlaceOrOneChannelAreFoundThere) {
  Film a = make_film(grey, 128, 128, 64, 7);
  const Film b = make_film(grey, 128, 128, 64, 8);
  add(a, 96, 32, 8, 8, Vec3d(0, 0, 0.08));
  const FilmComparison r = compare(a, b);
  ASSERT_TRUE(r.verdict->detected);
  const RegionDifference& w = r.verdict->worst;
  EXPECT_EQ(w.channel, 2);
  EXPECT_EQ(w.x, 96);
  EXPECT_EQ(w.y, 32);
  EXPECT_EQ(w.width, 8);
  EXPECT_NEAR(w.bias, 0.08, 5 * w.deviation);
}

TEST(Compare, ErrorsOfTheSizeOfPixelsAreFound) {
  Film a = make_film(grey, 64, 64, 64, 9);
  const Film b = make_film(grey, 64, 64, 64, 10);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) add(a, x, y, 1, 1, Vec3d((x + y) % 2 == 0 ? 0.02 : -0.02));
  }
  const FilmComparison r = compare(a, b);
  EXPECT_GT(r.verdict->regions_p_value, 1e-3);
  EXPECT_TRUE(r.verdict->detected);
  EXPECT_NEAR(r.channels[0].systematic_mse, 0.0004, r.channels[0].systematic_half_width);
}

TEST(Compare, LuminanceHasNoSmallerDeviationThanItsChannelsAllow) {
  const Film a = make_film(exponential, 16, 16, 64, 11), b = make_film(exponential, 16, 16, 64, 12);
  const FilmComparison r = compare(a, b);
  const double independent = std::hypot(
      0.2126 * r.channels[0].bias_deviation,
      std::hypot(0.7152 * r.channels[1].bias_deviation, 0.0722 * r.channels[2].bias_deviation));
  EXPECT_GT(r.luminance.bias_deviation, independent);
}

/// Channels that rise while others fall: luminance is the same in all samples, and yet squared
/// errors of the channels are explained by their noise, no more and no less.
TEST(Compare, SquaredErrorsDoNotAskHowChannelsVaryTogether) {
  const auto film = [](std::uint64_t seed) {
    Film f = make_film(grey, 64, 64, 16, seed);
    for (PixelSums& p : f.pixels) {
      const double n = p.samples, s = p.sum.x, q = p.sum_squares.x;
      p.sum = {s, n - s, s};
      p.sum_squares = {q, n - 2 * s + q, q};
    }
    return f;
  };
  proof::Moments systematic;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const ChannelComparison c = compare(film(2 * i), film(2 * i + 1)).luminance;
    EXPECT_NEAR(c.mse / c.explained_mse, 1, 0.15);
    systematic.add(c.systematic_mse);
  }
  proof::Family family;
  family.add("mean", proof::mean_p_value(systematic, 0));
  EXPECT_TRUE(family.passes());
}

/// As an interrupted render leaves them.
TEST(Compare, PixelsWithoutSamplesHideNoDifference) {
  Film a = make_film(grey, 64, 64, 64, 1);
  const Film b = make_film(grey, 64, 64, 64, 2);
  add(a, 0, 0, 64, 64, Vec3d(0.1));
  a.pixels[5] = {};
  const FilmComparison r = compare(a, b);
  EXPECT_FALSE(r.verdict && std::isnan(r.verdict->p_value));
}

TEST(Compare, WithoutVariancesThereIsNoVerdict) {
  const Film a = make_film(grey, 8, 8, 1, 1), b = make_film(grey, 8, 8, 64, 2);
  const FilmComparison r = compare(a, b);
  EXPECT_FALSE(r.variances_known);
  EXPECT_FALSE(r.verdict);
  EXPECT_FALSE(r.largest);
  EXPECT_TRUE(std::isnan(r.luminance.bias_half_width));
  EXPECT_GT(r.luminance.mse, 0);
}

TEST(Compare, WhatCannotBeComparedIsRefused) {
  const Film a = make_film(grey, 8, 8, 2, 1);
  const auto refused = [&](const Film& b, const CompareOptions& o) {
    try {
      (void)compare(a, b, o);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  Film moved = a, smaller = make_film(grey, 8, 4, 2, 1), broken = a;
  moved.x = 1, moved.width = 9;
  broken.pixels[13].sum.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(refused(moved, {}), "comparison.pictures_show_different_rectangles"));
  EXPECT_NE(refused(smaller, {}).find("8 x 4"), std::string::npos);
  EXPECT_TRUE(says(refused(broken, {}), "comparison.second_picture_pixel"));
  EXPECT_NE(refused(a, {1.0, 1e-3}).find("confidence"), std::string::npos);
  EXPECT_NE(refused(a, {0.9, 0}).find("level"), std::string::npos);
}

}  // namespace compare_test
}  // namespace pvol::measure
