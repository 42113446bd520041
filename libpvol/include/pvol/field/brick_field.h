// The density field as look-ups read it: samples in bricks with an apron, so that the eight corners
// of a cell lie in one brick.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/bounds/walk.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/bounds_excess.h"
#include "pvol/field/tricubic.h"
#include "pvol/math/pages.h"

namespace pvol {

/// Samples along each edge of a field's brick: those that interpolation in its 8 cells reads.
[[nodiscard]] constexpr int field_edge(LookUp look_up) {
  return kLeafEdge + extent_of(look_up).below + extent_of(look_up).above;
}
[[nodiscard]] constexpr int field_samples(LookUp look_up) {
  return field_edge(look_up) * field_edge(look_up) * field_edge(look_up);
}

/// The same for trilinear and nearest look-ups: 8 cells have 9 corners.
inline constexpr int kFieldEdge = field_edge(LookUp::trilinear);
inline constexpr int kFieldSamples = field_samples(LookUp::trilinear);

/// Bricks of n^3 samples of rho, n = 9, or 11 for tricubic look-ups. Sample (i, j, k) of brick b is
/// samples[b * n^3 + (i * n + j) * n + k]; it lies at the brick's lattice point (i, j, k), of
/// tricubic ones at (i - 1, j - 1, k - 1). Brick 0 is all zero. A brick whose samples are all equal
/// serves every cube with that value.
struct BrickField {
  PagedVector<float> samples;
  LookUp look_up = LookUp::trilinear;  ///< trilinear (or nearest), or tricubic

  template <LookUp kLookUp = LookUp::trilinear>
  [[nodiscard]] const float* brick(std::uint32_t b) const {
    return samples.data() + std::size_t(b) * field_samples(kLookUp);
  }
  [[nodiscard]] std::size_t bricks() const {
    return samples.size() / std::size_t(field_samples(look_up));
  }
};

inline constexpr std::uint32_t kZeroBrick = 0;

/// Density at a point of a brick of samples, which may be integers; the point's cell counts modulo
/// the leaf's edge.
/// Trilinear: exact in the samples' convex hull but for rounding of at most 3 ulp of the largest
/// corner; between equal corners the value is exactly theirs. Tricubic: see tricubic.h.
template <LookUp kLookUp, class Sample>
[[nodiscard, gnu::always_inline]] inline float density_in_brick(const Sample* brick,
                                                                const LatticePoint& p) {
  constexpr int kMask = kLeafEdge - 1;
  constexpr int kY = field_edge(kLookUp), kX = kY * kY;
  const Int4 in_leaf = p.cell & kMask;
  const Sample* s = brick + in_leaf[0] * kX + in_leaf[1] * kY + in_leaf[2];
  const Float4 f = p.frac;
  if constexpr (kLookUp == LookUp::nearest) {
    return s[(f[0] < 0.5f ? 0 : kX) + (f[1] < 0.5f ? 0 : kY) + (f[2] < 0.5f ? 0 : 1)];
  } else if constexpr (kLookUp == LookUp::tricubic) {
    return tricubic<kX, kY>(s, f);
  } else {
    const auto lerp = [](float a, float b, float t) { return a + (b - a) * t; };
    const float c00 = lerp(s[0], s[1], f[2]), c01 = lerp(s[kY], s[kY + 1], f[2]);
    const float c10 = lerp(s[kX], s[kX + 1], f[2]);
    const float c11 = lerp(s[kX + kY], s[kX + kY + 1], f[2]);
    return lerp(lerp(c00, c01, f[1]), lerp(c10, c11, f[1]), f[0]);
  }
}

/// Density at a point of the segment with handle `leaf`.
template <LookUp kLookUp>
[[nodiscard]] inline float density(const BrickField& field, const Octree& tree, LeafHandle leaf,
                                   const LatticePoint& p) {
  const std::uint32_t brick = tree.brick_at(leaf, p.cell, kZeroBrick);
  return density_in_brick<kLookUp>(field.brick<kLookUp>(brick), p);
}

/// mu_t at a point of a segment from bricks: scale * rho. The tree's handles name bricks of the
/// field, and both outlive this.
template <LookUp kKind>
struct BrickExtinction {
  static constexpr LookUp kLookUp = kKind;

  const BrickField& field;
  const Octree& tree;
  float scale;

  [[nodiscard]] std::uint32_t brick(const Segment& s, const LatticePoint& p) const {
    return tree.brick_at(s.leaf, p.cell, kZeroBrick);
  }
  [[nodiscard]] float in_brick(std::uint32_t brick, const LatticePoint& p) const {
    return scale * density_in_brick<kKind>(field.brick<kKind>(brick), p);
  }
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return in_brick(brick(s, p), p);
  }
  /// The density at a point of the cube with a handle, without the scale.
  [[nodiscard]] float density(LeafHandle leaf, const LatticePoint& p) const {
    const std::uint32_t b = tree.brick_at(leaf, p.cell, kZeroBrick);
    return density_in_brick<kKind>(field.brick<kKind>(b), p);
  }

  /// mu_t at the corners of a cell of the segment, that of (x, y, z) in {0, 1}^3 at [4x + 2y + z].
  [[nodiscard]] std::array<float, 8> corners(const Segment& s, Int4 cell) const
      requires(kKind != LookUp::tricubic) {
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

struct FieldOptions {
  LookUp look_up = LookUp::trilinear;
  /// The largest factor by which samples may exceed a majorant; above 1, minorants may lie too high
  /// as well, for trackers with weights.
  double most_excess = 1;
  /// Nodes over which the density is the constant lo = hi, whatever the samples (homogenise.h).
  const NodeMarks* constant = nullptr;
  /// Whether to make codes of the samples, for nearest and trilinear look-ups.
  bool codes = false;
};

struct SampleCodes;  // sample_codes.h

/// A field, and the brick of each leaf and uniform cube of its pyramid, by level and node: what
/// `build_octree` links to.
template <class Field>
struct WithLinks {
  Field field;
  std::vector<std::vector<std::uint32_t>> brick_of;
  BoundsExcess excess;
  std::shared_ptr<const SampleCodes> codes{};  ///< null: the options ask for none
};
using FieldWithLinks = WithLinks<BrickField>;

/// The field of a grid for these look-ups.
/// Throws Error where bounds do not hold their samples by more than the options allow, and where
/// there is density outside the support's box.
[[nodiscard]] FieldWithLinks build_field(const VoxelGrid& grid, const Pyramid& pyramid,
                                         const FieldOptions& options = {});

}  // namespace pvol
