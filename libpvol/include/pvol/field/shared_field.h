// The density field over samples that stay where somebody has them, in leaves of a tree or in an
// array: no brick is copied, and look-ups give what they give in bricks, to the last bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>

#include "pvol/field/brick_field.h"

namespace pvol {

/// Where the samples are that interpolation in the 8^3 cells of a leaf reads: its own 8^3, in the
/// order of Brick::values, at block[0], and those of the leaf above by (x, y, z) in {0, 1}^3 at
/// block[4x + 2y + z]. Where there are no samples, a block of one value: 0, or a tile's.
struct LeafSamples {
  std::array<const float*, 8> block;
};

/// The same 9^3 samples in an array: that of the leaf's lattice point (x, y, z), 0 <= x, y, z <= 8,
/// is first[x * stride[0] + y * stride[1] + z * stride[2]].
struct ArraySamples {
  const float* first;
  std::array<std::ptrdiff_t, 3> stride;
};

/// The bricks of a field for nearest and trilinear look-ups, by number, all in leaves or all in an
/// array. Brick 0 is all zero.
struct SharedField {
  PagedVector<LeafSamples> leaves;
  PagedVector<ArraySamples> windows;  ///< empty where there are leaves
  /// Samples of its own: blocks of one value, and what is at the faces of an array.
  std::deque<PagedVector<float>> own;
  std::shared_ptr<const void> owner{};  ///< of the others; null: a caller
  std::uint64_t shared_bytes = 0;       ///< which they take

  [[nodiscard]] bool in_leaves() const { return !leaves.empty(); }
  [[nodiscard]] std::size_t bricks() const { return leaves.size() + windows.size(); }
  /// Of all that look-ups read, and of what is read of others.
  [[nodiscard]] std::uint64_t bytes() const;
};

namespace detail {

/// Where the samples at the corners of a cell are, which counts modulo the leaf's edge: that of
/// (x, y, z) in {0, 1}^3 at [4x + 2y + z].
[[nodiscard, gnu::always_inline]] inline std::array<const float*, 8> corner_places(
    const LeafSamples& leaf, Int4 cell) {
  constexpr int kMask = kBrickEdge - 1;
  const Int4 low = cell & kMask, high = (low + 1) & kMask, next = (low + 1) >> 3;
  const std::array<int, 2> x{low[0] * 64, high[0] * 64}, y{low[1] * 8, high[1] * 8},
      z{low[2], high[2]};
  const std::array<int, 2> bx{0, next[0] * 4}, by{0, next[1] * 2}, bz{0, next[2]};
  std::array<const float*, 8> c;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t ix = i >> 2, iy = i >> 1 & 1, iz = i & 1;
    c[i] = leaf.block[std::size_t(bx[ix] + by[iy] + bz[iz])] + (x[ix] + y[iy] + z[iz]);
  }
  return c;
}

/// The samples at the corners of a cell, in the same order.
[[nodiscard, gnu::always_inline]] inline std::array<float, 8> corners_of(const LeafSamples& leaf,
                                                                         Int4 cell) {
  const std::array<const float*, 8> at = corner_places(leaf, cell);
  return {*at[0], *at[1], *at[2], *at[3], *at[4], *at[5], *at[6], *at[7]};
}
[[nodiscard, gnu::always_inline]] inline std::array<float, 8> corners_of(const ArraySamples& window,
                                                                         Int4 cell) {
  const Int4 at = cell & (kLeafEdge - 1);
  const auto [sx, sy, sz] = window.stride;
  const float* const s = window.first + at[0] * sx + at[1] * sy + at[2] * sz;
  return {s[0], s[sz], s[sy], s[sy + sz], s[sx], s[sx + sz], s[sx + sy], s[sx + sy + sz]};
}

}  // namespace detail

/// Density at a point of a leaf, as density_in_brick.
template <LookUp kLookUp, class Samples>
[[nodiscard, gnu::always_inline]] inline float density_among(const Samples& samples,
                                                             const LatticePoint& p) {
  static_assert(has_closed_form(kLookUp));
  const std::array<float, 8> c = detail::corners_of(samples, p.cell);
  const Float4 f = p.frac;
  if constexpr (kLookUp == LookUp::nearest) {
    return c[(f[0] < 0.5f ? 0u : 4u) + (f[1] < 0.5f ? 0u : 2u) + (f[2] < 0.5f ? 0u : 1u)];
  } else {
    const auto lerp = [](float a, float b, float t) { return a + (b - a) * t; };
    const float c00 = lerp(c[0], c[1], f[2]), c01 = lerp(c[2], c[3], f[2]);
    const float c10 = lerp(c[4], c[5], f[2]), c11 = lerp(c[6], c[7], f[2]);
    return lerp(lerp(c00, c01, f[1]), lerp(c10, c11, f[1]), f[0]);
  }
}

/// mu_t at a point of a segment, as BrickExtinction, where some volumes share samples and others
/// may have bricks. The tree's handles name bricks of the field, and both outlive this.
template <LookUp kKind>
struct SharedExtinction {
  static constexpr LookUp kLookUp = kKind;

  const SharedField* shared;  ///< null: it has bricks
  const BrickField* bricks;   ///< null: it shares
  const Octree& tree;
  float scale;

  [[nodiscard]] std::uint32_t brick(const Segment& s, const LatticePoint& p) const {
    return tree.brick_at(s.leaf, p.cell, kZeroBrick);
  }
  [[nodiscard]] float in_brick(std::uint32_t b, const LatticePoint& p) const {
    return scale * density_in(b, p);
  }
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return in_brick(brick(s, p), p);
  }
  /// The density at a point of the cube with a handle, without the scale.
  [[nodiscard]] float density(LeafHandle leaf, const LatticePoint& p) const {
    return density_in(tree.brick_at(leaf, p.cell, kZeroBrick), p);
  }
  /// As BrickExtinction::corners.
  [[nodiscard]] std::array<float, 8> corners(const Segment& s, Int4 cell) const {
    if (shared == nullptr) return BrickExtinction<kKind>{*bricks, tree, scale}.corners(s, cell);
    const std::uint32_t b = tree.brick_at(s.leaf, cell, kZeroBrick);
    std::array<float, 8> c = shared->in_leaves() ? detail::corners_of(shared->leaves[b], cell)
                                                 : detail::corners_of(shared->windows[b], cell);
    for (float& v : c) v *= scale;
    return c;
  }

 private:
  [[nodiscard]] float density_in(std::uint32_t b, const LatticePoint& p) const {
    if (shared == nullptr) return density_in_brick<kKind>(bricks->brick(b), p);
    return shared->in_leaves() ? density_among<kKind>(shared->leaves[b], p)
                               : density_among<kKind>(shared->windows[b], p);
  }
};

/// As build_field, but for the copies. The samples are those of the grid's bricks, which their
/// owner or, where it is null, the caller keeps; or those of an array that holds the same samples,
/// which the caller keeps. For nearest and trilinear look-ups without constant nodes. Throws Error
/// likewise.
[[nodiscard]] WithLinks<SharedField> build_shared_field(const VoxelGrid& grid,
                                                        const Pyramid& pyramid,
                                                        const FieldOptions& options,
                                                        const DenseArray* array = nullptr);

}  // namespace pvol
