// The density field as look-ups read it: samples in bricks with an apron, so that the eight corners
// of a cell lie in one brick.
#pragma once

#include <array>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/bounds/walk.h"
#include "pvol/medium/voxel_grid.h"

namespace pvol {

/// Samples along each edge of a field's brick: 8 cells have 9 corners.
inline constexpr int kFieldEdge = kLeafEdge + 1;
inline constexpr int kFieldSamples = kFieldEdge * kFieldEdge * kFieldEdge;

/// Bricks of 9^3 samples of rho, sample (i, j, k) of brick b at samples[b * 729 + (i * 9 + j) * 9 +
/// k]. Brick 0 is all zero. A brick whose samples are all equal serves every cube with that value.
struct BrickField {
  std::vector<float> samples;

  [[nodiscard]] const float* brick(std::uint32_t b) const {
    return samples.data() + std::size_t(b) * kFieldSamples;
  }
};

inline constexpr std::uint32_t kZeroBrick = 0;

/// Density at a point of a brick; the point's cell counts modulo the leaf's edge.
/// Trilinear: exact in the samples' convex hull but for rounding of at most 3 ulp of the largest
/// corner; between equal corners the value is exactly theirs.
template <Interpolation kInterpolation>
[[nodiscard, gnu::always_inline]] inline float density_in_brick(const float* brick,
                                                                const LatticePoint& p) {
  constexpr int kMask = kLeafEdge - 1;
  constexpr int kX = kFieldEdge * kFieldEdge, kY = kFieldEdge;
  const Int4 in_leaf = p.cell & kMask;
  const float* s = brick + in_leaf[0] * kX + in_leaf[1] * kY + in_leaf[2];
  const Float4 f = p.frac;
  if constexpr (kInterpolation == Interpolation::nearest) {
    return s[(f[0] < 0.5f ? 0 : kX) + (f[1] < 0.5f ? 0 : kY) + (f[2] < 0.5f ? 0 : 1)];
  } else {
    const auto lerp = [](float a, float b, float t) { return a + (b - a) * t; };
    const float c00 = lerp(s[0], s[1], f[2]), c01 = lerp(s[kY], s[kY + 1], f[2]);
    const float c10 = lerp(s[kX], s[kX + 1], f[2]);
    const float c11 = lerp(s[kX + kY], s[kX + kY + 1], f[2]);
    return lerp(lerp(c00, c01, f[1]), lerp(c10, c11, f[1]), f[0]);
  }
}

/// Density at a point of the segment with handle `leaf`.
template <Interpolation kInterpolation>
[[nodiscard]] inline float density(const BrickField& field, const Octree& tree, LeafHandle leaf,
                                   const LatticePoint& p) {
  return density_in_brick<kInterpolation>(field.brick(tree.brick_at(leaf, p.cell, kZeroBrick)), p);
}

/// mu_t at a point of a segment from bricks: scale * rho. The tree's handles name bricks of the
/// field, and both outlive this.
template <Interpolation kInterp>
struct BrickExtinction {
  static constexpr Interpolation kInterpolation = kInterp;

  const BrickField& field;
  const Octree& tree;
  float scale;

  [[nodiscard]] std::uint32_t brick(const Segment& s, const LatticePoint& p) const {
    return tree.brick_at(s.leaf, p.cell, kZeroBrick);
  }
  [[nodiscard]] float in_brick(std::uint32_t brick, const LatticePoint& p) const {
    return scale * density_in_brick<kInterp>(field.brick(brick), p);
  }
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return in_brick(brick(s, p), p);
  }

  /// mu_t at the corners of a cell of the segment, that of (x, y, z) in {0, 1}^3 at [4x + 2y + z].
  [[nodiscard]] std::array<float, 8> corners(const Segment& s, Int4 cell) const {
    const Int4 at = cell & (kLeafEdge - 1);
    const float* const brick_samples = field.brick(tree.brick_at(s.leaf, cell, kZeroBrick));
    std::array<float, 8> c;
    for (int i = 0; i < 8; ++i) {
      const int x = at[0] + (i >> 2), y = at[1] + (i >> 1 & 1), z = at[2] + (i & 1);
      c[std::size_t(i)] = scale * brick_samples[(x * kFieldEdge + y) * kFieldEdge + z];
    }
    return c;
  }
};

/// The field of a grid, and the brick of each leaf and uniform cube of its pyramid, by level and
/// node: what `build_octree` links to.
struct FieldWithLinks {
  BrickField field;
  std::vector<std::vector<std::uint32_t>> brick_of;
};
/// Throws Error where a leaf's bounds do not hold its samples.
[[nodiscard]] FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid);

}  // namespace pvol
