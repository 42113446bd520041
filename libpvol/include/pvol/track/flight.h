// Free flights: the distance to the next real collision, by null collisions.
#pragma once

#include <optional>

#include "pvol/render/scene.h"
#include "pvol/track/tentative.h"

namespace pvol {

/// Samples the distance t of the next collision of the walk's ray, with density
/// mu_t(t) exp(-int_0^t mu_t); nothing where the ray leaves the cloud first. The collision's place
/// is segments.point(t). `extinction(segment, point)` is the exact mu_t; `segments` is a Walk or
/// anything else with its next() and point(t).
///
/// With the `decomposition` tracker the share lo/hi of tentative collisions belongs to the
/// homogeneous control part and is real without a look-up; the residual decides about the others
/// (THEORY.md, T4). With `delta` and `delta_global` every one costs a look-up.
/// Based on: Woodcock et al. 1965; Kutz et al. Spectral and Decomposition Tracking. 2017.
template <Tracker kTracker, class Segments, class Extinction, class Count>
[[nodiscard]] inline std::optional<double> free_flight(Segments& segments,
                                                       const Extinction& extinction, Rng& rng,
                                                       Count& count) {
  double hit = 0;
  const auto is_real = [&](const auto& s, double t, float u) {
    hit = t;
    const float mu = u * s.hi;
    if constexpr (kTracker == Tracker::decomposition) {
      count.bounds_test();
      if (mu < s.lo) return true;
    }
    count.lookup();
    if (mu < extinction(s, segments.point(t))) return true;
    count.null_collision();
    return false;
  };
  if (visit_tentative(segments, rng, count, is_real)) return hit;
  return std::nullopt;
}

}  // namespace pvol
