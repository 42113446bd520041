// Where the segments of a ray begin.
#include "pvol/trackers.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pvol/error.h"

namespace pvol {
namespace {

[[noreturn, gnu::cold]] void refuse_direction(double size) {
  throw Error("a ray has a direction of length " + std::to_string(size) +
              "; it must be finite and not zero. Check where the renderer samples directions.");
}

inline Vec3d unit(const Vec3d& direction) {
  const double size = length(direction);
  if (!(size > 0 && std::isfinite(size))) refuse_direction(size);
  return direction / size;
}

/// The part of a ray in the box, from wherever the ray begins.
[[gnu::noinline]] std::optional<Span> clip_any(const Box& box, const Ray& ray, double t_max) {
  return intersect(box, ray, 0, t_max);
}

/// The same, to the last bit. Most rays of a path begin inside the box: the near faces are behind
/// them and need no quotients, and the choice of those ahead is no branch, which random directions
/// would make the processor guess wrong.
inline std::optional<Span> clip(const Box& box, const Ray& ray, double t_max) {
  if (!box.contains(ray.o) || ray.d.x == 0 || ray.d.y == 0 || ray.d.z == 0)
    return clip_any(box, ray, t_max);
  double t1 = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double faces[] = {box.lo[axis], box.hi[axis]};
    t1 = std::min(t1, (faces[ray.d[axis] > 0] - ray.o[axis]) / ray.d[axis]);
  }
  if (!(0 < t1)) return std::nullopt;
  return Span{0, t1};
}

}  // namespace

std::optional<RayWalk> enter(const Volume& volume, const Ray& ray, double t_max) {
  if (!is_finite(ray.o) || std::isnan(t_max)) {
    throw Error("a ray has an origin or a t_max that is not a number; check where it is made");
  }
  const Vec3d direction = unit(ray.d);
  const Octree& tree = volume.density.octree;
  if (tree.empty()) return std::nullopt;
  const Ray cells{volume.density.world_to_cells.point(ray.o),
                  volume.density.world_to_cells.vector(direction)};
  const auto span = clip(tree.support(), cells, t_max);
  if (!span) return std::nullopt;
  return std::optional<RayWalk>(std::in_place, tree, lattice_point(tree, cells.at(span->t0)),
                                cells.d, *span);
}

RayWalk resume(const Volume& volume, const Cursor& from, Vec3d direction, double t_max) {
  if (std::isnan(t_max)) throw Error("the t_max of a ray is not a number; check where it is made");
  return RayWalk(volume.density.octree, from, volume.density.world_to_cells.vector(unit(direction)),
                 {0, t_max});
}

}  // namespace pvol
