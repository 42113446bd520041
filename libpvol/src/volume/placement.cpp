#include "volume/placement.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "math/digits.h"
#include "pvol/error.h"

namespace pvol::detail {

[[noreturn]] void refuse_flat() {
  throw Error(
      "the volume's placement in the world is singular or not finite: it flattens the cloud. Check "
      "the grid's transform and the scene's scale, rotate and matrix.");
}

double column_length(const Affine& a, int axis) {
  return length(Vec3d(a.m[0][axis], a.m[1][axis], a.m[2][axis]));
}

void check_placement(const Affine& to_world, const Affine& to_cells, const Box& world_box) {
  for (int r = 0; r < 3; ++r) {
    if (!is_finite(to_cells.m[std::size_t(r)]) || !std::isfinite(to_cells.t[r]) ||
        !std::isfinite(to_world.t[r])) {
      refuse_flat();
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = column_length(to_cells, axis);
    if (!(cells > 1e-30 && cells < 1e30)) {
      throw Error("the volume has " + digits(cells, 6) +
                  " voxels per world unit along an axis, expected 1e-30 to 1e30. Check the grid's "
                  "voxel size and the scene's scale.");
    }
  }
  // Of columns that rounding alone keeps apart, the determinant is rounding as well.
  constexpr double kFlat = 1e-12;
  double box = 1;
  for (int axis = 0; axis < 3; ++axis) box *= column_length(to_world, axis);
  if (!(std::abs(determinant(to_world)) > kFlat * box)) refuse_flat();
  if (world_box.empty()) return;
  constexpr double kUlps = 4, kMaxLoss = 1e-3;
  double loss = 0;
  for (const Vec3d& row : to_cells.m) {
    const Vec3d reach = max(max(world_box.lo, -world_box.lo), max(world_box.hi, -world_box.hi));
    loss = std::max(loss, kUlps * DBL_EPSILON *
                              dot(Vec3d(std::abs(row.x), std::abs(row.y), std::abs(row.z)), reach));
  }
  if (loss > kMaxLoss) {
    throw Error(
        "the cloud lies so far from the world's origin that positions in it are rounded to " +
        digits(loss, 6) + " voxels; expected at most 0.001. Move it nearer to the origin.");
  }
}

double cell_diagonal(const Affine& to_world) {
  double longest = 0;
  for (const Vec3d d : {Vec3d(1, 1, 1), Vec3d(-1, 1, 1), Vec3d(1, -1, 1), Vec3d(1, 1, -1)}) {
    longest = std::max(longest, length(to_world.vector(d)));
  }
  return longest;
}

}  // namespace pvol::detail
