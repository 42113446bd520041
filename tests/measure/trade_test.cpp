// Medians with intervals, Pareto fronts and advice on data whose answers are known.
#include "pvol/measure/trade.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/error.h"
#include "pvol/math/rng.h"

namespace pvol::measure {
namespace trade_test {

TEST(Median, LiesBetweenThePairThatHoldsItWithTheCoverageAsked) {
  const Estimate few = estimate_median({3, 1, 2});
  EXPECT_EQ(few.value, 2);
  EXPECT_EQ(few.low, 1);
  EXPECT_EQ(few.high, 3);
  EXPECT_NEAR(few.coverage, 0.75, 1e-12);

  const Estimate even = estimate_median({4, 1, 2, 8, 3, 9});
  EXPECT_EQ(even.value, 3.5);
  EXPECT_NEAR(even.coverage, 1 - 2.0 / 64, 1e-12);

  // Of 9 values the second and the eighth will do: 1 - 2 (1 + 9) / 2^9.
  const Estimate nine = estimate_median({9, 8, 7, 6, 5, 4, 3, 2, 1});
  EXPECT_EQ(nine.low, 2);
  EXPECT_EQ(nine.high, 8);
  EXPECT_NEAR(nine.coverage, 1 - 20.0 / 512, 1e-12);

  const Estimate one = estimate_median({5});
  EXPECT_EQ(one.low, 5);
  EXPECT_EQ(one.coverage, 0);
  EXPECT_THROW((void)estimate_median({}), Error);
}

/// For each number of values, against sums over all ways in which as many coins fall: the interval
/// is two-sided, the narrowest that will do, and the widest there is where none does.
TEST(Median, IntervalIsTheNarrowestOfItsCoverageForEveryCount) {
  for (int n = 1; n <= 40; ++n) {
    std::vector<double> values;
    for (int i = 1; i <= n; ++i) values.push_back(i);  // the k-th smallest is k
    const auto coverage = [n](int low) {               // of the interval from `low` to n + 1 - low
      double outside = 0, ways = 1;                    // to choose i of n
      for (int i = 0; i < low; ++i) {
        outside += 2 * ways * std::exp2(-n);
        ways *= double(n - i) / (i + 1);
      }
      return std::max(0.0, 1 - outside);
    };
    const Estimate e = estimate_median(values, 0.95);
    const int low = int(e.low);
    EXPECT_EQ(e.high, n + 1 - low) << n;
    EXPECT_NEAR(e.coverage, coverage(low), 1e-12) << n;
    EXPECT_TRUE(coverage(low) >= 0.95 || low == 1) << n;
    EXPECT_TRUE(2 * (low + 1) > n || coverage(low + 1) < 0.95) << n;
  }
}

TEST(Median, IsCoveredAsOftenAsStated) {
  // A skewed law, exponential of median ln 2. 4000 trials of 95.7 %: 3828 +- 13.
  Rng rng(1, 2, 3);
  int held = 0;
  const int trials = 4000;
  for (int t = 0; t < trials; ++t) {
    std::vector<double> values;
    for (int i = 0; i < 12; ++i) values.push_back(-std::log(1 - double(rng.uniform())));
    const Estimate e = estimate_median(values);
    EXPECT_GE(e.coverage, 0.95);
    held += e.low <= std::log(2.0) && std::log(2.0) <= e.high;
  }
  EXPECT_NEAR(double(held) / trials, 1 - 2 * (1 + 12 + 66) / 4096.0, 0.012);
}

TEST(Ratio, IsThatOfTheSameRound) {
  const std::vector<double> slow{2, 20, 200, 2}, fast{1, 10, 100, 1};
  const Estimate e = estimate_ratio(slow, fast);
  EXPECT_EQ(e.value, 2);
  EXPECT_EQ(e.low, 2);
  EXPECT_EQ(e.high, 2);
  const std::vector<double> none{0, 0};
  EXPECT_EQ(estimate_ratio(none, none).value, 1);
}

TEST(Sidak, LevelsMultiplyToTheFamilys) {
  EXPECT_NEAR(std::pow(1 - sidak_level(0.01, 30), 30), 0.99, 1e-12);
  EXPECT_EQ(sidak_level(0.01, 1), 0.01);
}

Film film_of(const std::vector<std::vector<double>>& samples) {
  Film f;
  f.width = f.crop_width = int(samples.size());
  f.height = f.crop_height = 1;
  for (const auto& pixel : samples) {
    PixelSums p;
    for (const double v : pixel) {
      p.sum += Vec3d(v);
      p.sum_squares += Vec3d(v * v);
      ++p.samples;
    }
    f.pixels.push_back(p);
  }
  return f;
}

TEST(Films, AddToTheFilmOfAllTheirSamples) {
  Film sum = film_of({{2}, {7}});
  add_samples(sum, film_of({{1, 3}, {5, 9}}));
  EXPECT_EQ(sum.pixels[0].samples, 3u);
  EXPECT_NEAR(mean_luminance(sum), (2 + 7) / 2.0, 1e-12);
  EXPECT_NEAR(sample_variance(sum), (1 + 4) / 2.0, 1e-12);
  EXPECT_THROW(add_samples(sum, film_of({{1}})), Error);
}

TEST(Pareto, KeepsWhatNothingBeats) {
  const std::vector<Costs> settings{{1, 1, 1}, {2, 0, 1}, {2, 1, 1},
                                    {3, 3, 0}, {1, 1, 1}, {3, 3, 0.5}};
  EXPECT_EQ(pareto_front(settings), (std::vector<std::size_t>{0, 1, 3, 4}));
  EXPECT_TRUE(pareto_front({}).empty());
}

TEST(Pareto, AgreesWithSearchingForABetterOneOnRandomSettings) {
  Rng rng(4, 5, 6);
  std::vector<Costs> settings(60);
  for (Costs& c : settings) {
    for (double& v : c) v = std::floor(double(rng.uniform()) * 4);
  }
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    bool beaten = false;
    for (const Costs& o : settings) {
      beaten = beaten || (o != settings[i] && o[0] <= settings[i][0] && o[1] <= settings[i][1] &&
                          o[2] <= settings[i][2]);
    }
    if (!beaten) expected.push_back(i);
  }
  EXPECT_EQ(pareto_front(settings), expected);
}

// Three settings: the default; one of half the time and a systematic error of 0.02; one that is
// perhaps a little better than the default.
const std::vector<Setting> kSettings{
    {1e-5, 0, 1, 0, 1}, {0.5e-5, 0, 1, 4e-4, 1}, {0.97e-5, 0, 1, 0, 1.1}};

TEST(Advice, TakesABiasedSettingOnlyWhereItsErrorFits) {
  const auto strict = advise_for_error(kSettings, 1e4, 0.01);
  ASSERT_TRUE(strict);
  EXPECT_EQ(strict->setting, 0u);
  EXPECT_EQ(strict->samples, 10000);
  EXPECT_NEAR(strict->seconds, 1000, 1e-6);
  EXPECT_NEAR(strict->error, 0.01, 1e-12);

  const auto loose = advise_for_error(kSettings, 1e4, 0.1);
  ASSERT_TRUE(loose);
  EXPECT_EQ(loose->setting, 1u);
  EXPECT_NEAR(loose->samples, std::ceil(1 / (0.01 - 4e-4)), 0);
  EXPECT_LE(loose->error, 0.1);
}

TEST(Advice, ForATimeIsTheLeastErrorInIt) {
  const auto brief = advise_for_time(kSettings, 1e4, 1);
  ASSERT_TRUE(brief);
  EXPECT_EQ(brief->setting, 1u);
  EXPECT_NEAR(brief->samples, 20, 1);  // 1 / (1e4 * 0.5e-5), rounded down
  const auto patient = advise_for_time(kSettings, 1e4, 1000);
  ASSERT_TRUE(patient);
  EXPECT_EQ(patient->setting, 0u);
  EXPECT_LE(patient->seconds, 1000 * (1 + 1e-12));
  EXPECT_FALSE(advise_for_time(kSettings, 1e4, 1e-3));
}

TEST(Advice, LeavesTheFirstSettingOnlyForOneThatIsBetterBeyondDoubt) {
  std::vector<Setting> two{kSettings[0], kSettings[2]};
  EXPECT_EQ(advise_for_error(two, 1e4, 0.01)->setting, 0u);
  two[1].doubt = 1;
  EXPECT_EQ(advise_for_error(two, 1e4, 0.01)->setting, 1u);
}

TEST(Advice, CountsTheTimeBeforeTheFirstSample) {
  std::vector<Setting> two{kSettings[0], kSettings[0]};
  two[1].seconds /= 2;
  two[1].set_up = 100;
  EXPECT_EQ(advise_for_error(two, 1e4, 0.1)->setting, 0u);
  EXPECT_EQ(advise_for_error(two, 1e4, 0.001)->setting, 1u);
}

TEST(Advice, IsNoneWhereNoSettingIsGoodEnough) {
  const std::vector<Setting> biased{kSettings[1]};
  EXPECT_FALSE(advise_for_error(biased, 1e4, 0.01));
}

}  // namespace trade_test
}  // namespace pvol::measure
