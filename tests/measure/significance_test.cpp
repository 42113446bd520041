// The statistical tools of the tests, against closed forms and against planted errors.
#include "support/statistics.h"

#include <numbers>
#include <random>

namespace pvol::proof {
namespace significance_test {

/// Samples of each comparison below, as many as the other tests draw.
constexpr int kSamples = 1'000'000;

TEST(Significance, ChiSquareHasItsClosedFormForEvenDegrees) {
  for (const int dof : {2, 4, 10, 100, 1000}) {
    for (const double ratio : {0.2, 0.7, 0.99, 1.0, 1.01, 1.3, 2.0}) {
      // Q(n, x) = e^-x sum_{k < n} x^k / k!
      const double x = dof * ratio / 2;
      long double term = std::exp(-static_cast<long double>(x)), sum = 0;
      for (int k = 0; k < dof / 2; ++k) {
        sum += term;
        term *= x / (k + 1);
      }
      const double expected = double(sum);
      EXPECT_NEAR(chi_square_p_value(dof * ratio, dof) / expected, 1, 1e-10) << dof << " " << ratio;
    }
  }
}

TEST(Significance, ChiSquareOfOneDegreeIsTheNormalLaw) {
  for (const double z : {0.01, 0.5, 1.0, 2.0, 5.0, 12.0}) {
    EXPECT_NEAR(chi_square_p_value(z * z, 1) / normal_p_value(z), 1, 1e-11) << z;
  }
  EXPECT_NEAR(normal_p_value(1.959963984540054), 0.05, 1e-12);
  EXPECT_NEAR(chi_square_p_value(18.30703805327515, 10), 0.05, 1e-12);
  EXPECT_NEAR(chi_square_p_value(11.07049769351635, 5), 0.05, 1e-12);
}

TEST(Significance, StudentHasItsClosedFormsForOneAndTwoDegreesAndItsLimit) {
  for (const double t : {1e-9, 0.01, 0.5, 1.0, 3.0, 50.0}) {
    EXPECT_NEAR(student_p_value(t, 1), 2 * std::atan2(1, t) / std::numbers::pi, 1e-12) << t;
    EXPECT_NEAR(student_p_value(t, 2), 1 - t / std::sqrt(2 + t * t), 1e-12) << t;
  }
  for (const double t : {1e-9, 0.01, 0.5, 1.0, 3.0, 8.0}) {
    EXPECT_NEAR(student_p_value(t, 1e10) / normal_p_value(t), 1, 1e-4) << t;
  }
  EXPECT_NEAR(student_p_value(2.228138851986274, 10), 0.05, 1e-12);
  EXPECT_EQ(student_p_value(0, 7), 1);
}

TEST(Significance, PoissonCountsBothTails) {
  EXPECT_NEAR(poisson_p_value(0, 3), 2 * std::exp(-3), 1e-14);
  EXPECT_NEAR(poisson_p_value(1, 0.01), 2 * -std::expm1(-0.01), 1e-14);
  EXPECT_EQ(poisson_p_value(3, 3), 1);
  EXPECT_NEAR(poisson_p_value(10'300, 10'000) / normal_p_value(3), 1, 0.1);
}

TEST(Significance, MomentsKeepTheirDigitsFarFromZero) {
  Moments m;
  for (int i = 0; i < kSamples; ++i) m.add(1e9 + i % 3);
  EXPECT_NEAR(m.mean(), 1e9 + 1, 1e-5);
  EXPECT_NEAR(m.variance(), 2.0 / 3, 1e-5);
  EXPECT_EQ(Moments{}.variance_of_mean(), 0);
}

TEST(Significance, SidakKeepsTheRateOfAFamily) {
  EXPECT_EQ(sidak_level(0.001, 1), 0.001);
  for (const std::size_t n : {2u, 10u, 1000u}) {
    EXPECT_NEAR(1 - std::pow(1 - sidak_level(0.001, n), double(n)), 0.001, 1e-12);
  }
}

TEST(Significance, PValuesOfRightHypothesesAreUniform) {
  std::mt19937_64 random(1);
  std::exponential_distribution<double> exponential;
  std::uniform_int_distribution<int> die(0, 5);
  Histogram of_means(10), of_differences(10), of_counts(10);
  for (int run = 0; run < 2000; ++run) {
    Moments a, b;
    for (int i = 0; i < 2000; ++i) a.add(exponential(random));
    for (int i = 0; i < 1000; ++i) b.add(3 * exponential(random) - 2);
    std::vector<std::uint64_t> counts(6);
    for (int i = 0; i < 2000; ++i) ++counts[std::size_t(die(random))];
    of_means.add(mean_p_value(a, 1));
    of_differences.add(equal_means_p_value(a, b));
    of_counts.add(equal_counts_p_value(counts));
  }
  Family family;
  family.add("t-test", of_means.uniform_p_value());
  family.add("Welch", of_differences.uniform_p_value());
  family.add("chi-square", of_counts.uniform_p_value());
  EXPECT_TRUE(family.passes());
}

TEST(Significance, PoolingKeepsSparseTailsHonest) {
  // Geometric events over 60 bins, most of which expect next to nothing.
  std::mt19937_64 random(2);
  std::geometric_distribution<int> geometric(0.5);
  Histogram p_values(10);
  for (int run = 0; run < 2000; ++run) {
    std::vector<std::uint64_t> counts(60);
    std::vector<double> expected(60);
    for (int i = 0; i < 1000; ++i) ++counts[std::size_t(geometric(random))];
    for (int k = 0; k < 60; ++k) expected[std::size_t(k)] = 1000 * std::exp2(-k - 1);
    p_values.add(counts_p_value(counts, expected));
  }
  EXPECT_GT(p_values.uniform_p_value(), kFalseAlarmRate);
}

TEST(Significance, ImpossibleEventsAndMissingOnesAreRejected) {
  const std::vector<std::uint64_t> observed{100, 99, 1}, short_of_one{100, 99, 0};
  const std::vector<double> expected{100, 100, 0};
  EXPECT_EQ(counts_p_value(observed, expected), 0);
  EXPECT_THROW((void)counts_p_value(short_of_one, expected), std::invalid_argument);
  EXPECT_THROW((void)counts_p_value(std::vector<std::uint64_t>{2, 2}, std::vector<double>{2, 2}),
               std::invalid_argument);
  EXPECT_THROW(Histogram(4).add(std::nan("")), std::out_of_range);
}

TEST(Significance, FamilyFailsOnOneSmallOrUndefinedPValueAndOnNone) {
  Family family;
  EXPECT_FALSE(family.passes());
  family.add("fine", 0.5);
  EXPECT_TRUE(family.passes());
  Family with_nan = family;
  family.add("small", 0.4 * kFalseAlarmRate);
  with_nan.add("undefined", std::nan(""));
  EXPECT_FALSE(family.passes());
  EXPECT_FALSE(with_nan.passes());
  EXPECT_EQ(mean_p_value(Moments{}, 0), 0) << "nothing was measured";
}

/// The level that a comparison has among 30 others.
const double kLevel = sidak_level(kFalseAlarmRate, 30);

TEST(Significance, AMeanThatIsOnePerCentOffIsFound) {
  std::mt19937_64 random(3);
  std::exponential_distribution<double> right(1), wrong(1 / 1.01);
  Moments a, b;
  for (int i = 0; i < kSamples; ++i) {
    a.add(right(random));
    b.add(wrong(random));
  }
  EXPECT_GT(mean_p_value(a, 1), kLevel);
  EXPECT_LT(mean_p_value(b, 1), kLevel);
  EXPECT_LT(mean_p_value(b, 1, 1e-3), kLevel)
      << "an allowance for rounding hides no more than that";
  EXPECT_LT(equal_means_p_value(a, b), kLevel);
  EXPECT_GT(mean_p_value(b, 1, 0.011), kLevel);
}

TEST(Significance, ADensityThatIsOnePerCentOffInHalfItsRangeIsFound) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform;
  Histogram right(64), wrong(64);
  for (int i = 0; i < kSamples; ++i) {
    const double u = uniform(random);
    right.add(u);
    wrong.add(u < 0.505 ? u / 1.01 : 0.5 + (u - 0.505) / 0.99);
  }
  EXPECT_GT(right.uniform_p_value(), kLevel);
  EXPECT_LT(wrong.uniform_p_value(), kLevel);
}

TEST(Significance, ExponentialDepthsStretchedByOnePerCentAreFoundByTheirHistogram) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> wrong(1 / 1.01);
  Histogram bins(64);
  for (int i = 0; i < kSamples; ++i) bins.add(-std::expm1(-wrong(random)));
  EXPECT_LT(bins.uniform_p_value(), kLevel);
}

}  // namespace significance_test
}  // namespace pvol::proof
