// Where rays enter the volume: loops over rays side by side, of which the compiler makes
// vectors of doubles. IEEE rounding makes them the same at any width.

#if defined(PVOL_LANE_ENTER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_ENTER_INL_H
#undef PVOL_LANE_ENTER_INL_H
#else
#define PVOL_LANE_ENTER_INL_H
#endif

#include <cmath>
#include <limits>

#include "pvol/volume/volume.h"
#include "volume/simd/entering_rays.h"
#include "volume/simd/simd_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Makes the directions unit.
inline HWY_NOINLINE void normalize_directions(EnteringRays& e) {
  for (std::size_t k = 0; k < e.n; ++k) {
    const double x = e.d[0][k], y = e.d[1][k], z = e.d[2][k];
    const double size = std::sqrt(x * x + y * y + z * z);
    e.d[0][k] = x / size, e.d[1][k] = y / size, e.d[2][k] = z / size;
  }
}

inline HWY_NOINLINE void find_rays_in_cells(const Affine& to_cells, EnteringRays& e) {
  const Affine a = to_cells;
  for (std::size_t k = 0; k < e.n; ++k) {
    const Vec3d o(e.o[0][k], e.o[1][k], e.o[2][k]);
    const Vec3d d(e.d[0][k], e.d[1][k], e.d[2][k]);
    const Vec3d cells = a.point(o), step = a.vector(d);
    e.cells[0][k] = cells.x, e.cells[1][k] = cells.y, e.cells[2][k] = cells.z;
    e.step[0][k] = step.x, e.step[1][k] = step.y, e.step[2][k] = step.z;
  }
}

/// Narrows the spans to the part of the rays between two faces of the box, as `intersect` does.
inline HWY_NOINLINE void cut_by_faces(double low, double high, const EnteringRays::Row& o,
                                      const EnteringRays::Row& d, EnteringRays& e) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < e.n; ++k) {
    const bool along = d[k] == 0, up = d[k] > 0;
    const double inside = (o[k] < low) | (o[k] > high) ? -kFar : kFar;
    const double near = ((up ? low : high) - o[k]) / d[k], far = ((up ? high : low) - o[k]) / d[k];
    const double begin = along ? -kFar : near, end = along ? inside : far;
    e.t0[k] = e.t0[k] < begin ? begin : e.t0[k];
    e.t1[k] = end < e.t1[k] ? end : e.t1[k];
  }
}

/// Finds the rays in cells, and narrows their ways to those inside the volume.
inline void find_spans(const VolumeField& v, EnteringRays& e) {
  find_rays_in_cells(v.world_to_cells, e);
  const Box box = v.octree.support();
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = std::size_t(axis);
    cut_by_faces(box.lo[axis], box.hi[axis], e.cells[row], e.step[row], e);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
