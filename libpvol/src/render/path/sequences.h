// Points that cover a square evenly, however many of them are taken.
#pragma once

#include <array>
#include <cstdint>

namespace pvol::detail {

[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t v) {
  v = (v >> 16) | (v << 16);
  v = (v & 0x00ff00ffu) << 8 | (v >> 8 & 0x00ff00ffu);
  v = (v & 0x0f0f0f0fu) << 4 | (v >> 4 & 0x0f0f0f0fu);
  v = (v & 0x33333333u) << 2 | (v >> 2 & 0x33333333u);
  return (v & 0x55555555u) << 1 | (v >> 1 & 0x55555555u);
}

/// A permutation of 32 bits in which each bit is flipped by those above it alone, as a hash of them
/// and the seed says: an Owen scrambling of numbers, or a shuffling of their order within all
/// powers of two. Based on: Burley. Practical Hash-based Owen Scrambling. 2020; Laine, Karras.
/// Stratified sampling for stochastic transparency. 2011.
[[nodiscard]] constexpr std::uint32_t scramble(std::uint32_t v, std::uint32_t seed) {
  v = reverse_bits(v) + seed;
  v ^= v * 0x6c50b47cu;
  v ^= v * 0xb82f1e52u;
  v ^= v * 0xc7afe638u;
  v ^= v * 0x8d22f6e6u;
  return reverse_bits(v);
}

/// The first two dimensions of Sobol's sequence, as fractions of 2^32: any 2^k points from a
/// multiple of 2^k on have one in each of the 2^k equal boxes of any shape.
[[nodiscard]] constexpr std::array<std::uint32_t, 2> sobol_point(std::uint32_t index) {
  std::uint32_t second = 0, direction = 0x80000000u;
  for (std::uint32_t bits = index; bits != 0; bits >>= 1) {
    if (bits & 1) second ^= direction;
    direction ^= direction >> 1;
  }
  return {reverse_bits(index), second};
}

/// Point `index` of a sequence in [0, 1)^2 that is scrambled and shuffled by the seeds, and so
/// independent of others with other seeds.
[[nodiscard]] constexpr std::array<float, 2> point_of_square(std::uint32_t index,
                                                             std::array<std::uint32_t, 3> seeds) {
  const auto [x, y] = sobol_point(scramble(index, seeds[0]));
  const auto fraction = [](std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; };
  return {fraction(scramble(x, seeds[1])), fraction(scramble(y, seeds[2]))};
}

}  // namespace pvol::detail
