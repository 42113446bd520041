// The densities of a small cube of cells in a brick of 9^3 samples.
#pragma once

#include <algorithm>
#include <limits>

#include "field/micro_codes.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_range.h"

namespace pvol::detail {

/// The extremes of the samples that look-ups in cube (i, j, k) of edge^3 cells read: those of its
/// closed corners.
[[nodiscard]] inline DensityRange samples_in_cube(const float* samples, Vec3i cube, int edge) {
  const float* const first =
      samples + ((cube.x * kFieldEdge + cube.y) * kFieldEdge + cube.z) * edge;
  DensityRange r{*first, *first};
  for (int i = 0; i <= edge; ++i) {
    for (int j = 0; j <= edge; ++j) {
      const float* const row = first + (i * kFieldEdge + j) * kFieldEdge;
      for (int k = 0; k <= edge; ++k) {
        r.lo = std::min(r.lo, row[k]);
        r.hi = std::max(r.hi, row[k]);
      }
    }
  }
  return r;
}

/// The densities that trilinear and nearest look-ups can compute where samples lie in a range: on
/// plateaus exactly the samples, else up to 3 ulp beyond (THEORY.md, T1.2). An ulp is at most 2^-23
/// of the value: 2^-21 of the largest covers 4 of them.
[[nodiscard]] inline DensityRange reach_of_look_ups(DensityRange r) {
  if (r.lo == r.hi) return r;
  const double slack =
      std::max(double(r.hi) * 0x1p-21, 4 * double(std::numeric_limits<float>::denorm_min()));
  return widened(double(r.lo), double(r.hi), slack);
}

}  // namespace pvol::detail
