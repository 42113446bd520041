// The random numbers: the generator's bits, their conversion to numbers, the streams' independence.
#include "pvol/math/rng.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <string>

#include "support/statistics.h"

namespace pvol {
namespace rng_test {

using proof::Family;
using proof::Histogram;
using proof::Moments;

constexpr int kSamples = 1'000'000;
constexpr std::uint64_t kAllBits = ~std::uint64_t{0};

/// Philox2x64 once more, from the paper, with the 128-bit product built from 32-bit halves.
Philox::Block slow_philox(std::uint64_t key, std::uint64_t c0, std::uint64_t c1, int rounds) {
  const std::uint64_t multiplier = 0xD2B74407B1CE6E93, low_half = 0xFFFFFFFF;
  for (int r = 0; r < rounds; ++r) {
    const std::uint64_t al = c0 & low_half, ah = c0 >> 32;
    const std::uint64_t bl = multiplier & low_half, bh = multiplier >> 32;
    const std::uint64_t ll = al * bl, lh = al * bh, hl = ah * bl, hh = ah * bh;
    const std::uint64_t middle = (ll >> 32) + (lh & low_half) + (hl & low_half);
    const std::uint64_t high = hh + (lh >> 32) + (hl >> 32) + (middle >> 32);
    const std::uint64_t low = (middle << 32) | (ll & low_half);
    c0 = high ^ c1 ^ (key + std::uint64_t(r) * 0x9E3779B97F4A7C15);
    c1 = low;
  }
  return {c0, c1};
}

void expect_block(Philox::Block found, std::uint64_t lo, std::uint64_t hi) {
  EXPECT_EQ(found.lo, lo);
  EXPECT_EQ(found.hi, hi);
}

TEST(Philox, GivesThePublishedAnswers) {
  // The authors' known-answer vectors for philox2x64 with 7 rounds: zeros, ones, digits of pi.
  expect_block(Philox::block(0, {0, 0}), 0xb41da69fbfefc666, 0x511e9ce1a5534056);
  expect_block(Philox::block(kAllBits, {kAllBits, kAllBits}), 0xa4696cc04462015d,
               0x724782dae17169e9);
  expect_block(Philox::block(0xa4093822299f31d0, {0x243f6a8885a308d3, 0x13198a2e03707344}),
               0x98ed1534392bf372, 0x67528b1568882fd5);
  // The slow version also knows those for 10 rounds.
  expect_block(slow_philox(0xa4093822299f31d0, 0x243f6a8885a308d3, 0x13198a2e03707344, 10),
               0x0a5e742c2997341c, 0xb0f883d38000de5d);
}

TEST(Philox, AgreesWithArithmeticInHalves) {
  std::uint64_t key = 1, lo = 2, hi = 3;
  for (int i = 0; i < 10'000; ++i) {
    const Philox::Block b = Philox::block(key, {lo, hi}), slow = slow_philox(key, lo, hi, 7);
    ASSERT_EQ(b.lo, slow.lo);
    ASSERT_EQ(b.hi, slow.hi);
    key = hi ^ 5, hi = b.lo, lo = b.hi;
  }
}

TEST(Philox, FlippingOneBitOfTheKeyOrTheCounterFlipsHalfOfTheResult) {
  Moments flipped;
  for (int bit = 0; bit < 192; ++bit) {
    for (std::uint64_t i = 0; i < 50; ++i) {
      const std::uint64_t mask = std::uint64_t{1} << (bit % 64);
      const std::uint64_t key = bit < 64 ? mask : 0, lo = bit / 64 == 1 ? mask : 0,
                          hi = bit / 64 == 2 ? mask : 0;
      const Philox::Block a = Philox::block(7, {i, 9});
      const Philox::Block b = Philox::block(7 ^ key, {i ^ lo, 9 ^ hi});
      flipped.add(std::popcount(a.lo ^ b.lo) + std::popcount(a.hi ^ b.hi));
      ASSERT_GT(std::popcount(a.lo ^ b.lo) + std::popcount(a.hi ^ b.hi), 24) << bit;
    }
  }
  EXPECT_GT(proof::mean_p_value(flipped, 64), proof::kFalseAlarmRate);
}

TEST(Rng, KeepsItsNumbersFromVersionToVersion) {
  Rng rng(1, 2, 3);
  expect_block(rng.block(), 0xe6a3fa6457b911e8, 0x12505db954813e36);
  expect_block(rng.block(), 0x24f7f13c25069ef7, 0xa2ae43374531a2fc);
  expect_block(rng.block(), 0x1f2ba3d11c4ba5e0, 0x9aae0bfabbf3edd0);
  expect_block(Rng(kAllBits, kAllBits, kAllBits).block(), 0x22038cda4a7911d9, 0x2e6dbc90ef636995);
}

TEST(Rng, StreamsDifferBySeedPixelAndSample) {
  std::set<std::uint64_t> seen;
  const std::uint64_t large = std::uint64_t{1} << 40;
  std::size_t count = 0;
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{2}, large}) {
    for (std::uint64_t i = 0; i < 40; ++i) {
      for (std::uint64_t k = 0; k < 40; ++k) {
        Rng rng(seed, i < 20 ? i : large + i, k < 20 ? k : large * k);
        for (int draw = 0; draw < 4; ++draw, ++count) seen.insert(rng.block().lo);
      }
    }
  }
  EXPECT_EQ(seen.size(), count);
}

TEST(Rng, DrawsDoNotDependOnWhatOtherStreamsDo) {
  Rng a(5, 6, 7), b(5, 6, 8);
  std::array<std::uint64_t, 100> alone{}, mixed{};
  for (auto& v : alone) v = a.block().hi;
  Rng again(5, 6, 7);
  for (auto& v : mixed) {
    for (int i = 0; i < 3; ++i) (void)b.uniform();
    v = again.block().hi;
  }
  EXPECT_EQ(alone, mixed);
  Rng copy = again;
  EXPECT_EQ(copy.uniform(), again.uniform()) << "a copy continues where the original stood";
}

TEST(Rng, EachKindOfDrawTakesOneBlock) {
  Rng a(1, 2, 3), b(1, 2, 3);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(a.uniform(), to_uniform(b.block().lo));
    const Rng::Pair pair = a.uniform2();
    const Philox::Block bits = b.block();
    EXPECT_EQ(pair.a, to_uniform(bits.lo));
    EXPECT_EQ(pair.b, to_uniform(bits.hi));
    const Rng::Tentative next = a.tentative();
    const Philox::Block words = b.block();
    EXPECT_EQ(next.depth, to_exponential(words.lo));
    EXPECT_EQ(next.u, to_uniform(words.hi));
  }
}

TEST(Rng, EveryBitIsFairAndRunsOfLeadingZerosHaveTheirRate) {
  std::array<std::uint64_t, 128> ones{};
  std::array<std::uint64_t, 65> leading_lo{}, leading_hi{};
  Rng rng(proof::seeded(11), 0, 0);
  for (int i = 0; i < kSamples; ++i) {
    const Philox::Block b = rng.block();
    for (std::size_t bit = 0; bit < 64; ++bit) {
      ones[bit] += b.lo >> bit & 1;
      ones[64 + bit] += b.hi >> bit & 1;
    }
    ++leading_lo[std::size_t(std::countl_zero(b.lo))];
    ++leading_hi[std::size_t(std::countl_zero(b.hi))];
  }
  Family family;
  for (std::size_t bit = 0; bit < ones.size(); ++bit) {
    const double z = (double(ones[bit]) - kSamples / 2.0) / std::sqrt(kSamples / 4.0);
    family.add("bit " + std::to_string(bit), proof::normal_p_value(z));
  }
  std::array<double, 65> expected{};
  for (std::size_t k = 0; k < 64; ++k) expected[k] = kSamples * std::exp2(-double(k) - 1);
  expected[64] = kSamples * 0x1p-64;
  family.add("zeros of lo", proof::counts_p_value(leading_lo, expected));
  family.add("zeros of hi", proof::counts_p_value(leading_hi, expected));
  EXPECT_TRUE(family.passes());
}

TEST(ToUniform, StaysInItsRangeAtBothEnds) {
  EXPECT_EQ(to_uniform(0), 0);
  EXPECT_EQ(to_uniform(2), 0x1p-63f);
  EXPECT_EQ(to_uniform(kAllBits), 0x1.fffffep-1f);
  for (std::uint64_t below = 1; below != 0; below <<= 1) {
    EXPECT_LT(to_uniform(kAllBits - below), 1.0f) << below;
    EXPECT_GE(to_uniform(below), 0.0f) << below;
  }
}

TEST(ToUniform, DoublesHaveEvenStepsBelowOne) {
  EXPECT_EQ(to_uniform_double(0), 0);
  EXPECT_EQ(to_uniform_double(kAllBits), 1 - 0x1p-53);
  EXPECT_EQ(to_uniform_double(std::uint64_t{1} << 63), 0.5);
  EXPECT_EQ(to_uniform_double(std::uint64_t{1} << 11), 0x1p-53);
}

TEST(ToUniform, RareEventsHaveTheirRate) {
  // The conversion ascends, so the number of words below p is found exactly.
  for (double p = 0.9; p > 1e-16; p *= 0.3) {
    const float threshold = float(p);
    std::uint64_t below = 0, above = kAllBits;
    while (above - below > 1) {
      const std::uint64_t middle = below + (above - below) / 2;
      (to_uniform(middle) < threshold ? below : above) = middle;
    }
    const double rate = double(above) * 0x1p-64;
    EXPECT_NEAR(rate, double(threshold), 1e-7 * p + 0x1p-62) << p;
  }
}

/// The word whose depth is the `rank`-th smallest, so that P(depth < that one's) = rank / 2^64.
std::uint64_t word_of_rank(std::uint64_t rank) {
  // The words with k leading zeros come after all those with fewer; ~rank has k leading zeros then.
  const int k = std::countl_one(rank);
  if (k == 64) return 0;
  const std::uint64_t leading = std::uint64_t{1} << (63 - k);
  return leading | (rank & (leading - 1));
}

TEST(ToExponential, IsTheLogarithmToThePromisedAccuracyOverTheWholeRange) {
  // The rank's survival probability 1 - rank / 2^64 is exact in long double.
  Rng rng(12, 0, 0);
  double worst = 0;
  const auto check = [&](std::uint64_t rank) {
    const long double below = std::ldexp(static_cast<long double>(rank), -64);
    const double exact = double(-std::log1p(-below));
    const double found = double(to_exponential(word_of_rank(rank)));
    if (rank == 0) {
      EXPECT_EQ(found, 0);
      return;
    }
    // Below 1e-19 neighbouring words are more than one digit apart.
    ASSERT_NEAR(found, exact, 3e-7 * exact + 0x1p-64) << rank;
    if (exact > 1e-17) worst = std::max(worst, std::abs(found / exact - 1));
  };
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t bits = rng.block().lo;
    check(bits);
    check(bits >> (i % 64));     // down to the smallest depths
    check(~(bits >> (i % 64)));  // up to the largest
  }
  for (int k = 0; k < 64; ++k) {
    const std::uint64_t edge = std::uint64_t{1} << k;
    for (const std::uint64_t rank : {edge - 1, edge, edge + 1, ~edge, ~edge + 1, ~edge - 1}) {
      check(rank);
    }
  }
  check(0);
  check(kAllBits);
  EXPECT_LT(worst, 3e-7);
}

TEST(ToExponential, IsFiniteAndNotNegativeAtBothEnds) {
  EXPECT_EQ(to_exponential(std::uint64_t{1} << 63), 0);
  EXPECT_FALSE(std::signbit(to_exponential(std::uint64_t{1} << 63)));
  EXPECT_NEAR(to_exponential(0), 64 * std::log(2.0), 1e-4);
  EXPECT_LT(to_exponential(0), 45.0f);
  EXPECT_NEAR(to_exponential(kAllBits), std::log(2.0), 1e-6);
}

TEST(ToExponential, TailsAndSmallDepthsHaveTheirRates) {
  // Depths ascend with rank but for rounding, which moves a rate by the accuracy tested above.
  const auto rate_below = [](double depth) {
    std::uint64_t below = 0, above = kAllBits;
    while (above - below > 1) {
      const std::uint64_t middle = below + (above - below) / 2;
      (double(to_exponential(word_of_rank(middle))) < depth ? below : above) = middle;
    }
    return above;
  };
  for (const double depth : {20.0, 25.0, 30.0, 36.0, 40.0}) {
    const double rate = double(kAllBits - rate_below(depth) + 1) * 0x1p-64;
    EXPECT_NEAR(rate / std::exp(-depth), 1, 3e-7 * depth * 4 + 0x1p-63 / std::exp(-depth)) << depth;
  }
  for (double depth = 1e-2; depth > 1e-17; depth *= 0.1) {
    const double rate = double(rate_below(depth)) * 0x1p-64;
    EXPECT_NEAR(rate / -std::expm1(-depth), 1, 1e-6 + 0x1p-62 / depth) << depth;
  }
}

/// Counts of pairs in 16 x 16 equal squares.
class Squares {
 public:
  void add(double a, double b) { ++counts_[std::size_t(a * 16) * 16 + std::size_t(b * 16)]; }
  [[nodiscard]] double p_value() const { return proof::equal_counts_p_value(counts_); }

 private:
  std::array<std::uint64_t, 256> counts_{};
};

TEST(Rng, UniformNumbersAndTheirPairsFillTheirSpaceEvenly) {
  Histogram coarse(64), fine(4096);
  Squares consecutive, in_block;
  Moments moments;
  Rng rng(proof::seeded(13), 0, 0), rng2(proof::seeded(13), 1, 0);
  double last = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = double(rng.uniform());
    coarse.add(u);
    fine.add(u);
    moments.add(u);
    if (i % 2) consecutive.add(last, u);
    last = u;
    const auto [a, b] = rng2.uniform2();
    in_block.add(double(a), double(b));
  }
  Family family;
  family.add("64 bins", coarse.uniform_p_value());
  family.add("4096 bins", fine.uniform_p_value());
  family.add("mean", proof::mean_p_value(moments, 0.5));
  family.add("consecutive pairs", consecutive.p_value());
  family.add("pairs of a block", in_block.p_value());
  EXPECT_TRUE(family.passes());
  EXPECT_NEAR(moments.variance(), 1.0 / 12, 5 * std::sqrt(1.0 / 180 / kSamples));
}

TEST(Rng, NeighbouringStreamsAreIndependent) {
  Squares pixels, samples, seeds, first_draws;
  Histogram over_pixels(256), over_samples(256), over_seeds(256);
  for (std::uint64_t i = 0; i < 300'000; ++i) {
    const double u = double(Rng(14, i, 0).uniform());
    over_pixels.add(u);
    over_samples.add(double(Rng(14, 77, i).uniform()));
    over_seeds.add(double(Rng(i, 77, 0).uniform()));
    pixels.add(u, double(Rng(14, i + 300'000, 0).uniform()));
    samples.add(u, double(Rng(14, i, 1).uniform()));
    seeds.add(u, double(Rng(15, i, 0).uniform()));
    Rng next(proof::seeded(14), 2 * i + 1'000'000, 0),
        after(proof::seeded(14), 2 * i + 1'000'001, 0);
    first_draws.add(double(next.uniform()), double(after.uniform()));
  }
  Family family;
  family.add("first draws of pixels", over_pixels.uniform_p_value());
  family.add("first draws of samples", over_samples.uniform_p_value());
  family.add("first draws of seeds", over_seeds.uniform_p_value());
  family.add("pixels far apart", pixels.p_value());
  family.add("samples of a pixel", samples.p_value());
  family.add("seeds", seeds.p_value());
  family.add("neighbouring pixels", first_draws.p_value());
  EXPECT_TRUE(family.passes());
}

TEST(Rng, DrawsOfAStreamAreUncorrelated) {
  constexpr int kLags = 16;
  std::array<double, kLags + 1> history{};
  std::array<Moments, kLags + 1> products;
  Rng rng(proof::seeded(16), 3, 4);
  for (int i = 0; i < kSamples; ++i) {
    const double x = double(rng.uniform()) - 0.5;
    for (int lag = 1; lag <= kLags && lag <= i; ++lag) {
      products[std::size_t(lag)].add(x * history[std::size_t((i - lag) % (kLags + 1))]);
    }
    history[std::size_t(i % (kLags + 1))] = x;
  }
  Family family;
  for (std::size_t lag = 1; lag <= kLags; ++lag) {
    family.add("lag " + std::to_string(lag), proof::mean_p_value(products[lag], 0));
  }
  EXPECT_TRUE(family.passes());
}

TEST(Rng, TentativeDepthsAreExponentialAndIndependentOfTheirDecision) {
  Moments depth, square;
  Histogram survival(256);
  Squares joint;
  std::uint64_t beyond_10 = 0, below_1e_4 = 0;
  Rng rng(proof::seeded(17), 0, 0);
  for (int i = 0; i < 2 * kSamples; ++i) {
    const auto [tau, u] = rng.tentative();
    const double t = double(tau);
    depth.add(t);
    square.add((t - 1) * (t - 1));
    survival.add(std::exp(-t));
    joint.add(std::min(-std::expm1(-t), 1 - 1e-16), double(u));
    beyond_10 += t > 10;
    below_1e_4 += t < 1e-4;
  }
  Family family;
  family.add("mean", proof::mean_p_value(depth, 1));
  family.add("variance", proof::mean_p_value(square, 1));
  family.add("distribution", survival.uniform_p_value());
  family.add("independence", joint.p_value());
  family.add("tail", proof::poisson_p_value(beyond_10, 2 * kSamples * std::exp(-10)));
  family.add("small", proof::poisson_p_value(below_1e_4, 2 * kSamples * -std::expm1(-1e-4)));
  EXPECT_TRUE(family.passes());
}

/// Uniform each, and in pairs; in [0, 1) up to the last of their bits.
TEST(Rng, FourNumbersOfABlockAreUniformAndIndependent) {
  Family family;
  constexpr std::size_t kBins = 16;
  std::array<Histogram, 4> each{Histogram(64), Histogram(64), Histogram(64), Histogram(64)};
  std::array<Histogram, 4> pairs{Histogram(256), Histogram(256), Histogram(256), Histogram(256)};
  Rng rng(proof::seeded(7), 3, 1);
  for (int i = 0; i < 100'000; ++i) {
    const auto [a, b, c, d] = rng.uniform4();
    const std::array<float, 4> x{a, b, c, d};
    for (std::size_t k = 0; k < 4; ++k) {
      each[k].add(double(x[k]));
      const double first = std::floor(double(x[k]) * kBins);
      pairs[k].add((first + double(x[(k + 1) % 4])) / kBins);
    }
  }
  for (std::size_t k = 0; k < 4; ++k) {
    family.add("number " + std::to_string(k), each[k].uniform_p_value());
    family.add("pair " + std::to_string(k), pairs[k].uniform_p_value());
  }
  EXPECT_TRUE(family.passes());
  EXPECT_EQ(to_uniform_32(0), 0);
  EXPECT_LT(to_uniform_32(~std::uint32_t{0}), 1.0f);
}

}  // namespace rng_test
}  // namespace pvol
