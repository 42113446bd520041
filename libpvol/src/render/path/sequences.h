// Points that cover a square evenly, however many of them are taken.
#pragma once

#include <array>
#include <cstdint>

namespace pvol::detail {

[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t v) {
  v = __builtin_bswap32(v);
  v = (v & 0x0f0f0f0fu) << 4 | (v >> 4 & 0x0f0f0f0fu);
  v = (v & 0x33333333u) << 2 | (v >> 2 & 0x33333333u);
  return (v & 0x55555555u) << 1 | (v >> 1 & 0x55555555u);
}

/// A permutation of 32 bits in which each bit is flipped by those below it alone, as a hash of them
/// and the seed says. Of numbers with their bits in reverse it is an Owen scrambling, or a
/// shuffling of their order within all powers of two. Based on: Burley. Practical Hash-based Owen
/// Scrambling. 2020; Laine, Karras. Stratified sampling for stochastic transparency. 2011.
[[nodiscard]] constexpr std::uint32_t scramble_reversed(std::uint32_t v, std::uint32_t seed) {
  v += seed;
  v ^= v * 0x6c50b47cu;
  v ^= v * 0xb82f1e52u;
  v ^= v * 0xc7afe638u;
  return v ^ v * 0x8d22f6e6u;
}

/// Number `index` of Sobol's second dimension, its bits in reverse: bit k is the sum of those bits
/// n of the index for which the binomial (n k) is odd, that is k's bits are among n's (Lucas).
[[nodiscard]] constexpr std::uint32_t second_sobol_reversed(std::uint32_t index) {
  index ^= index >> 1 & 0x55555555u;
  index ^= index >> 2 & 0x33333333u;
  index ^= index >> 4 & 0x0f0f0f0fu;
  index ^= index >> 8 & 0x00ff00ffu;
  return index ^ (index >> 16);
}

/// Point `index` in [0, 1)^2 of Sobol's sequence, scrambled and shuffled by the seeds, and so
/// independent of others with other seeds: any 2^k points from a multiple of 2^k on have one in
/// each of 2^k equal boxes of any shape.
[[nodiscard]] constexpr std::array<float, 2> point_of_square(std::uint32_t index,
                                                             std::array<std::uint32_t, 3> seeds) {
  const std::uint32_t shuffled = reverse_bits(scramble_reversed(reverse_bits(index), seeds[0]));
  const auto fraction = [](std::uint32_t reversed) {
    return static_cast<float>(reverse_bits(reversed) >> 8) * 0x1p-24f;
  };
  return {fraction(scramble_reversed(shuffled, seeds[1])),
          fraction(scramble_reversed(second_sobol_reversed(shuffled), seeds[2]))};
}

/// Seeds by a key and a number, all of whose bits bear on all of theirs. Based on: Steele, Lea,
/// Flood. Fast splittable pseudorandom number generators. 2014.
[[nodiscard]] constexpr std::array<std::uint32_t, 3> seeds_of(std::uint64_t key,
                                                              std::uint64_t number) {
  const auto mix = [](std::uint64_t v) {
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9u;
    v = (v ^ v >> 27) * 0x94d049bb133111ebu;
    return v ^ v >> 31;
  };
  const std::uint64_t first = mix(mix(key) + number), second = mix(first);
  return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(first >> 32),
          static_cast<std::uint32_t>(second)};
}

}  // namespace pvol::detail
