// Statistics for tests of randomised code: p-values, and one decision over a family of them.
//
// A test case collects the p-value of each of its comparisons in a `Family` and ends with
// EXPECT_TRUE(family.passes()). Code that is right fails a family with probability 1e-3 over the
// choice of seeds, however many comparisons the family holds. Seeds are fixed, so a case that
// passes passes until the numbers it draws change; one false alarm in a thousand such changes is
// the price, and main.cpp tells it from an error by new seeds (effort.h). What the tests can see: a
// mean that is off by k standard errors of the mean with k > 5 or so, and a histogram whose
// share-weighted squared relative error exceeds about 10 sqrt(bins) / samples. The cases in
// significance_test.cpp plant errors of 1 % and ask that they are found.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/effort.h"

namespace pvol::proof {

/// Probability that a family of correct comparisons fails.
inline constexpr double kFalseAlarmRate = 1e-3;
/// How the message of a family that failed begins; main.cpp knows it by that.
inline constexpr const char* kFamilyFailure = "comparisons rejected at level ";

/// Mean and variance of a stream of numbers.
/// Based on: Welford. Note on a Method for Calculating Corrected Sums of Squares and Products.
/// 1962.
class Moments {
 public:
  void add(double x) {
    ++count_;
    const double from_old_mean = x - mean_;
    mean_ += from_old_mean / double(count_);
    squares_ += from_old_mean * (x - mean_);
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  /// Unbiased estimate; 0 for fewer than two numbers.
  [[nodiscard]] double variance() const { return count_ < 2 ? 0 : squares_ / double(count_ - 1); }
  [[nodiscard]] double variance_of_mean() const {
    return count_ == 0 ? 0 : variance() / double(count_);
  }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

/// b(0) + a(1) / (b(1) + a(2) / (b(2) + ...)) by the method of Lentz (1976); no denominator on the
/// way may vanish, as none does for the two fractions below.
template <class Numerator, class Denominator>
[[nodiscard]] double continued_fraction(Numerator a, Denominator b) {
  constexpr int kMostTerms = 1'000'000;  // both fractions need about sqrt(parameter) terms
  double value = b(0), c = value, d = 0;
  for (int n = 1; n < kMostTerms; ++n) {
    d = 1 / (b(n) + a(n) * d);
    c = b(n) + a(n) / c;
    value *= c * d;
    if (std::abs(c * d - 1) < std::numeric_limits<double>::epsilon()) return value;
  }
  throw std::runtime_error("continued_fraction: no convergence");
}

struct Tails {
  double lower, upper;  ///< they add up to 1
};

/// The regularised incomplete gamma functions P(a, x) and Q(a, x); a > 0, x >= 0 (DLMF 8.2, 8.11.4,
/// 8.9.2). The smaller tail is accurate to about 1e-12 relative for a up to 1e4.
[[nodiscard]] inline Tails gamma_tails(double a, double x) {
  if (x <= 0) return {0, 1};
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (double n = a + 1; term > sum * std::numeric_limits<double>::epsilon(); ++n) {
      term *= x / n;
      sum += term;
    }
    return {scale * sum, 1 - scale * sum};
  }
  const double upper = scale / continued_fraction([&](int n) { return -n * (n - a); },
                                                  [&](int n) { return x + 2 * n + 1 - a; });
  return {1 - upper, upper};
}

/// The regularised incomplete beta function I_x(a, b), with y = 1 - x given apart because it may be
/// tiny (DLMF 8.17.22).
[[nodiscard]] inline double beta_lower(double a, double b, double x, double y) {
  if (x <= 0) return 0;
  if (y <= 0) return 1;
  if (x * (a + b + 2) > a + 1) return 1 - beta_lower(b, a, y, x);
  const double log_scale =
      a * std::log(x) + b * std::log(y) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b);
  const auto numerator = [&](int n) {
    const double m = n / 2, two_m = 2 * m;
    return n % 2 == 0 ? m * (b - m) * x / ((a + two_m - 1) * (a + two_m))
                      : -(a + m) * (a + b + m) * x / ((a + two_m) * (a + two_m + 1));
  };
  return std::exp(log_scale) / (a * continued_fraction(numerator, [](int) { return 1.0; }));
}

/// Probability that a standard normal variable is farther from 0 than z.
[[nodiscard]] inline double normal_p_value(double z) {
  return std::erfc(std::abs(z) / std::sqrt(2.0));
}

/// The same for Student's t with `dof` > 0 degrees of freedom.
[[nodiscard]] inline double student_p_value(double t, double dof) {
  const double sum = dof + t * t;
  return beta_lower(dof / 2, 0.5, dof / sum, t * t / sum);
}

/// Probability that a chi-square variable with `dof` degrees of freedom exceeds x.
[[nodiscard]] inline double chi_square_p_value(double x, double dof) {
  return gamma_tails(dof / 2, x / 2).upper;
}

/// Two-sided: the probability, doubled, that a Poisson variable of this mean is as far out as
/// `count` on count's side. For events so rare that the normal law does not hold.
[[nodiscard]] inline double poisson_p_value(std::uint64_t count, double mean) {
  const double n = double(count);
  const double at_most = gamma_tails(n + 1, mean).upper;
  const double at_least = count == 0 ? 1 : gamma_tails(n, mean).lower;
  return std::min(1.0, 2 * std::min(at_most, at_least));
}

/// t-test of a mean against its expectation. `rounding` is the systematic error that the code may
/// have in the mean (float arithmetic); only what exceeds it counts. Without variance the mean has
/// to be right to `rounding`.
[[nodiscard]] inline double mean_p_value(const Moments& m, double expected, double rounding = 0) {
  const double excess = std::max(0.0, std::abs(m.mean() - expected) - rounding);
  if (excess == 0 || std::isnan(excess)) return excess == 0 && m.count() > 0 ? 1 : 0;
  if (m.variance() == 0) return 0;
  return student_p_value(excess / std::sqrt(m.variance_of_mean()), double(m.count() - 1));
}

/// Whether two samples have the same mean, their variances unknown and perhaps different.
/// Based on: Welch. The Generalization of `Student's' Problem. Biometrika 34, 1947.
[[nodiscard]] inline double equal_means_p_value(const Moments& a, const Moments& b) {
  const double va = a.variance_of_mean(), vb = b.variance_of_mean(), v = va + vb;
  const double difference = a.mean() - b.mean();
  if (!(v > 0)) return difference == 0 && a.count() > 0 && b.count() > 0 ? 1 : 0;
  const double dof = v * v / (va * va / double(a.count() - 1) + vb * vb / double(b.count() - 1));
  return student_p_value(difference / std::sqrt(v), dof);
}

/// Fewest expected events in a bin for which the chi-square law holds (Cochran 1954).
inline constexpr double kLeastExpected = 5;

/// Pearson's chi-square test of counts against their expectations, which have the same sum.
/// Neighbouring bins are pooled until each expects 5 events. An event in a bin that expects none
/// gives 0 at once, so that pooling hides no impossible event.
[[nodiscard]] inline double counts_p_value(std::span<const std::uint64_t> observed,
                                           std::span<const double> expected) {
  if (observed.size() != expected.size()) throw std::invalid_argument("counts: sizes differ");
  struct Pool {
    double observed = 0, expected = 0;
  };
  std::vector<Pool> pools(1);
  Pool total;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (observed[i] > 0 && !(expected[i] > 0)) return 0;
    if (pools.back().expected >= kLeastExpected) pools.emplace_back();
    for (Pool* p : {&pools.back(), &total}) {
      p->observed += double(observed[i]);
      p->expected += expected[i];
    }
  }
  if (!(std::abs(total.observed - total.expected) <= 1e-6 * total.observed)) {
    throw std::invalid_argument("counts: observed and expected events have different sums");
  }
  if (pools.size() > 1 && pools.back().expected < kLeastExpected) {
    const Pool rest = pools.back();
    pools.pop_back();
    pools.back().observed += rest.observed;
    pools.back().expected += rest.expected;
  }
  if (pools.size() < 2) throw std::invalid_argument("counts: too few events for a test");
  double chi_square = 0;
  for (const Pool& p : pools) {
    chi_square += (p.observed - p.expected) * (p.observed - p.expected) / p.expected;
  }
  return chi_square_p_value(chi_square, double(pools.size() - 1));
}

/// The same where every bin is equally likely.
[[nodiscard]] inline double equal_counts_p_value(std::span<const std::uint64_t> observed) {
  double sum = 0;
  for (const std::uint64_t n : observed) sum += double(n);
  return counts_p_value(observed,
                        std::vector<double>(observed.size(), sum / double(observed.size())));
}

/// Counts of numbers in equal bins over [0, 1]; a number outside (or NaN) is a failed test.
class Histogram {
 public:
  explicit Histogram(std::size_t bins) : counts_(bins) {}
  void add(double u) {
    if (!(u >= 0 && u <= 1)) throw std::out_of_range("histogram: not in [0, 1]");
    const auto bin = std::size_t(u * double(counts_.size()));
    ++counts_[std::min(bin, counts_.size() - 1)];
  }
  [[nodiscard]] std::span<const std::uint64_t> counts() const { return counts_; }
  [[nodiscard]] double uniform_p_value() const { return equal_counts_p_value(counts_); }

 private:
  std::vector<std::uint64_t> counts_;
};

/// The level of each of `count` independent tests at which all together have level `rate`:
/// 1 - (1 - rate)^(1 / count) (Sidak 1967).
[[nodiscard]] inline double sidak_level(double rate, std::size_t count) {
  return -std::expm1(std::log1p(-rate) / double(count));
}

/// The comparisons of one test case, decided together.
class Family {
 public:
  void add(std::string name, double p_value) { members_.push_back({std::move(name), p_value}); }

  /// Fails where a p-value is below Sidak's level or not a number, and where there is none.
  [[nodiscard]] ::testing::AssertionResult passes() const {
    if (members_.empty()) return ::testing::AssertionFailure() << "no comparison was made";
    const double level = sidak_level(kFalseAlarmRate, members_.size());
    auto failure = ::testing::AssertionFailure() << kFamilyFailure << level << ":";
    bool failed = false;
    for (const Member& m : members_) {
      if (m.p_value >= level) continue;
      failure << "\n  " << m.name << ": p = " << m.p_value;
      failed = true;
    }
    return failed ? failure : ::testing::AssertionSuccess();
  }

 private:
  struct Member {
    std::string name;
    double p_value;
  };
  std::vector<Member> members_;
};

}  // namespace pvol::proof
