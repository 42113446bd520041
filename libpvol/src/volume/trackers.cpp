// Where the segments of a ray begin.
#include "pvol/trackers.h"

#include <cmath>
#include <string>

#include "pvol/error.h"
#include "volume/ray_entry.h"

namespace pvol {
namespace {

/// The length of a direction; 0 for one that has none.
double usable_length(Vec3d direction) {
  const double size = length(direction);
  return size > 0 && std::isfinite(size) ? size : 0;
}

[[noreturn]] void refuse(Vec3d direction, double t_max) {
  if (std::isnan(t_max)) throw Error("the t_max of a ray is not a number; check where it is made");
  if (usable_length(direction) == 0) {
    throw Error("a ray has a direction of length " + std::to_string(length(direction)) +
                "; it must be finite and not zero. Check where the renderer samples directions.");
  }
  throw Error("a ray has an origin that is not finite; check where it is made");
}

}  // namespace

detail::Entry detail::enter_ray(const Volume& volume, const Ray& ray, double t_max, RayWalk& walk) {
  const VolumeField& field = volume.density;
  const double size = usable_length(ray.d);
  if (size == 0 || std::isnan(t_max) || !is_finite(ray.o)) return Entry::bad;
  if (field.octree.empty()) return Entry::misses;
  const Ray cells{field.world_to_cells.point(ray.o), field.world_to_cells.vector(ray.d / size)};
  const auto span = intersect(field.octree.support(), cells, 0, t_max);
  if (!span) return Entry::misses;
  walk = RayWalk(field.octree, make_cursor(field.octree, cells.at(span->t0)), cells.d, *span);
  return Entry::enters;
}

detail::Entry detail::resume_ray(const Volume& volume, const Cursor& from, Vec3d direction,
                                 double t_max, RayWalk& walk) {
  const VolumeField& field = volume.density;
  const double size = usable_length(direction);
  if (size == 0 || std::isnan(t_max)) return Entry::bad;
  walk = RayWalk(field.octree, from, field.world_to_cells.vector(direction / size), {0, t_max});
  return Entry::enters;
}

std::optional<RayWalk> enter(const Volume& volume, const Ray& ray, double t_max) {
  RayWalk walk;
  const detail::Entry entry = detail::enter_ray(volume, ray, t_max, walk);
  if (entry == detail::Entry::bad) refuse(ray.d, t_max);
  if (entry == detail::Entry::misses) return std::nullopt;
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
