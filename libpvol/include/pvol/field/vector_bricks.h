// Up to four numbers at each sample of a lattice, looked up at once.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/float4.h"

namespace pvol {

/// Vectors that are trilinear between samples and 0 outside. Leaves of 8^3 cells have bricks of 9^3
/// samples, found in a table.
struct VectorBricks {
  static constexpr int kEdge = 9;
  static constexpr int kSamples = kEdge * kEdge * kEdge;

  Vec3i leaves{0, 0, 0};                ///< size of the table; (0, 0, 0): all is 0
  std::vector<std::uint32_t> brick_of;  ///< of leaf (x, y, z) at [(x * size.y + y) * size.z + z]
  std::vector<Float4> samples;          ///< brick 0 is all zero

  /// At a place in cells from the table's low corner; between equal corners exactly theirs.
  [[nodiscard]] Float4 at(Vec3d cells) const {
    const Vec3d end = Vec3d(leaves) * 8.0;
    if (!(cells.x >= 0 && cells.x < end.x && cells.y >= 0 && cells.y < end.y && cells.z >= 0 &&
          cells.z < end.z)) {
      return Float4{};
    }
    const Vec3i cell(cells);
    const Vec3f f(cells - Vec3d(cell));
    const Float4* s = brick(brick_at({cell.x >> 3, cell.y >> 3, cell.z >> 3})) +
                      ((cell.x & 7) * kEdge + (cell.y & 7)) * kEdge + (cell.z & 7);
    constexpr int kY = kEdge, kX = kEdge * kEdge;
    const auto lerp = [](Float4 a, Float4 b, float t) { return a + (b - a) * splat(t); };
    const Float4 c00 = lerp(s[0], s[1], f.z), c01 = lerp(s[kY], s[kY + 1], f.z);
    const Float4 c10 = lerp(s[kX], s[kX + 1], f.z), c11 = lerp(s[kX + kY], s[kX + kY + 1], f.z);
    return lerp(lerp(c00, c01, f.y), lerp(c10, c11, f.y), f.x);
  }

  [[nodiscard]] std::uint32_t brick_at(Vec3i leaf) const {
    return brick_of[(std::size_t(leaf.x) * std::size_t(leaves.y) + std::size_t(leaf.y)) *
                        std::size_t(leaves.z) +
                    std::size_t(leaf.z)];
  }
  [[nodiscard]] const Float4* brick(std::uint32_t b) const {
    return samples.data() + std::size_t(b) * kSamples;
  }
};

/// The leaves, in units of 8 cells, in which a component may differ from 0: [lo, hi).
struct LeafBox {
  Vec3i lo{1 << 30}, hi{-(1 << 30)};

  void add(Vec3i origin, int edge);
  [[nodiscard]] bool empty() const { return lo.x >= hi.x; }
  /// Of the table over them.
  [[nodiscard]] double count() const;
};

/// Grids on one lattice, a component each.
using Components = std::span<const VoxelGrid* const>;

/// Around all leaves in which some component has samples.
[[nodiscard]] LeafBox leaf_box(Components grids);

/// The most leaves that a table may have.
inline constexpr double kMostVectorLeaves = 1 << 24;

/// The bricks of two to four components over a box of leaves that is not empty, of at most
/// kMostVectorLeaves: what `value` makes of the samples, 0 for the components that are not there.
/// value(0) is 0; it is called from several threads.
[[nodiscard]] VectorBricks make_vector_bricks(Components grids, const LeafBox& box,
                                              const std::function<Float4(Float4)>& value);

}  // namespace pvol
