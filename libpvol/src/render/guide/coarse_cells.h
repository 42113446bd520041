// The cubes of voxels over which an importance is constant.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/volume/volume.h"

namespace pvol::detail {

/// A grid of cubes of 2^shift cells over the support of a volume. Those that hold density have a
/// row of their own, from 1 up; row 0 stands for all others.
struct CoarseCells {
  int shift = 3;
  Int4 low{};                       ///< coarse coordinates of the first cube
  Int4 last{};                      ///< and of the last one, from `low`
  Vec3i size;                       ///< cubes along each axis
  std::vector<std::uint32_t> rows;  ///< by cube (x, y, z) at (x * size.y + y) * size.z + z
  std::vector<Vec3i> places;        ///< of each row, from `low`; row 0 unused
  std::vector<double> mass;         ///< integral of mu_t over each row's cube [area of the world]

  [[nodiscard]] std::size_t count() const { return places.size(); }

  /// The row of a cell, counted from the octree's origin, of the support.
  [[nodiscard]] std::uint32_t row(Int4 cell) const {
    const Int4 c = min(max((cell >> shift) - low, splat(0)), last);
    return rows[index({c[0], c[1], c[2]})];
  }
  [[nodiscard]] std::size_t index(Vec3i c) const {
    return (std::size_t(c.x) * std::size_t(size.y) + std::size_t(c.y)) * std::size_t(size.z) +
           std::size_t(c.z);
  }
};

/// Cubes of 8^3 cells, or of the next power of two with which there are at most 2^18 of them. Needs
/// a volume that is not empty.
[[nodiscard]] CoarseCells make_coarse_cells(const Volume& volume);

}  // namespace pvol::detail
