// Integrals of the bounds that walks through an octree meet.
#pragma once

#include "pvol/bounds/octree.h"

namespace pvol {

/// Integrals over the support's box of the bounds that walks meet, in mu_t x cells^3.
struct BoundIntegrals {
  double hi = 0, lo = 0;
  /// Look-ups of decomposition per collision that lies as the density does, taking the density to
  /// be in the middle of its bounds.
  [[nodiscard]] double open_share() const { return hi > 0 ? 2 * (hi - lo) / (hi + lo) : 0; }
};
[[nodiscard]] BoundIntegrals integrate_bounds(const Octree& octree);

}  // namespace pvol
