// Gradient noise on the integer lattice and its sums over octaves, with certified ranges over
// boxes.
#pragma once

#include <cstdint>

#include "pvol/math/box.h"
#include "pvol/math/interval.h"

namespace pvol {

/// Noise of one octave: C2, zero at lattice points, with features of about one cell.
///
/// With f the fraction of p in its cell [i, i+1]^3 and fade(f) = 6f^5 - 15f^4 + 10f^3,
///   n(p) = sqrt(2/3) sum_c w_c g_c . (f - c),
/// over the corners c in {0,1}^3, w_c the trilinear weights of fade(f). The gradient g_c is one of
/// the twelve (0,+-1,+-1), (+-1,0,+-1), (+-1,+-1,0), four of them twice, chosen by the four highest
/// bits of mix64(seed + K . (i + c)) with the odd 64-bit constants K of noise.cpp: a lattice
/// without a period. Coordinates must be below 2^52 in magnitude; beyond that a double has no
/// fraction.
///
/// N1: |n| <= 1. The weights are not negative and sum to 1, so by Jensen's inequality
///   (sum_c w_c g_c . (f - c))^2 <= |g|^2 sum_c w_c |f - c|^2 = 2 sum_axes k(f_a),
/// with k(f) = (1-s) f^2 + s (1-f)^2 and s = fade(f). For f = 1/2 + e, s = 1/2 + d:
/// k = 1/4 + e^2 - 2ed <= 1/4, as fade lies between f and the nearer end, |d| >= |e|, of one sign.
/// Hence the sum is at most sqrt(3/2), and the factor sqrt(2/3) makes that 1.
///
/// Based on: Perlin. Improving Noise. SIGGRAPH 2002. Where we depart: the hash and the scale.
[[nodiscard]] double gradient_noise(std::uint64_t seed, Vec3d p);

/// Holds n(p), as computed, for every p in the box. Uses the gradients of the lattice where the box
/// meets at most kRangeCells cells along each axis, else N1.
[[nodiscard]] Interval gradient_noise_range(std::uint64_t seed, const Box& box);
inline constexpr int kRangeCells = 4;

/// A sum over octaves: with n_k the noise of octave k, of cell size cell / 2^k and lattice of its
/// own,
///   fbm(p) = sum_k gain^k n_k(p) / sum_k gain^k          in [-1, 1] (but for rounding), or
///   fbm(p) = sum_k gain^k |n_k(p)| / sum_k gain^k        in [0, 1] where `billow` is set:
/// round bumps that meet in sharp valleys, as on a cauliflower.
struct Fbm {
  std::uint64_t seed = 1;
  double cell = 1;    ///< size of the first octave's cells, world units, > 0
  int octaves = 4;    ///< in 1..kMaxOctaves
  double gain = 0.5;  ///< amplitude of an octave over that of the one before it, in (0, 1]
  bool billow = false;
  friend bool operator==(const Fbm&, const Fbm&) = default;
};
inline constexpr int kMaxOctaves = 16;

[[nodiscard]] double fbm(const Fbm& noise, Vec3d p);

/// Holds fbm(p), as computed, for every p in the box.
[[nodiscard]] Interval fbm_range(const Fbm& noise, const Box& box);

/// Holds fbm(p), as computed, for every p.
[[nodiscard]] Interval fbm_range(const Fbm& noise);

}  // namespace pvol
