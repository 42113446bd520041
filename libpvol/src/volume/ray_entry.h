// Where rays enter volumes, for calls that must not throw.
#pragma once

#include "pvol/trackers.h"
#include "volume/unit_direction.h"

namespace pvol::detail {

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
