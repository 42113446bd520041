// The least and the largest of samples, and where those above 0 are.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
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
  // By bits, which of samples above 0 alone are set beside that of the sign: of two samples at once,
  // and without branches.
  constexpr int kPairs = kBrickEdge / 2;
  constexpr std::uint64_t kWithoutSigns = 0x7fffffff'7fffffff;
  std::array<std::uint64_t, kPairs> any{};     // of all rows
  unsigned planes = 0, rows = 0, columns = 0;  // bit i: any in the i-th along x, y, z
  for (int i = 0; i < kBrickEdge; ++i) {
    for (int j = 0; j < kBrickEdge; ++j) {
      std::array<std::uint64_t, kPairs> row;
      std::memcpy(row.data(), brick.values + (i * kBrickEdge + j) * kBrickEdge, sizeof row);
      std::uint64_t in_row = 0;
      for (std::size_t k = 0; k < kPairs; ++k) in_row |= row[k], any[k] |= row[k];
      const auto filled = unsigned((in_row & kWithoutSigns) != 0);
      rows |= filled << j;
      planes |= filled << i;
    }
  }
  if (planes == 0) return {};
  std::array<std::uint32_t, kBrickEdge> in_columns;
  std::memcpy(in_columns.data(), any.data(), sizeof any);
  for (int k = 0; k < kBrickEdge; ++k) {
    columns |= unsigned((in_columns[std::size_t(k)] & std::uint32_t(kWithoutSigns)) != 0) << k;
  }
  const auto low = [](unsigned bits) { return std::countr_zero(bits); };
  const auto high = [](unsigned bits) { return std::bit_width(bits) - 1; };
  const Vec3l origin(brick.origin);
  return {origin + Vec3l(low(planes), low(rows), low(columns)),
          origin + Vec3l(high(planes), high(rows), high(columns))};
}

}  // namespace pvol::detail
