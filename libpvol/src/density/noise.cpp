#include "pvol/density/noise.h"

#include <array>
#include <cmath>

#include "density/octave.h"

namespace pvol {

using detail::kGradients;
using detail::kHashX;
using detail::kHashY;
using detail::kHashZ;
using detail::kIndexShift;
using detail::kNoiseScale;
using detail::Octave;
using detail::octave;

namespace {

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

// Along one axis with fraction f and weight S = fade(f), a pair of corners with the components a
// and b of their gradients adds a (1 - S) f - b S (1 - f) to the noise, before it is weighted along
// the other axes. The components are -1, 0 or 1, so it is one of nine functions of f:
//   near(f) = (1 - S) f rises to its one maximum at kNearPeak and falls, far(f) = near(1 - f),
//   near + far rises to f = 1/2 and falls, near - far = f - S is monotone between its two extremes,
// and those with the other sign. Their ranges over an interval follow from its ends and the
// extremes inside.
constexpr double kNearPeak = 0.39812569987582624;        // 1 - S = f S'
constexpr double kDifferencePeak = 0.24033518882038593;  // S' = 1

/// Ranges of a near(f) - b far(f): index 3 (a + 1) + b + 1.
using PairRanges = std::array<Interval, 9>;

PairRanges pair_ranges(Interval f) {
  const auto near = [](double x) { return (1 - fade(x)) * x; };
  const auto far = [](double x) { return fade(x) * (1 - x); };
  const auto over = [f](auto function, std::initializer_list<double> extremes) {
    Interval r = hull(function(f.lo), function(f.hi));
    for (const double x : extremes) {
      if (f.contains(x)) r = hull(r, function(x));
    }
    return r;
  };
  const Interval n = over(near, {kNearPeak}), m = over(far, {1 - kNearPeak});
  const Interval sum = over([&](double x) { return near(x) + far(x); }, {0.5});
  const Interval difference =
      over([&](double x) { return near(x) - far(x); }, {kDifferencePeak, 1 - kDifferencePeak});
  return {-difference, -n, -sum, m, 0, -m, sum, n, difference};
}

/// What a layer of cells across one axis has in common: fractions in one interval.
struct Layer {
  Interval weight;
  PairRanges pairs;
};

/// For a box that reaches from `lo` to `hi` on the axis, in the cell from `first` to first + 1.
Layer layer(double first, double lo, double hi) {
  const Interval f{std::max(lo - first, 0.0), std::min(hi - first, 1.0)};
  return {{fade(f.lo), fade(f.hi)}, pair_ranges(f)};
}

/// Noise in the part of a cell that lies in three layers, but for rounding and the scale: for each
/// axis the pairs of corners along it, weighted along the two others.
Interval range_in_cell(const Cell& cell, const std::array<const Layer*, 3>& layers) {
  Interval total;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto pair = [&](unsigned corner) {
      const double a = cell.gradients[corner][int(axis)];
      const double b = cell.gradients[corner | 1u << axis][int(axis)];
      return layers[axis]->pairs[std::size_t(3 * (int(a) + 1) + int(b) + 1)];
    };
    const auto row = [&](unsigned corner) {
      return lerp(pair(corner), pair(corner | 1u << u), layers[u]->weight);
    };
    const Interval part = lerp(row(0), row(1u << v), layers[v]->weight);
    total = {total.lo + part.lo, total.hi + part.hi};
  }
  return total;
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
  return kNoiseScale * lerp(lerp(lerp(slope[0], slope[1], x), lerp(slope[2], slope[3], x), y),
                            lerp(lerp(slope[4], slope[5], x), lerp(slope[6], slope[7], x), y), z);
}

Interval gradient_noise_range(std::uint64_t seed, const Box& box) {
  const Vec3d first(std::floor(box.lo.x), std::floor(box.lo.y), std::floor(box.lo.z));
  const Vec3d last(std::floor(box.hi.x), std::floor(box.hi.y), std::floor(box.hi.z));
  if (!(max_component(last - first) < kRangeCells)) return kAll;
  const Vec3l from(first), count = Vec3l(last) - from + Vec3l(1);
  std::array<std::array<Layer, kRangeCells>, 3> layers;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < count[axis]; ++i) {
      layers[std::size_t(axis)][std::size_t(i)] =
          layer(first[axis] + i, box.lo[axis], box.hi[axis]);
    }
  }
  Interval range{1, -1};
  for (std::int64_t x = 0; x < count.x; ++x) {
    for (std::int64_t y = 0; y < count.y; ++y) {
      for (std::int64_t z = 0; z < count.z; ++z) {
        const Interval r = range_in_cell(
            cell_at(seed, from.x + x, from.y + y, from.z + z),
            {&layers[0][std::size_t(x)], &layers[1][std::size_t(y)], &layers[2][std::size_t(z)]});
        range = hull(range, {kNoiseScale * r.lo - kRounding, kNoiseScale * r.hi + kRounding});
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
