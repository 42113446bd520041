// One octave of noise: what points and ranges have in common.
#pragma once

#include <array>

#include "pvol/density/noise.h"
#include "pvol/math/rng.h"

namespace pvol::detail {

inline constexpr double kNoiseScale = 0.816496580927726;  // sqrt(2/3), N1

// 2^64 / r, / r^2 and / r^3 with r^4 = r + 1, made odd: lattice points that share a hash lie some
// 2^21 cells apart.
inline constexpr std::uint64_t kHashX = 0xd1b54a32d192ed03, kHashY = 0xabc98388fb8fac03,
                               kHashZ = 0x8cb92ba72f3d8dd7;
inline constexpr int kIndexShift = 60;  // the four highest bits

// The edges of a cube; the last four repeat the vertices of a tetrahedron, which keeps the mean 0.
inline constexpr std::array<Vec3d, 16> kGradients{
    Vec3d{1, 1, 0}, {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
    {1, 0, -1},     {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
    {1, 1, 0},      {-1, 1, 0},  {0, -1, 1}, {0, -1, -1}};

/// Seed and map of one octave's lattice: p -> p * scale + offset, monotone on each axis even when
/// rounded, so that the corners of a box go to the corners of a box around the image.
struct Octave {
  std::uint64_t seed;
  double scale;
  Vec3d offset;
  [[nodiscard]] Vec3d map(Vec3d p) const { return p * scale + offset; }
};

inline Octave octave(const Fbm& noise, int k) {
  const std::uint64_t seed = mix64(noise.seed + static_cast<std::uint64_t>(k) * kHashX);
  // Offsets keep the zeros of the octaves apart: three numbers of 21 bits in [0, 256).
  const std::uint64_t bits = mix64(seed);
  const auto offset = [&](int axis) {
    return static_cast<double>(bits >> (21 * axis) & 0x1fffff) * 0x1p-13;
  };
  return {seed, static_cast<double>(1 << k) / noise.cell, {offset(0), offset(1), offset(2)}};
}

}  // namespace pvol::detail
