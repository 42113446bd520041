// Where rays enter volumes, for calls that must not throw.
#pragma once

#include <cmath>

#include "pvol/trackers.h"

namespace pvol::detail {

/// Of one whose square may leave the range of doubles.
[[nodiscard]] Vec3d unit_of_extreme(const Vec3d& direction);

/// The unit vector along a direction; 0 for one that is 0 or not finite.
[[nodiscard]] inline Vec3d unit_of(const Vec3d& direction) {
  const double squared = dot(direction, direction);
  if (!(squared > 0x1p-1000 && squared < 0x1p1000)) return unit_of_extreme(direction);
  return direction / std::sqrt(squared);
}

enum class Entry {
  bad,     ///< not finite, without a direction, or with a t_max that is no number
  misses,  ///< never in the box of the volume
  enters,  ///< the walk is at its start
};

[[nodiscard]] Entry enter_ray(const Volume& volume, const Ray& ray, double t_max, RayWalk& walk);

/// The walk from a place in the volume; `misses` does not occur.
[[nodiscard]] Entry resume_ray(const Volume& volume, const Cursor& from, Vec3d direction,
                               double t_max, RayWalk& walk);

}  // namespace pvol::detail
