// A support as a fit sees it: points that no dent may cover, and empty cells worth removing.
#pragma once

#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"
#include "shell/fit/points.h"

namespace pvol::detail {

/// Cells of a support, merged 2^log2 along each axis until its box is small enough to be held
/// densely. Everything but `log2` is in the shell's frame.
struct SupportLattice {
  int log2 = 0;            ///< of a merged cell's edge in cells
  double edge = 0;         ///< of a merged cell
  Points boundary;         ///< vertices of occupied cells that also touch an empty cell, for small
                           ///< supports middles of edges and faces as well; where cells are merged,
                           ///< corners of the box of what is occupied in each. And some
                           ///< points inside the support
  Points empty;            ///< centres of merged cells in the box without any occupied cell
  std::vector<float> gap;  ///< distance from each of these to the nearest occupied merged cell
  double volume = 0;       ///< of the occupied cells
};

[[nodiscard]] SupportLattice make_lattice(const Support& support);

}  // namespace pvol::detail
