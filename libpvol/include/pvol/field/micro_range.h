// What micro-bounds say of a cell.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/math/float4.h"

namespace pvol {

/// lo <= rho <= hi.
struct DensityRange {
  float lo, hi;
};

[[nodiscard]] constexpr std::size_t micro_cubes_per_brick(int edge) {
  return std::size_t(kLeafEdge / edge) * std::size_t(kLeafEdge / edge) *
         std::size_t(kLeafEdge / edge);
}

/// The bounds of the cube that holds a cell, counted from the octree's origin. kEdge is
/// bounds.edge.
template <int kEdge>
[[nodiscard, gnu::always_inline]] inline DensityRange micro_range(const MicroBounds& bounds,
                                                                  std::uint32_t brick, Int4 cell) {
  static_assert(kEdge == 1 || kEdge == 2);
  constexpr int kShift = kEdge - 1, kCubes = kLeafEdge / kEdge;
  const Int4 cube = (cell & (kLeafEdge - 1)) >> kShift;
  const auto at = std::size_t((cube[0] * kCubes + cube[1]) * kCubes + cube[2]);
  const MicroBounds::Codes c = bounds.codes[brick * micro_cubes_per_brick(kEdge) + at];
  const auto [base, step] = bounds.scales[brick];
  return {base + float(c.lo) * step, base + float(c.hi) * step};
}

}  // namespace pvol
