#include "pvol/measure/filtered.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pvol/error.h"

namespace pvol::measure {
namespace filtered_test {

constexpr int kEdge = 32;

/// A grey film of this light, whose samples have this deviation.
Film make(double light, double deviation, std::uint32_t samples, unsigned seed) {
  Film f;
  f.width = f.crop_width = f.height = f.crop_height = kEdge;
  f.pixels.resize(std::size_t(kEdge) * kEdge);
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  for (PixelSums& p : f.pixels) {
    for (std::uint32_t n = 0; n < samples; ++n) {
      const Vec3d v(light + deviation * normal(generator));
      p.sum += v, p.sum_squares += v * v, ++p.samples;
    }
  }
  return f;
}

/// A "filter" whose result has this error, the same in every trial and of both signs by pixel, and
/// this much too much light.
FilterTrial trial(unsigned seed, double own, double shift, double noise) {
  FilterTrial t{make(2, 1, 16, seed), {}, 2, 3, 1};
  t.filtered.relative_error = 0.1;
  std::mt19937 generator(1000 + seed);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < t.film.pixels.size(); ++i) {
    t.filtered.colour.emplace_back(2 + shift + (i % 2 ? own : -own) + noise * normal(generator));
  }
  return t;
}

TEST(Filtered, FindsErrorsAndWhatIsSystematicInThem) {
  const Film reference = make(2, 1, 400, 1);
  std::vector<FilterTrial> trials;
  for (unsigned s = 0; s < 8; ++s) trials.push_back(trial(10 + s, 0.05, 0.02, 0.04));
  const FilterFigures f = judge_filter(reference, trials);
  EXPECT_EQ(f.trials, 8);
  EXPECT_DOUBLE_EQ(f.samples, 16);
  EXPECT_NEAR(f.noisy, 0.25 / 2, 0.004);
  const double own = 0.05 * 0.05 + 0.02 * 0.02;
  EXPECT_NEAR(f.filtered, std::sqrt(own + 0.04 * 0.04) / 2, 0.002);
  EXPECT_NEAR(f.systematic, std::sqrt(own) / 2, 0.002);
  EXPECT_LE(std::abs(f.systematic * f.systematic - own / 4), 2 * f.systematic_square_half_width);
  EXPECT_NEAR(f.bias.value, 0.02 / 2, 1.5 * f.bias.half_width);
  EXPECT_LT(f.bias.half_width, 0.006);
  EXPECT_DOUBLE_EQ(f.estimated, 0.1);
  EXPECT_NEAR(f.gain(), std::pow(f.noisy / f.filtered, 2) * 2 / 4, 1e-12);
}

TEST(Filtered, FindsNothingSystematicInNoise) {
  const Film reference = make(2, 1, 400, 1);
  std::vector<FilterTrial> trials;
  for (unsigned s = 0; s < 8; ++s) trials.push_back(trial(10 + s, 0, 0, 0.04));
  const FilterFigures f = judge_filter(reference, trials);
  EXPECT_LE(f.systematic * f.systematic, 2 * f.systematic_square_half_width);
  EXPECT_LE(std::abs(f.bias.value), 2 * f.bias.half_width);
}

/// Student's quantile for two values is 12.706, and the error of their mean half their difference.
TEST(Filtered, IntervalsOfTwoTrialsAreKnown) {
  const Film reference = make(2, 0, 4, 1);
  std::vector<FilterTrial> trials;
  for (const double shift : {0.02, 0.06}) {
    FilterTrial& t = trials.emplace_back(trial(3, 0, shift, 0));
    t.film = reference;
  }
  const FilterFigures f = judge_filter(reference, trials);
  EXPECT_NEAR(f.bias.value, 0.02, 1e-9);
  EXPECT_NEAR(f.bias.half_width, 12.7062 * 0.02 / 2, 1e-5);
  const double a = 0.01 * 0.01, b = 0.03 * 0.03;  // squared errors beside the light
  EXPECT_NEAR(f.filtered_square_half_width, 12.7062 * (b - a) / 2, 1e-6);
}

TEST(Filtered, OneTrialHasNoIntervals) {
  const std::vector<FilterTrial> trials{trial(3, 0.05, 0, 0)};
  const FilterFigures f = judge_filter(make(2, 1, 400, 1), trials);
  EXPECT_EQ(f.bias.half_width, INFINITY);
  EXPECT_NEAR(f.filtered, 0.025, 0.003);
}

TEST(Filtered, RefusesWhatCannotBeCompared) {
  const std::vector<FilterTrial> trials{trial(3, 0.05, 0, 0)};
  EXPECT_THROW((void)judge_filter(make(0, 0, 4, 1), trials), Error);
  Film small = make(2, 1, 4, 1);
  small.pixels.pop_back();
  EXPECT_THROW((void)judge_filter(small, trials), Error);
}

FilterFigures figures(double samples, double noisy, double filtered) {
  FilterFigures f;
  f.samples = samples, f.noisy = noisy, f.filtered = filtered;
  f.plain_seconds = samples / 2, f.render_seconds = samples, f.filter_seconds = 1;
  return f;
}

TEST(Filtered, AdvisesBetweenWhatWasMeasured) {
  const std::vector<FilterFigures> all{figures(4, 0.4, 0.08), figures(16, 0.2, 0.04),
                                       figures(64, 0.1, 0.03)};
  EXPECT_DOUBLE_EQ(advise_plain(all, 0.05).samples, 256);
  EXPECT_DOUBLE_EQ(advise_plain(all, 0.05).seconds, 128);
  EXPECT_DOUBLE_EQ(advise_filtered(all, 0.1)->samples, 4);
  EXPECT_DOUBLE_EQ(advise_filtered(all, 0.04)->samples, 16);
  EXPECT_NEAR(advise_filtered(all, 0.08 / std::sqrt(2))->samples, 8, 1e-9);
  EXPECT_NEAR(advise_filtered(all, 0.08 / std::sqrt(2))->seconds, std::sqrt(5 * 17), 1e-9);
  EXPECT_FALSE(advise_filtered(all, 0.02));
}

}  // namespace filtered_test
}  // namespace pvol::measure
