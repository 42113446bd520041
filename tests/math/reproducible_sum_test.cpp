// Sums without an order: the same bits for any order and grouping, and the right value.
#include "pvol/math/reproducible_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "pvol/math/rng.h"

namespace pvol {
namespace reproducible_sum_test {

Sum1 sum_of(const std::vector<double>& terms) {
  Sum1 s;
  for (const double t : terms) add(s, t);
  return s;
}

/// Floats of either sign between 2^low and 2^high.
std::vector<double> random_floats(std::uint64_t seed, int n, int low, int high) {
  Rng rng(seed, 0, 0);
  std::vector<double> all;
  for (int i = 0; i < n; ++i) {
    const double exponent = low + double(rng.uniform()) * (high - low);
    const float v = float(std::exp2(exponent) * (1 + double(rng.uniform())));
    all.push_back(double(rng.uniform() < 0.3f ? -v : v));
  }
  return all;
}

void shuffle(std::vector<double>& terms, Rng& rng) {
  for (std::size_t i = terms.size(); i > 1; --i) {
    std::swap(terms[i - 1], terms[std::min(i - 1, std::size_t(rng.uniform() * float(i)))]);
  }
}

struct Decades {
  int low, high;  // powers of 2
};
constexpr Decades kDecades[] = {{-3, 3},       {-40, 10},     {-140, 120},
                                {-1000, 1000}, {-1070, -900}, {900, 1014}};

TEST(ReproducibleSum, KnowsNoOrder) {
  for (const Decades d : kDecades) {
    std::vector<double> terms = random_floats(7, 200, d.low, d.high);
    for (double& t : terms) {
      if (!std::isfinite(t) || t == 0) t = std::ldexp(1.0, (d.low + d.high) / 2);  // no float
    }
    const Sum1 expected = sum_of(terms);
    Rng rng(1, 2, 3);
    for (int trial = 0; trial < 200; ++trial) {
      shuffle(terms, rng);
      ASSERT_EQ(sum_of(terms), expected) << d.low << ' ' << d.high;
    }
    std::ranges::sort(terms);
    EXPECT_EQ(sum_of(terms), expected);
    std::ranges::reverse(terms);
    EXPECT_EQ(sum_of(terms), expected);
  }
}

TEST(ReproducibleSum, KnowsNoGrouping) {
  for (const Decades d : kDecades) {
    std::vector<double> terms;
    Rng rng(4, 5, 6);
    for (int i = 0; i < 300; ++i) {
      const double exponent = d.low + double(rng.uniform()) * (d.high - d.low);
      terms.push_back(std::exp2(exponent) * (double(rng.uniform()) - 0.5));
    }
    const Sum1 expected = sum_of(terms);
    for (int trial = 0; trial < 200; ++trial) {
      shuffle(terms, rng);
      std::vector<Sum1> groups(1 + std::size_t(rng.uniform() * 9));
      for (const double t : terms) {
        add(groups[std::min(groups.size() - 1, std::size_t(rng.uniform() * float(groups.size())))],
            t);
      }
      Sum1 all;
      for (const Sum1& g : groups) all.merge(g);
      ASSERT_EQ(all, expected);
    }
  }
}

/// The largest term of a level and the smallest of the next one: 0.5 is a likely value.
TEST(ReproducibleSum, KnowsNoOrderAtTheEdgesOfLevels) {
  for (int level = -2; level <= 2; ++level) {
    const double edge = std::ldexp(1.0, 32 * level + 31);
    std::vector<double> terms{edge,           0.3 * edge, -edge, edge * (1 - 0x1p-53),
                              0x1p-70 * edge, -edge / 2};
    std::ranges::sort(terms);
    const Sum1 expected = sum_of(terms);
    do {
      ASSERT_EQ(sum_of(terms), expected) << level;
    } while (std::ranges::next_permutation(terms).found);
  }
}

TEST(ReproducibleSum, IsExactForFloatsOfLikeSize) {
  const std::vector<double> terms = random_floats(11, 5000, -20, 15);
  const Sum1 s = sum_of(terms);
  const long double exact = std::accumulate(terms.begin(), terms.end(), 0.0L);
  EXPECT_LE(std::abs(value(s) - double(exact)), 2 * DBL_EPSILON * std::abs(double(exact)));
  // Whole numbers show that not a bit is lost.
  Sum1 whole;
  for (int i = 1; i <= 100'000; ++i) add(whole, i % 2 ? i * 1e6 : -double(i) * 1e6);
  EXPECT_EQ(value(whole), -5e10);
  Sum1 left;
  for (const double t : {0x1p60, 1.0, -0x1p60}) add(left, t);
  EXPECT_EQ(value(left), 1);
}

TEST(ReproducibleSum, OfSquaresOfOneFloatHasNoVariance) {
  for (const float v : {0.7f, 1e-20f, 3.3e7f, 1.1754944e-38f, 3e38f}) {
    const double x = double(v);
    Sum1 sum, squares;
    for (int i = 0; i < 1000; ++i) add(sum, x), add(squares, x * x);
    EXPECT_EQ(value(sum), 1000 * x);
    EXPECT_EQ(value(squares), 1000 * (x * x));
  }
}

TEST(ReproducibleSum, KeepsEveryDouble) {
  Rng rng(3, 1, 4);
  for (int i = 0; i < 100'000; ++i) {
    const auto bits = rng.block().lo;
    (void)rng.uniform();
    const double v = std::bit_cast<double>(mix64(bits + std::uint64_t(i)));
    if (!std::isfinite(v) || std::abs(v) < 0x1p-1000) continue;
    Sum1 s;
    add(s, v);
    ASSERT_EQ(value(s), v);
  }
}

TEST(ReproducibleSum, RoundsWhatIsFarBelowTheLargestTermOff) {
  // Errors are at most 2^-64 of the largest term each, in either direction.
  std::vector<double> terms(1000, 1.0 / 3);
  terms.push_back(0x1p40);
  const double exact = 0x1p40 + 1000.0 / 3;
  EXPECT_NEAR(value(sum_of(terms)), exact, 1000 * 0x1p-24);
  terms.back() = 0x1p200;
  EXPECT_EQ(value(sum_of(terms)), 0x1p200);
  // Cancelled, the small ones are gone, in whatever order.
  terms.push_back(-0x1p200);
  const Sum1 late = sum_of(terms);
  std::rotate(terms.begin(), terms.end() - 2, terms.end());
  EXPECT_EQ(sum_of(terms), late);
  EXPECT_EQ(value(late), 0);
}

TEST(ReproducibleSum, OfSeveralChannelsTakesTheUnitOfTheLargest) {
  Sum3 a, b;
  const Vec3d terms[] = {{1, 1e-3, 5e5}, {3e9, 1, -2}, {0, 0, 0}, {-1e-9, 7, 7}};
  for (const Vec3d& t : terms) add(a, t);
  for (int i = 3; i >= 0; --i) add(b, terms[i]);
  EXPECT_EQ(a, b);
  EXPECT_NEAR(value(a).x, 1 + 3e9 - 1e-9, 1e-6);
  EXPECT_NEAR(value(a).y, 1e-3 + 8, 1e-9);
  EXPECT_NEAR(value(a).z, 5e5 + 5, 1e-9);
}

/// Of many terms at once that of one after the other, whatever the number of rows and their blocks.
TEST(ReproducibleSum, OfRowsIsThatOfTerms) {
  for (const Decades d : kDecades) {
    std::array<std::vector<double>, 3> rows;
    for (std::uint64_t c = 0; c < 3; ++c) {
      rows[c] = random_floats(c + 11, 60, d.low, d.high);
      for (double& t : rows[c]) {
        if (!std::isfinite(t)) t = 0;
      }
    }
    for (const std::size_t most : {1u, 2u, 7u, 60u}) {
      Sum3 one, many;
      Sum1 first;
      for (std::size_t k = 0; k < 60; ++k) add(one, {rows[0][k], rows[1][k], rows[2][k]});
      for (std::size_t k = 0; k < 60; k += most) {
        const std::size_t n = std::min(most, 60 - k);
        many.add({&rows[0][k], &rows[1][k], &rows[2][k]}, n);
        first.add({&rows[0][k]}, n);
      }
      many.add({nullptr, nullptr, nullptr}, 0);
      ASSERT_EQ(many, one) << d.low << ' ' << d.high << ' ' << most;
      ASSERT_EQ(first, sum_of(rows[0])) << d.low << ' ' << d.high << ' ' << most;
    }
  }
}

/// Digits are full where all terms are as large as a level allows.
TEST(ReproducibleSum, HoldsAsManyTermsAsSamplesHaveNumbers) {
  Sum1 s;
  add(s, 0x1p31 * (1 - 0x1p-53));
  for (int doubling = 0; doubling < 31; ++doubling) s.merge(Sum1(s));
  EXPECT_NEAR(value(s) / 0x1p62, 1, 1e-15);
}

/// What a sum's values and remainder make of it.
template <class Sum>
Sum stored_and_restored(const Sum& s) {
  return restored(value(s), s.remainder());
}

/// Where terms cancel the remainder is large.
TEST(ReproducibleSum, GoesOnFromItsValuesAndItsRemainder) {
  for (const Decades d : kDecades) {
    Rng rng(11, 0, 0);
    Sum1 one, straight;
    Sum3 three, straight_three;
    bool any = false;
    for (int i = 0; i < 400; ++i) {
      const int exponent = d.low + int(double(rng.uniform()) * (d.high - d.low));
      const double t = std::ldexp((1 + double(rng.uniform())) / 3, exponent);
      const Vec3d v(t, -t / 3, i % 5 == 4 ? -value(straight) : t);
      add(one, v.z), add(straight, v.z);
      add(three, v), add(straight_three, v);
      any = any || one.remainder() != Sum1::Remainder{.level = one.level};
      one = stored_and_restored(one), three = stored_and_restored(three);
      ASSERT_EQ(one, straight) << d.low << ' ' << d.high << " term " << i;
      ASSERT_EQ(three, straight_three) << d.low << ' ' << d.high << " term " << i;
    }
    EXPECT_TRUE(any) << d.low << ' ' << d.high;
  }
}

/// The largest terms and digits that there are.
TEST(ReproducibleSum, OfTheMostTermsHasARemainder) {
  for (const int sign : {1, -1}) {
    const double term = sign * (0x1p31 - 0x1p-1 - 0x1p-21);  // its digits round up
    Sum1 s, one;
    add(one, term), add(one, sign * 0x1p-33), add(one, sign * 0x1p-66);
    for (std::uint32_t n = 1; n <= Sum1::kMostPacked / 3; ++n) {
      s.merge(one);
      if (n % 1000 == 0 || n == Sum1::kMostPacked / 3) {
        ASSERT_EQ(stored_and_restored(s), s) << n;
      }
    }
    for (auto& digit : s.digits) digit[0] = sign * (std::int64_t(1) << 31) * Sum1::kMostPacked;
    EXPECT_EQ(stored_and_restored(s), s) << sign;
  }
}

TEST(ReproducibleSum, OfNothingIsZero) {
  Sum1 s;
  EXPECT_EQ(value(s), 0);
  add(s, 0);
  add(s, -0.0);
  EXPECT_EQ(s, Sum1{});
  Sum1 one;
  add(one, 1);
  const Sum1 before = one;
  one.merge(s);
  EXPECT_EQ(one, before);
  s.merge(one);
  EXPECT_EQ(s, one);
}

}  // namespace reproducible_sum_test
}  // namespace pvol
