// Nearly homogeneous parts of a cloud, taken for homogeneous: a biased acceleration whose error has
// a bound.
#pragma once

#include <cstdint>

#include "pvol/bounds/pyramid.h"
#include "pvol/bounds/statistics.h"

namespace pvol {

/// What homogenise() replaced.
struct HomogeneousParts {
  std::uint64_t nodes = 0;
  double volume_share = 0, mass_share = 0;  ///< of all cubes that hold density, and of the mass
  double depth_error = 0;  ///< no ray's optical depth changes by more (THEORY.md, T3.7)
};

/// A pyramid with nodes in which the density counts as constant: their mean over the part of them
/// in the support's box, where walks end, so that the mass stays as it is. Below them there is
/// nothing, and lo = hi = mean, which is no 16-bit code.
struct HomogenisedPyramid {
  Pyramid pyramid;
  NodeMarks constant;  ///< by level and node
  HomogeneousParts parts;
};

/// Replaces the highest nodes in which, along any ray, the optical depth changes by `tolerance` or
/// less: max(hi - mean, mean - lo) times the diagonal. `extinction` per world unit and density;
/// `diagonal` is the world length of a cell's longest diagonal. Requires a tolerance >= 0 and the
/// content of this pyramid.
[[nodiscard]] HomogenisedPyramid homogenise(const Pyramid& pyramid, const PyramidContent& content,
                                            double extinction, double diagonal, double tolerance);

}  // namespace pvol
