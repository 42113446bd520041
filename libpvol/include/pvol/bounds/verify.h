// Bounds checked against the samples that they are of, one by one: what a loader refuses as a whole
// is named here cube by cube.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"

namespace pvol {

/// A cube whose bounds do not hold.
struct WrongBound {
  enum class Kind {
    leaf,     ///< samples beyond [lo, hi]
    uniform,  ///< the same, or different samples, in a cube that says it holds one value
    missing,  ///< density in a place that the pyramid holds to be empty
  };
  Kind kind = Kind::leaf;
  int depth = 0;                       ///< octree level, 0 is the root
  Vec3l lo_cell, hi_cell;              ///< the cube in index space: cells [lo_cell, hi_cell)
  float stored_lo = 0, stored_hi = 0;  ///< 0 for a missing one
  float found_lo = 0, found_hi = 0;    ///< of the samples in its reach

  /// How far off the worse of the two bounds is: (found_hi - stored_hi) / found_hi, which is 0.1
  /// for a majorant 10 % too low, or (stored_lo - found_lo) / stored_lo.
  [[nodiscard]] double off() const;
};

/// Density outside the box at which walks end. In cells, half open.
struct WrongSupport {
  Vec3l stored_lo, stored_hi;
  Vec3l found_lo, found_hi;  ///< box of the cells with density above 0
};

struct BoundsCheck {
  std::uint64_t leaves = 0, uniform = 0;  ///< cubes that were checked
  std::vector<WrongBound> wrong;          ///< all of them, the worst first
  std::optional<WrongSupport> support;
  [[nodiscard]] bool holds() const { return wrong.empty() && !support; }
};

/// Compares every leaf and uniform cube with all samples in its reach, and every sample above 0
/// with the cubes and the box that have to be around its cells. In parallel; the same for any
/// number of threads. The reach is that of the pyramid's interpolation, which never leaves the
/// range of the samples that it reads, so that bounds of samples are bounds of the density
/// (THEORY.md, T1.1).
[[nodiscard]] BoundsCheck verify_bounds(const VoxelGrid& grid, const Pyramid& pyramid);

/// The part of it that is about places instead of bounds, and quick: no cell with density lies
/// outside all cubes or the box, and no uniform cube holds more than one value.
[[nodiscard]] BoundsCheck verify_cover(const VoxelGrid& grid, const Pyramid& pyramid);

}  // namespace pvol
