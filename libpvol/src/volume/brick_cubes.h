// The densities of the small cubes that a brick is divided into.
#pragma once

#include <array>
#include <cstdint>

#include "pvol/field/micro_range.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

inline constexpr int kFinestCubes = 1;  ///< log2 of their edge in cells

/// Of n^3 cubes, cube (i, j, k) at (i * n + j) * n + k.
struct BrickCubes {
  int n;
  std::array<DensityRange, 64> range;
};

/// What look-ups, mapped, can compute in the cubes of 2^shift cells along an edge of a brick of a
/// field with samples; shift from kFinestCubes to that of the whole brick, 3.
[[nodiscard]] BrickCubes cubes_of(const VolumeField& field, std::uint32_t brick, int shift);

/// Those of cubes of twice the edge.
[[nodiscard]] BrickCubes coarser(const BrickCubes& fine);

/// Calls visit(index, (i, j, k)) for n^3 cubes.
template <class Visit>
void for_cubes(int n, const Visit& visit) {
  for (int i = 0, at = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k, ++at) visit(at, Vec3i(i, j, k));
    }
  }
}

}  // namespace pvol::detail
