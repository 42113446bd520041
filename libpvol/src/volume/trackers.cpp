// Where the segments of a ray begin.
#include "pvol/trackers.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "pvol/error.h"
#include "volume/ray_entry.h"

namespace pvol {
namespace {

[[noreturn, gnu::cold]] void refuse(Vec3d direction, double t_max) {
  if (std::isnan(t_max))
    throw Error("the t_max of a ray is NaN; expected a number. Check the code that sets it.");
  if (detail::unit_of(direction) == Vec3d{}) {
    throw Error(
        "a ray has a direction of length 0, or one that is not finite; check the code that samples "
        "directions");
  }
  throw Error("the origin of a ray is not finite; check the code that sets it");
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

/// The same as detail::enter_ray; make(arguments of a walk) makes it where it is to be.
template <class Make>
inline detail::Entry enter_with(const Volume& volume, const Ray& ray, double t_max,
                                const Make& make) {
  const VolumeField& field = volume.density;
  const Vec3d along = detail::unit_of(ray.d);
  if (along == Vec3d{} || std::isnan(t_max) || !is_finite(ray.o)) return detail::Entry::bad;
  if (field.octree.empty()) return detail::Entry::misses;
  const Ray cells{field.world_to_cells.point(ray.o), field.world_to_cells.vector(along)};
  if (!is_finite(cells.o)) return detail::Entry::bad;
  const auto span = clip(field.octree.support(), cells, t_max);
  if (!span) return detail::Entry::misses;
  make(field.octree, lattice_point(field.octree, cells.at(span->t0)), cells.d, *span);
  return detail::Entry::enters;
}

}  // namespace

detail::Entry detail::enter_ray(const Volume& volume, const Ray& ray, double t_max, RayWalk& walk) {
  return enter_with(volume, ray, t_max,
                    [&](const auto&... of) { std::construct_at(&walk, of...); });
}

detail::Entry detail::resume_ray(const Volume& volume, const Cursor& from, Vec3d direction,
                                 double t_max, RayWalk& walk) {
  const VolumeField& field = volume.density;
  const Vec3d along = detail::unit_of(direction);
  if (along == Vec3d{} || std::isnan(t_max)) return Entry::bad;
  std::construct_at(&walk, field.octree, from, field.world_to_cells.vector(along), Span{0, t_max});
  return Entry::enters;
}

std::optional<RayWalk> enter(const Volume& volume, const Ray& ray, double t_max) {
  std::optional<RayWalk> walk;
  const detail::Entry entry =
      enter_with(volume, ray, t_max, [&](const auto&... of) { walk.emplace(of...); });
  if (entry == detail::Entry::bad) refuse(ray.d, t_max);
  return walk;
}

RayWalk resume(const Volume& volume, const Cursor& from, Vec3d direction, double t_max) {
  RayWalk walk;
  if (detail::resume_ray(volume, from, direction, t_max, walk) == detail::Entry::bad) {
    refuse(direction, t_max);
  }
  return walk;
}

}  // namespace pvol
