// The least and the largest of samples, and where those above 0 are.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "pvol/density/voxel_grid.h"

namespace pvol::detail {

/// Least and largest of samples, which are never negative: their bits order as their values do, and
/// extremes of integers vectorise where those of floats may not.
struct SampleRange {
  std::int32_t lo_bits = std::numeric_limits<std::int32_t>::max();
  std::int32_t hi_bits = 0;

  SampleRange() = default;
  SampleRange(const float* samples, int count) { add(samples, count); }

  void add(const float* samples, int count) {
    for (int i = 0; i < count; ++i) {
      const auto bits = std::bit_cast<std::int32_t>(samples[i]);
      lo_bits = std::min(lo_bits, bits);
      hi_bits = std::max(hi_bits, bits);
    }
  }
  void add(const SampleRange& other) {
    lo_bits = std::min(lo_bits, other.lo_bits);
    hi_bits = std::max(hi_bits, other.hi_bits);
  }
  [[nodiscard]] float lo() const { return std::max(0.0f, std::bit_cast<float>(lo_bits)); }
  [[nodiscard]] float hi() const { return std::bit_cast<float>(hi_bits); }
};

/// The lattice points of samples above 0, lo to hi, in 64 bits: extents of hostile files overflow
/// 32.
struct PointBox {
  Vec3l lo{std::numeric_limits<std::int64_t>::max()};
  Vec3l hi{std::numeric_limits<std::int64_t>::min()};

  [[nodiscard]] bool empty() const { return lo.x > hi.x; }
  void add(Vec3l a, Vec3l b) { lo = min(lo, a), hi = max(hi, b); }
  void add(const PointBox& b) { add(b.lo, b.hi); }
  [[nodiscard]] bool contains(const PointBox& b) const {
    return min(lo, b.lo) == lo && max(hi, b.hi) == hi;
  }
};

[[nodiscard]] inline PointBox box_of(const Brick& brick) {
  unsigned planes = 0, rows = 0, columns = 0;  // bit i: any in the i-th along x, y, z
  for (int i = 0; i < kBrickEdge; ++i) {
    for (int j = 0; j < kBrickEdge; ++j) {
      const float* const row = brick.values + (i * kBrickEdge + j) * kBrickEdge;
      unsigned in_row = 0;
      for (int k = 0; k < kBrickEdge; ++k) in_row |= unsigned(row[k] > 0) << k;
      columns |= in_row;
      rows |= unsigned(in_row != 0) << j;
      planes |= unsigned(in_row != 0) << i;
    }
  }
  if (columns == 0) return {};
  const auto low = [](unsigned bits) { return std::countr_zero(bits); };
  const auto high = [](unsigned bits) { return std::bit_width(bits) - 1; };
  const Vec3l origin(brick.origin);
  return {origin + Vec3l(low(planes), low(rows), low(columns)),
          origin + Vec3l(high(planes), high(rows), high(columns))};
}

}  // namespace pvol::detail
