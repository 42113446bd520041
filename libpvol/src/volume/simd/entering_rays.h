// Rays on their way into a volume.
#pragma once

#include <array>
#include <cstddef>

#include "pvol/math/box.h"

namespace pvol::detail {

/// Side by side, so that loops over them become vectors.
struct EnteringRays {
  static constexpr std::size_t kMost = 64;
  using Row = std::array<double, kMost>;  ///< of numbers, one a ray

  std::size_t n = 0;
  std::array<std::size_t, kMost> ray;  ///< its number
  std::array<Row, 3> o, d;             ///< in the world
  std::array<Row, 3> cells, step;      ///< likewise in cells from the octree's origin
  Row t0, t1;                          ///< the ray's way, then that inside the volume, if t0 < t1

  [[nodiscard]] Ray in_world(std::size_t k) const { return {at(o, k), at(d, k)}; }
  [[nodiscard]] Ray in_cells(std::size_t k) const { return {at(cells, k), at(step, k)}; }

 private:
  [[nodiscard]] static Vec3d at(const std::array<Row, 3>& of, std::size_t k) {
    return {of[0][k], of[1][k], of[2][k]};
  }
};

}  // namespace pvol::detail
