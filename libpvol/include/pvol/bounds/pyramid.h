// The scale-free pyramid of density extremes: what pvol-fit computes and a .pvol file stores.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/box.h"

namespace pvol {

/// Interpolation cells along each edge of a finest node (a leaf).
inline constexpr int kLeafEdge = 8;

/// A cloud spans at most 2^24 cells along an axis, so that differences of cells are exact floats.
inline constexpr int kMaxRootLog2 = 24;

/// The origin of a pyramid lies among the 32-bit lattice points.
inline constexpr std::int64_t kMinOrigin = std::numeric_limits<std::int32_t>::min();
inline constexpr std::int64_t kMaxOrigin = std::numeric_limits<std::int32_t>::max();

/// A cube of cells with bounds on the interpolated density over all of it.
struct PyramidNode {
  std::uint64_t code = 0;  ///< Morton code of the cube among cubes of its size: (x, y, z) with x in
                           ///< the lowest bit of each triple, counted from the pyramid's origin
  float lo = 0;            ///< minorant of rho over the closed cube
  float hi = 0;            ///< majorant, > 0
  friend bool operator==(const PyramidNode&, const PyramidNode&) = default;
};

/// Octree of bounds, level by level. Level 0 holds leaves of 8^3 cells, level L cubes of (8 <<
/// L)^3, the last level the root alone (nothing at all where the density is 0 everywhere). Cubes in
/// which the density is 0 throughout are absent. A node whose children are all absent from the
/// level below is uniform: the density has one value v on all of the closed cube, and lo <= v <= hi
/// are the codes next to it (one code where v has a code of its own).
///
/// Invariants, checked by `validate`: codes ascend strictly within a level; 0 <= lo <= hi <= scale,
/// hi > 0; every node below the root level has its parent; a node with children has
/// lo = min over its 8 children (0 for an absent one) and hi = max; no code lies between lo and hi
/// of a uniform node; the root's hi is the scale; the support ends in the outermost leaves. lo and
/// hi are values of the 16-bit code of FORMAT.md (see `encode_down`, `encode_up`), so that bounds
/// built in memory equal bounds read from a file.
struct Pyramid {
  Vec3l origin;      ///< index-space cell at the root's low corner; a multiple of 8
  float scale = 0;   ///< unit of the 16-bit code: the largest sample
  Vec3l support_lo;  ///< tight box of cells with density above 0: [support_lo, support_hi)
  Vec3l support_hi;
  /// Bounds and support hold for this, and see `holds_for`: trilinear, tricubic or procedural.
  LookUp look_up = LookUp::trilinear;
  std::vector<std::vector<PyramidNode>> levels;

  [[nodiscard]] bool empty() const { return levels.empty(); }
  /// log2 of the root's edge in cells.
  [[nodiscard]] int root_log2() const { return int(levels.size()) + 2; }
  /// The support in index space.
  [[nodiscard]] Box support() const { return {Vec3d(support_lo), Vec3d(support_hi)}; }
  friend bool operator==(const Pyramid&, const Pyramid&) = default;
};

/// Whether bounds that were made for an interpolation hold for another one. All bound every sample
/// in reach of the trilinear interpolant and so hold for that, and for the nearest one.
[[nodiscard]] constexpr bool holds_for(LookUp made, LookUp wanted) {
  return wanted == made || wanted == LookUp::nearest || wanted == LookUp::trilinear;
}

/// Bounds of the interpolants of `grid`, from all samples in each leaf's reach, in parallel; the
/// result does not depend on the number of threads. `trilinear`, which `nearest` is short for,
/// takes 9^3 samples of a leaf (THEORY.md, T1.1), `tricubic` 11^3, and its support is a cell wider
/// on each side (T1.4). Throws Error for `procedural`, where the support spans more than 2^24
/// cells, or where it would take more than `max_leaves` leaves (a few bytes can describe a tile of
/// 4096^3 samples).
[[nodiscard]] Pyramid build_pyramid(const VoxelGrid& grid, LookUp look_up = LookUp::trilinear,
                                    std::uint64_t max_leaves = std::uint64_t(1) << 26);

/// Marks on nodes, by level and node; not std::vector<bool>, so that threads may set them.
using NodeMarks = std::vector<std::vector<char>>;

/// The children of node i of `level`, from index begin to end of the level below.
struct NodeRange {
  std::size_t begin = 0, end = 0;
  [[nodiscard]] bool empty() const { return begin == end; }
};
[[nodiscard]] NodeRange children(const Pyramid& pyramid, std::size_t level, std::size_t i);

/// Whether node i of `level` is a uniform cube: above the leaves, and without children.
[[nodiscard]] bool is_uniform(const Pyramid& pyramid, std::size_t level, std::size_t i);

/// Index of the node with this code in a level, if present.
[[nodiscard]] std::optional<std::size_t> find(const std::vector<PyramidNode>& level,
                                              std::uint64_t code);

/// Builds the levels above level 0 and the uniform nodes already placed above it: parents get the
/// extremes of their children. Used by the builder and by readers, which store no derived bounds.
void complete_levels(Pyramid& pyramid);

/// Nothing if all invariants hold, else a sentence about the first that does not.
[[nodiscard]] std::optional<std::string> validate(const Pyramid& pyramid);

/// Morton code of cube coordinates below 2^21, and back.
[[nodiscard]] std::uint64_t morton_encode(Vec3<std::uint32_t> v);
[[nodiscard]] Vec3<std::uint32_t> morton_decode(std::uint64_t code);

/// The 16-bit code of a bound v relative to `scale` (FORMAT.md, "Bounds"): an unsigned float of 5
/// exponent and 11 mantissa bits, with subnormals. `decode` is an exact product rounded to float, 0
/// for code 0 and the scale for kTopCode; it never falls as the code rises. `encode_down` is the
/// largest code with decode(code) <= v, `encode_up` the smallest with decode(code) >= v: for v
/// above 2^-30 scale, and a scale of 2^-96 or more, both decode to within a factor 1 + 2^-11 +
/// 2^-23 of v. Requires 0 <= v <= scale < inf and code <= kTopCode.
inline constexpr std::uint16_t kTopCode = 31 << 11;
[[nodiscard]] std::uint16_t encode_down(float v, float scale);
[[nodiscard]] std::uint16_t encode_up(float v, float scale);
[[nodiscard]] float decode(std::uint16_t code, float scale);

}  // namespace pvol
