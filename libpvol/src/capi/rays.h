// Rays of the C API as the library has them.
#pragma once

#include "capi/committed.h"
#include "volume/ray_entry.h"

namespace pvol::detail {

[[nodiscard]] inline Vec3d vec(const double v[3]) { return {v[0], v[1], v[2]}; }

/// What rays see, or null.
[[nodiscard]] inline const Committed* committed(const pvol_volume* volume) {
  return volume == nullptr ? nullptr : volume->committed.get();
}

/// `bad` for no volume, too.
[[nodiscard]] inline Entry enter(const Committed* c, const pvol_ray& ray, RayWalk& walk) {
  if (c == nullptr) return Entry::bad;
  return enter_ray(*c->volume, {vec(ray.o), vec(ray.d)}, ray.t_max, walk);
}

/// Whether there is such an estimator.
[[nodiscard]] inline bool is_estimator(pvol_estimator estimator) {
  return estimator == PVOL_RATIO || estimator == PVOL_ANALOG || estimator == PVOL_RESIDUAL_RATIO ||
         estimator == PVOL_EXACT;
}

/// What C programs get of the name of one.
[[nodiscard]] inline Transmittance estimator_of(pvol_estimator estimator) {
  switch (estimator) {
    case PVOL_ANALOG:
      return Transmittance::analog;
    case PVOL_RESIDUAL_RATIO:
      return Transmittance::residual_ratio;
    case PVOL_EXACT:
      return Transmittance::regular;
    case PVOL_RATIO:
      break;
  }
  return Transmittance::ratio;
}

/// A flight along a walk, by the caller's numbers or pvol's own; t from the ray's origin.
[[nodiscard]] Flight fly(const Committed& c, RayWalk& walk, pvol_random& random);

/// An estimate of the transmittance of what lies ahead of a walk; no number for a closed form where
/// there is none, and for an estimator that there is not.
[[nodiscard]] float estimate_transmittance(const Committed& c, pvol_estimator estimator,
                                           RayWalk& walk, pvol_random& random);

}  // namespace pvol::detail
