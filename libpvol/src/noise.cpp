#include "pvol/medium/noise.h"

#include <array>
#include <cmath>

#include "pvol/math/rng.h"

namespace pvol {
namespace {

constexpr double kScale = 0.816496580927726;  // sqrt(2/3), N1

// 2^64 / r, / r^2 and / r^3 with r^4 = r + 1, made odd: lattice points that share a hash lie some
// 2^21 cells apart.
constexpr std::uint64_t kHashX = 0xd1b54a32d192ed03, kHashY = 0xabc98388fb8fac03,
                        kHashZ = 0x8cb92ba72f3d8dd7;
constexpr int kIndexShift = 60;  // the four highest bits

// The edges of a cube; the last four repeat the vertices of a tetrahedron, which keeps the mean 0.
constexpr std::array<Vec3d, 16> kGradients{Vec3d{1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0},
                                           {1, 0, 1},      {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
                                           {0, 1, 1},      {0, -1, 1}, {0, 1, -1}, {0, -1, -1},
                                           {1, 1, 0},      {-1, 1, 0}, {0, -1, 1}, {0, -1, -1}};

// Range evaluation works on numbers below 8 in magnitude and rounds fewer than 100 times on the way
// to any result, and so does the noise itself: 2 * 100 * 8 * 2^-53 < 2e-13.
constexpr double kRounding = 2e-13;
constexpr Interval kAll{-1 - kRounding, 1 + kRounding};  // N1

struct Cell {
  std::array<Vec3d, 8> gradients;  // of corner (c & 1, c >> 1 & 1, c >> 2)
};

Cell cell_at(std::uint64_t seed, std::int64_t x, std::int64_t y, std::int64_t z) {
  const std::uint64_t base = seed + static_cast<std::uint64_t>(x) * kHashX +
                             static_cast<std::uint64_t>(y) * kHashY +
                             static_cast<std::uint64_t>(z) * kHashZ;
  Cell cell;
  for (unsigned c = 0; c < 8; ++c) {
    const std::uint64_t corner =
        base + (c & 1 ? kHashX : 0) + (c & 2 ? kHashY : 0) + (c & 4 ? kHashZ : 0);
    cell.gradients[c] = kGradients[mix64(corner) >> kIndexShift];
  }
  return cell;
}

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

double lerp(double a, double b, double t) { return a + t * (b - a); }

/// Values of a + t (b - a) for independent a, b and t in [0, 1]: linear in each, so at their ends.
Interval lerp(Interval a, Interval b, Interval t) {
  return {std::min(lerp(a.lo, b.lo, t.lo), lerp(a.lo, b.lo, t.hi)),
          std::max(lerp(a.hi, b.hi, t.lo), lerp(a.hi, b.hi, t.hi))};
}

/// Noise in a cell for fractions f in [lo, hi], but for rounding and the scale.
Interval range_in_cell(const Cell& cell, Vec3d lo, Vec3d hi) {
  std::array<Interval, 8> slope;
  for (unsigned c = 0; c < 8; ++c) {
    const Vec3d corner(c & 1, c >> 1 & 1, c >> 2);
    const Vec3d a = cell.gradients[c] * (lo - corner), b = cell.gradients[c] * (hi - corner);
    const Vec3d least = min(a, b), most = max(a, b);
    slope[c] = {least.x + least.y + least.z, most.x + most.y + most.z};
  }
  const Interval x{fade(lo.x), fade(hi.x)}, y{fade(lo.y), fade(hi.y)}, z{fade(lo.z), fade(hi.z)};
  return lerp(lerp(lerp(slope[0], slope[1], x), lerp(slope[2], slope[3], x), y),
              lerp(lerp(slope[4], slope[5], x), lerp(slope[6], slope[7], x), y), z);
}

/// Seed and map of one octave's lattice: p -> p * scale + offset, monotone on each axis even when
/// rounded, so that the corners of a box go to the corners of a box around the image.
struct Octave {
  std::uint64_t seed;
  double scale;
  Vec3d offset;
  [[nodiscard]] Vec3d map(Vec3d p) const { return p * scale + offset; }
};

Octave octave(const Fbm& noise, int k) {
  const std::uint64_t seed = mix64(noise.seed + static_cast<std::uint64_t>(k) * kHashX);
  // Offsets keep the zeros of the octaves apart: three numbers of 21 bits in [0, 256).
  const std::uint64_t bits = mix64(seed);
  const auto offset = [&](int axis) {
    return static_cast<double>(bits >> (21 * axis) & 0x1fffff) * 0x1p-13;
  };
  return {seed, static_cast<double>(1 << k) / noise.cell, {offset(0), offset(1), offset(2)}};
}

/// The sum over octaves in intervals; `range(k)` is that of n_k.
template <class Range>
Interval sum_octaves(const Fbm& noise, Range range) {
  Interval sum, weights;
  double weight = 1;
  for (int k = 0; k < noise.octaves; ++k) {
    Interval n = range(k);
    if (noise.billow) n = n.lo > 0 ? n : n.hi < 0 ? -n : Interval(0, std::max(-n.lo, n.hi));
    sum = sum + Interval(weight) * n;
    weights = weights + Interval(weight);
    weight *= noise.gain;
  }
  // Weights are positive, so each end of the quotient is a quotient of ends.
  return {round_down(sum.lo / (sum.lo < 0 ? weights.lo : weights.hi)),
          round_up(sum.hi / (sum.hi < 0 ? weights.hi : weights.lo))};
}

}  // namespace

double gradient_noise(std::uint64_t seed, Vec3d p) {
  const Vec3d i(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const Vec3d f = p - i;
  const Cell cell = cell_at(seed, std::int64_t(i.x), std::int64_t(i.y), std::int64_t(i.z));
  std::array<double, 8> slope;
  for (unsigned c = 0; c < 8; ++c) {
    slope[c] = dot(cell.gradients[c], f - Vec3d(c & 1, c >> 1 & 1, c >> 2));
  }
  const double x = fade(f.x), y = fade(f.y), z = fade(f.z);
  return kScale * lerp(lerp(lerp(slope[0], slope[1], x), lerp(slope[2], slope[3], x), y),
                       lerp(lerp(slope[4], slope[5], x), lerp(slope[6], slope[7], x), y), z);
}

Interval gradient_noise_range(std::uint64_t seed, const Box& box) {
  const Vec3d first(std::floor(box.lo.x), std::floor(box.lo.y), std::floor(box.lo.z));
  const Vec3d last(std::floor(box.hi.x), std::floor(box.hi.y), std::floor(box.hi.z));
  if (!(max_component(last - first) < kRangeCells)) return kAll;
  const Vec3l from(first), to(last);
  Interval range{1, -1};
  for (std::int64_t x = from.x; x <= to.x; ++x) {
    for (std::int64_t y = from.y; y <= to.y; ++y) {
      for (std::int64_t z = from.z; z <= to.z; ++z) {
        const Vec3d i(Vec3l{x, y, z});
        const Interval r = range_in_cell(cell_at(seed, x, y, z), max(box.lo - i, Vec3d(0)),
                                         min(box.hi - i, Vec3d(1)));
        range = hull(range, {kScale * r.lo - kRounding, kScale * r.hi + kRounding});
      }
    }
  }
  return {std::max(range.lo, kAll.lo), std::min(range.hi, kAll.hi)};
}

double fbm(const Fbm& noise, Vec3d p) {
  double sum = 0, weights = 0, weight = 1;
  for (int k = 0; k < noise.octaves; ++k) {
    const Octave o = octave(noise, k);
    const double n = gradient_noise(o.seed, o.map(p));
    sum += weight * (noise.billow ? std::abs(n) : n);
    weights += weight;
    weight *= noise.gain;
  }
  return sum / weights;
}

Interval fbm_range(const Fbm& noise, const Box& box) {
  return sum_octaves(noise, [&](int k) {
    const Octave o = octave(noise, k);
    return gradient_noise_range(o.seed, {o.map(box.lo), o.map(box.hi)});
  });
}

Interval fbm_range(const Fbm& noise) {
  return sum_octaves(noise, [](int) { return kAll; });
}

}  // namespace pvol
