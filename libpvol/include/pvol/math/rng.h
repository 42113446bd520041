// Counter-based random numbers: the same draw for the same key and counter, in any order and on
// any thread.
#pragma once

#include <bit>
#include <cstdint>

namespace pvol {

/// 64 well-mixed bits of x; a bijection (the finaliser of Stafford's variant 13, as in SplitMix64).
[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Philox2x64: a keyed bijection of a 128-bit counter.
/// Based on: Salmon et al. Parallel Random Numbers: As Easy as 1, 2, 3. SC 2011. Its products have
/// 128 bits, which no standard type holds, so that its body stays in the library, whose own sources
/// have it in place (src/math/philox.h). It is there for seven rounds alone.
template <int kRounds>
struct PhiloxOf {
  struct Block {
    std::uint64_t lo, hi;
  };
  [[nodiscard]] static Block block(std::uint64_t key, Block counter);
};
/// Six rounds are the fewest that pass BigCrush there; one more is the margin.
using Philox = PhiloxOf<7>;

/// 64 random bits as a number in [0, 1). Resolution near 0 is 2^-63, so that an event of
/// probability 1e-12 happens at its rate and not at that of a 24-bit grid.
[[nodiscard]] inline float to_uniform(std::uint64_t bits) {
  const float u = static_cast<float>(static_cast<std::int64_t>(bits >> 1)) * 0x1p-63f;
  return u < 1.0f ? u : 0x1.fffffep-1f;
}

/// 32 random bits as a number in [0, 1), in steps of 2^-32 near 0: for angles and choices, not for
/// free flights.
[[nodiscard]] inline float to_uniform_32(std::uint32_t bits) {
  const float u = static_cast<float>(static_cast<std::int64_t>(bits)) * 0x1p-32f;
  return u < 1.0f ? u : 0x1.fffffep-1f;
}

/// 64 random bits as a double in [0, 1), in steps of 2^-53: for choices among very many, where the
/// steps of 2^-24 between floats below 1 would starve what is there.
[[nodiscard]] inline double to_uniform_double(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// 64 random bits as -log(u), exponentially distributed with mean 1, in [0, 45): the optical depth
/// of a free flight. The relative error is below 3e-7 down to depths of 1e-19: the bits are read as
/// u = 2^-k (1 - f/2), k leading zeros and a fraction f, so that neither end of (0, 1] loses
/// digits, and -log(1 - f/2) / f is a minimax polynomial of degree 8 (relative error 2.3e-8).
[[nodiscard]] inline float to_exponential(std::uint64_t bits) {
  const int k = std::countl_zero(bits);
  const std::uint64_t rest = k < 63 ? bits << (k + 1) : 0;
  const float f = static_cast<float>(static_cast<std::int64_t>(rest >> 1)) * 0x1p-63f;
  const float g = f * f;
  const float even =
      0.50000001136f + g * (0.041712576860f +
                            g * (0.0084253986732f + g * (0.0098255452332f + g * 0.0028146638689f)));
  const float odd =
      0.12499821314f + g * (0.015175317348f + g * (-0.0031802962303f - g * 0.0066242654498f));
  return static_cast<float>(k) * 0.69314718056f + f * (even + f * odd);
}

/// A stream of random numbers, one for each (seed, pixel, sample). Each call takes the next block
/// of two words from its counter; callers draw in pairs where they need pairs.
class Rng {
 public:
  /// `stream` is the pixel's index, `sample` the index of the sample in the pixel.
  Rng(std::uint64_t seed, std::uint64_t stream, std::uint64_t sample)
      : key_(mix64(seed + 0x9e3779b97f4a7c15u) ^ stream), sample_(sample) {}

  /// Where a stream stands, for those who keep it themselves.
  struct State {
    std::uint64_t key, sample, counter;
  };
  explicit Rng(State s) : key_(s.key), sample_(s.sample), counter_(s.counter) {}
  [[nodiscard]] State state() const { return {key_, sample_, counter_}; }

  /// 128 random bits.
  [[nodiscard]] Philox::Block block() { return Philox::block(key_, {counter_++, sample_}); }

  [[nodiscard]] float uniform() { return to_uniform(block().lo); }

  struct Pair {
    float a, b;
  };
  /// Two independent numbers uniform in [0, 1).
  [[nodiscard]] Pair uniform2() {
    const Philox::Block r = block();
    return {to_uniform(r.lo), to_uniform(r.hi)};
  }

  struct Four {
    float a, b, c, d;
  };
  /// Four independent numbers uniform in [0, 1), each from 32 bits.
  [[nodiscard]] Four uniform4() {
    const Philox::Block r = block();
    const auto of = [](std::uint64_t bits) {
      return to_uniform_32(static_cast<std::uint32_t>(bits));
    };
    return {of(r.lo), of(r.lo >> 32), of(r.hi), of(r.hi >> 32)};
  }

  /// What a tentative collision takes.
  struct Tentative {
    float depth;  ///< optical depth up to it, exponentially distributed with mean 1
    float u;      ///< uniform in [0, 1), to decide what it is
  };
  [[nodiscard, gnu::always_inline]] Tentative tentative() {
    const Philox::Block r = block();
    return {to_exponential(r.lo), to_uniform(r.hi)};
  }

 private:
  std::uint64_t key_, sample_, counter_ = 0;
};

}  // namespace pvol
