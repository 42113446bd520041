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

/// The bounds of the cube that holds a cell, counted from the octree's origin.
[[nodiscard, gnu::always_inline]] inline DensityRange micro_range(const MicroBounds& bounds,
                                                                  std::uint32_t brick, Int4 cell) {
  static_assert(kLeafEdge == 8);
  const int shift = bounds.edge - 1, bits = 3 - shift;  // a brick has 2^bits cubes along an edge
  const Int4 cube = (cell & (kLeafEdge - 1)) >> shift;
  const auto at = std::size_t((((cube[0] << bits) + cube[1]) << bits) + cube[2]);
  const MicroBounds::Codes c = bounds.codes[(std::size_t(brick) << (3 * bits)) + at];
  const auto [base, step] = bounds.scales[brick];
  return {base + float(c.lo) * step, base + float(c.hi) * step};
}

}  // namespace pvol
