// Bounds as rows: nodes of the pyramid, terminals of the octree, segments of a ray.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"

namespace pvol::python {

/// A cube of cells [lo, lo + edge) of index space, with minorant <= mu_t <= majorant on it.
struct BoundRow {
  std::int64_t lo[3];
  std::int64_t edge;
  double minorant, majorant;  ///< per world unit
};

/// The nodes of a level: 0 has the leaves of 8^3 cells. Throws Error for a level that is not there.
[[nodiscard]] std::vector<BoundRow> nodes_of(const Pyramid& pyramid, std::int64_t level,
                                             double extinction);

/// Where walks stop, in no particular order.
[[nodiscard]] std::vector<BoundRow> terminals_of(const Octree& tree);

}  // namespace pvol::python
