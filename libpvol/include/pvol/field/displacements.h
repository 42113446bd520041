// How far a field moves in a frame, on a lattice of its own: look-ups and bounds of them.
#pragma once

#include <vector>

#include "pvol/density/velocity_grid.h"
#include "pvol/field/vector_bricks.h"
#include "pvol/math/box.h"
#include "pvol/math/float4.h"

namespace pvol {

/// Displacements in cells of another lattice, that of the field which they move.
struct Displacements {
  /// Least and largest of each component.
  struct Range {
    Float4 lo{}, hi{};
  };
  /// Ranges over cubes of (8 << level)^3 cells that fill the table's box.
  struct Level {
    Vec3i size;
    std::vector<Range> cubes;
  };

  Affine index_to_cells;  ///< of the moved field's index space, to cells of `bricks`
  VectorBricks bricks;
  std::vector<Level> levels;  ///< from leaves to one cube; none where nothing moves
  float largest = 0;          ///< of all components' absolute values
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
