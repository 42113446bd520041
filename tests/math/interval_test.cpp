// Interval arithmetic: containment against higher precision, and tightness.
#include "pvol/math/interval.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <random>

namespace pvol {
namespace interval_test {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Repeatable random numbers.
struct Draw {
  std::mt19937_64 engine;
  explicit Draw(std::uint64_t seed) : engine(seed) {}

  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine);
  }
  double log_uniform(double lo, double hi) {
    return std::exp2(uniform(std::log2(lo), std::log2(hi)));
  }
};

/// A double of any magnitude: subnormal to huge, both signs, and zeros.
double any_double(Draw& draw) {
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  constexpr double kHuge = std::numeric_limits<double>::max();
  switch (std::uniform_int_distribution<int>(0, 9)(draw.engine)) {
    case 0:
      return 0.0;
    case 1:
      return -0.0;
    case 2:
      return draw.uniform(-1, 1) < 0 ? -kHuge : kHuge;
    case 3:
      return kTiny * std::floor(draw.uniform(-100, 100));
    case 4:
    case 5:
      return draw.uniform(-1, 1);
    default: {
      const double size = std::exp2(draw.uniform(-1074, 1023.9));
      return draw.uniform(-1, 1) < 0 ? -size : size;
    }
  }
}

Interval any_interval(Draw& draw) {
  const double a = any_double(draw), b = any_double(draw);
  if (draw.uniform(0, 1) < 0.3) return a;
  return {std::min(a, b), std::max(a, b)};
}

/// Some number in the interval: an end or a mix.
long double pick(Interval x, Draw& draw) {
  const double u = draw.uniform(-0.3, 1.3);
  if (u <= 0) return x.lo;
  if (u >= 1) return x.hi;
  const long double mix = (1 - static_cast<long double>(u)) * x.lo + u * x.hi;
  return std::clamp<long double>(mix, x.lo, x.hi);
}

bool holds(Interval x, long double v) { return x.lo <= v && v <= x.hi; }

// The long double result is rounded too, but never across a double: what lies outside an interval
// by its exact value is not inside by its rounded one.
TEST(Interval, StepsAreThoseOfTheStandardLibrary) {
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  constexpr double kLeast = std::numeric_limits<double>::min();
  constexpr double kHuge = std::numeric_limits<double>::max();
  const auto expect_steps = [&](double x) {
    const auto bits = [](double y) { return std::bit_cast<std::uint64_t>(y); };
    EXPECT_EQ(bits(round_up(x)), bits(std::nextafter(x, kInf))) << x;
    EXPECT_EQ(bits(round_down(x)), bits(std::nextafter(x, -kInf))) << x;
  };
  for (const double x : {0.0, kTiny, kLeast, std::nextafter(kLeast, 0.0), 1.0, kHuge, kInf}) {
    expect_steps(x);
    expect_steps(-x);
  }
  Draw draw(11);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::bit_cast<double>(std::uint64_t(draw.engine()));
    if (!std::isnan(x)) expect_steps(x);
    expect_steps(any_double(draw));
  }
  EXPECT_TRUE(std::isnan(round_up(NAN)) && std::isnan(round_down(NAN)));
}

TEST(Interval, OperationsHoldEveryResultOfTheirOperands) {
  static_assert(std::numeric_limits<long double>::digits >= 64);
  Draw draw(10);
  for (int i = 0; i < 300'000; ++i) {
    const Interval a = any_interval(draw), b = any_interval(draw);
    const long double x = pick(a, draw), y = pick(b, draw);
    ASSERT_TRUE(holds(a, x) && holds(b, y));
    ASSERT_TRUE(holds(a + b, x + y)) << a.lo << " " << a.hi << " + " << b.lo << " " << b.hi;
    ASSERT_TRUE(holds(a - b, x - y)) << a.lo << " " << a.hi << " - " << b.lo << " " << b.hi;
    ASSERT_TRUE(holds(a * b, x * y)) << a.lo << " " << a.hi << " * " << b.lo << " " << b.hi;
    ASSERT_TRUE(holds(-a, -x));
    ASSERT_TRUE(holds(square(a), x * x)) << a.lo << " " << a.hi;
    ASSERT_TRUE(holds(sqrt(a), std::sqrt(std::max(x, 0.0L)))) << a.lo << " " << a.hi;
    ASSERT_TRUE(holds(min(a, b), std::min(x, y)));
    ASSERT_TRUE(holds(max(a, b), std::max(x, y)));
    ASSERT_TRUE(holds(hull(a, b), x) && holds(hull(a, b), y));
  }
}

TEST(Interval, LongChainsOfOperationsHoldTheResult) {
  Draw draw(11);
  for (int i = 0; i < 2000; ++i) {
    Interval x = draw.uniform(-2, 2);
    long double exact = x.lo;
    for (int k = 0; k < 100; ++k) {
      const double v = draw.uniform(-1.5, 1.5);
      switch (k % 4) {
        case 0:
          x = x + v, exact += v;
          break;
        case 1:
          x = x * v, exact *= v;
          break;
        case 2:
          x = sqrt(square(x)), exact = std::abs(exact);
          break;
        default:
          x = v - x, exact = v - exact;
          break;
      }
      ASSERT_TRUE(holds(x, exact));
    }
    EXPECT_LT(x.width(), 1e-12);
  }
}

TEST(Interval, OverflowAndUnboundedOperandsStayEnclosures) {
  const double huge = std::numeric_limits<double>::max();
  const Interval past_all = Interval(huge) * Interval(huge);
  EXPECT_EQ(past_all, Interval(huge, kInf));
  EXPECT_EQ(Interval(huge) + Interval(huge), Interval(huge, kInf));
  EXPECT_EQ(-past_all + past_all, Interval(-kInf, kInf));
  EXPECT_TRUE((Interval(0, 1) * past_all).contains(0));
  EXPECT_TRUE((Interval(0, 1) * past_all).contains(huge));
  const Interval all(-kInf, kInf);
  EXPECT_EQ(all * Interval(0, 1), all);
  EXPECT_EQ(Interval(0, 1) * all, all);
  EXPECT_TRUE((all * Interval(0)).contains(0));
  EXPECT_LT((all * Interval(0)).width(), 1e-300);
  EXPECT_EQ(square(all), Interval(0, kInf));
  EXPECT_EQ(sqrt(all), Interval(0, kInf));
}

/// Steps between neighbouring doubles from a to b, both positive.
std::int64_t ulps(double a, double b) {
  return std::bit_cast<std::int64_t>(b) - std::bit_cast<std::int64_t>(a);
}

TEST(Interval, EachOperationCostsAtMostOneUlpOnASide) {
  Draw draw(12);
  for (int i = 0; i < 10'000; ++i) {
    const double a = draw.log_uniform(1e-100, 1e100), b = draw.log_uniform(1e-100, 1e100);
    for (const Interval x : {Interval(a) + Interval(b), Interval(a) * Interval(b),
                             square(Interval(a)), sqrt(Interval(a))}) {
      EXPECT_EQ(ulps(x.lo, x.hi), 2);
    }
    EXPECT_EQ(ulps(sqrt(Interval(a)).lo, std::sqrt(a)), 1);
  }
}

TEST(Interval, SquareIsNeverNegativeAndTighterThanAProductAcrossZero) {
  EXPECT_EQ(square(Interval(-1, 2)).lo, 0);
  EXPECT_EQ(square(Interval(-2, -1)), square(Interval(1, 2)));
  EXPECT_GT(square(Interval(-2, -1)).lo, 0.999);
  EXPECT_EQ(ulps(4, square(Interval(-1, 2)).hi), 1);
  EXPECT_LT((Interval(-1, 2) * Interval(-1, 2)).lo, -1.9);
  EXPECT_EQ(square(Interval(0)).lo, 0);
  EXPECT_EQ(square(Interval(1e-200)).lo, 0) << "an underflow is not rounded below zero";
  EXPECT_GT(square(Interval(1e-200)).hi, 0);
}

TEST(Interval, SqrtTakesTheNonNegativePart) {
  EXPECT_EQ(sqrt(Interval(-4, -1)).lo, 0);
  EXPECT_LT(sqrt(Interval(-4, -1)).hi, 1e-300);
  EXPECT_EQ(sqrt(Interval(-4, 4)).lo, 0);
  EXPECT_EQ(ulps(2, sqrt(Interval(-4, 4)).hi), 1);
}

}  // namespace interval_test
}  // namespace pvol
