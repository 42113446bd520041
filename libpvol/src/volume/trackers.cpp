// Where the segments of a ray begin.
#include "pvol/trackers.h"

#include <cmath>
#include <string>

#include "pvol/error.h"

namespace pvol {
namespace {

Vec3d unit(Vec3d direction) {
  const double size = length(direction);
  if (!(size > 0 && std::isfinite(size))) {
    throw Error("a ray has a direction of length " + std::to_string(size) +
                "; it must be finite and not zero. Check where the renderer samples directions.");
  }
  return direction / size;
}

}  // namespace

std::optional<RayWalk> enter(const Volume& volume, const Ray& ray, double t_max) {
  if (!is_finite(ray.o) || std::isnan(t_max)) {
    throw Error("a ray has an origin or a t_max that is not a number; check where it is made");
  }
  const Vec3d direction = unit(ray.d);
  if (volume.density.octree.empty()) return std::nullopt;
  const Ray cells{volume.density.world_to_cells.point(ray.o),
                  volume.density.world_to_cells.vector(direction)};
  const auto span = intersect(volume.density.octree.support(), cells, 0, t_max);
  if (!span) return std::nullopt;
  return RayWalk(volume.density.octree, make_cursor(volume.density.octree, cells.at(span->t0)),
                 cells.d, *span);
}

RayWalk resume(const Volume& volume, const Cursor& from, Vec3d direction, double t_max) {
  if (std::isnan(t_max)) throw Error("the t_max of a ray is not a number; check where it is made");
  return RayWalk(volume.density.octree, from, volume.density.world_to_cells.vector(unit(direction)),
                 {0, t_max});
}

}  // namespace pvol
