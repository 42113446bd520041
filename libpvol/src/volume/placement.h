// Where a volume lies in the world.
#pragma once

#include <cstddef>
#include <string>

#include "pvol/error.h"
#include "pvol/math/affine.h"
#include "pvol/math/box.h"

namespace pvol::detail {

/// Length in the world of a step along an axis.
[[nodiscard]] double column_length(const Affine& to_world, int axis);

/// The length of the longest diagonal of a cell in the world.
[[nodiscard]] double cell_diagonal(const Affine& to_world);

/// Positions go from world to cells in double; what they lose is a few ulp of the largest
/// coordinate, seen in cells (THEORY.md, T1.3). Throws Error for maps that are singular, out of
/// range or lose more than 1/1000 of a cell.
void check_placement(const Affine& to_world, const Affine& to_cells, const Box& world_box);

/// Calls check(), and names the place in its Error where there are instances.
template <class Check>
void naming_place(std::size_t place, std::size_t instances, const Check& check) {
  try {
    check();
  } catch (const Error& e) {
    if (instances == 0) throw;
    throw Error("instance " + std::to_string(place + 1) + ": " + e.what());
  }
}

}  // namespace pvol::detail
