// The cubes of space over which an importance is constant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/philox.h"
#include "pvol/bounds/walk.h"
#include "pvol/volume/volume.h"
#include "render/path/instances.h"

namespace pvol::detail {

/// A grid of cubes over the support of one volume, 2^shift of its cells long, or over the places of
/// many, in the world. Those that hold density have a row of their own, from 1 up; row 0 stands for
/// all others.
struct CoarseCells {
  int shift = 3;
  Int4 low{};                       ///< coarse coordinates of the first cube
  Int4 last{};                      ///< and of the last one, from `low`
  Vec3i size;                       ///< cubes along each axis
  std::vector<std::uint32_t> rows;  ///< by cube (x, y, z) at (x * size.y + y) * size.z + z
  std::vector<Vec3i> places;        ///< of each row, from `low`; row 0 unused
  std::vector<double> mass;         ///< integral of mu_t over each row's cube [area of the world]
  std::vector<double> mass_of_volumes{};  ///< of the setup, by number
  Affine to_world{};                      ///< from cells, counted from the octree's origin
  Affine to_cells{};                      ///< its inverse

  [[nodiscard]] std::size_t count() const { return places.size(); }

  /// The row of a cell, counted from the octree's origin, of the support.
  [[nodiscard]] std::uint32_t row(Int4 cell) const {
    const Int4 c = min(max((cell >> shift) - low, splat(0)), last);
    return rows[index({c[0], c[1], c[2]})];
  }
  /// Of a place in the world.
  [[nodiscard]] std::uint32_t row(Vec3d place) const {
    return row(widen(Vec3i(to_cells.point(place))));
  }

  [[nodiscard]] std::size_t index(Vec3i c) const {
    return (std::size_t(c.x) * std::size_t(size.y) + std::size_t(c.y)) * std::size_t(size.z) +
           std::size_t(c.z);
  }

  /// The cube of a row, in cells.
  [[nodiscard]] Box cube(std::size_t row) const;
  /// Around it in the world.
  [[nodiscard]] Box world_cube(std::size_t row) const { return transform(to_world, cube(row)); }
  /// A point of the world, uniform in the cube of a row.
  [[nodiscard]] Vec3d point(std::size_t row, Rng& rng) const;
};

/// Cubes of 2^least_shift cells, 8^3, or of the next power of two with which there are at most 2^18
/// of them. Needs a volume that is not empty.
[[nodiscard]] CoarseCells make_coarse_cells(const Volume& volume, int least_shift = 3);

/// Cubes of the world over all places of the volumes while the shutter is open, aligned with its
/// axes: as small as 8 cells of the finest of them, or twice that and so on, so that at most 2^18
/// hold density. Some volume is not empty.
[[nodiscard]] CoarseCells make_world_cells(std::span<const Volume> volumes,
                                           const Instances& instances);

}  // namespace pvol::detail
