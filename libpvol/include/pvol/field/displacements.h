// How far a field moves in a frame, on a lattice of its own: look-ups and bounds of them.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/density/velocity_grid.h"
#include "pvol/math/box.h"
#include "pvol/math/lanes.h"

namespace pvol {

/// Displacements in cells of another lattice, that of the field which they move; trilinear between
/// samples and 0 outside. Leaves of 8^3 cells have bricks of 9^3 samples, found in a table.
struct Displacements {
  static constexpr int kEdge = 9;
  static constexpr int kSamples = kEdge * kEdge * kEdge;

  /// Least and largest of each component.
  struct Range {
    Float4 lo{}, hi{};
  };
  /// Ranges over cubes of (8 << level)^3 cells that fill the table's box.
  struct Level {
    Vec3i size;
    std::vector<Range> cubes;
  };

  Affine
      index_to_cells;  ///< of the moved field's index space, to cells from the table's low corner
  Vec3i leaves{0, 0, 0};                ///< size of the table
  std::vector<std::uint32_t> brick_of;  ///< of leaf (x, y, z) at [(x * size.y + y) * size.z + z]
  std::vector<Float4> samples;          ///< brick 0 is all zero
  std::vector<Level> levels;            ///< from leaves to one cube; none where nothing moves
  float largest = 0;                    ///< of all components' absolute values

  /// At a place in cells of this lattice.
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

/// Of a field whose index space `index_to_world` leads to the space of the velocities: what they
/// move it in `seconds`, which may be negative. Throws Error for a table of more than 2^24 leaves
/// and for displacements beyond 2^20 cells.
[[nodiscard]] Displacements make_displacements(const VelocityGrid& velocity,
                                               const Affine& index_to_world, double seconds);

/// Bounds of the displacements over a box of the moved field's index space: of all samples that
/// look-ups in it read where it is small, else of those in cubes around it.
[[nodiscard]] Displacements::Range range_over(const Displacements& d, const Box& index);

}  // namespace pvol
