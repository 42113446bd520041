// Exact Euclidean distances on a grid.
#pragma once

#include <vector>

#include "pvol/math/vec.h"

namespace pvol::detail {

/// Squared distance, in steps, from each point of a grid of size.x * size.y * size.z points (x
/// fastest) to the nearest one that is marked; infinite where none is. In parallel over rows; the
/// numbers are integers, exact to 2^24.
/// Based on: Felzenszwalb, Huttenlocher. Distance Transforms of Sampled Functions. 2012.
[[nodiscard]] std::vector<float> squared_distances(const std::vector<std::uint8_t>& marked,
                                                   Vec3i size);

}  // namespace pvol::detail
