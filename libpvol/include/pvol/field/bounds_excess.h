// How far bounds fail to hold.
#pragma once

#include <cstdint>

#include "pvol/math/box.h"

namespace pvol {

/// Bounds that do not hold for the samples.
struct BoundsExcess {
  std::uint64_t nodes = 0;  ///< leaves and uniform cubes with a sample outside their bounds
  double factor = 1;        ///< largest sample over majorant among them, at least 1
  Box worst;                ///< the index-space cube with that factor; empty for no node
};

}  // namespace pvol
