// Free flights: the distance to the next real collision, by null collisions.
#pragma once

#include <optional>

#include "pvol/bounds/walk.h"
#include "pvol/math/rng.h"
#include "pvol/render/scene.h"
#include "pvol/track/tally.h"

namespace pvol {

/// Samples the distance t of the next collision of the walk's ray, with density
/// mu_t(t) exp(-int_0^t mu_t); nothing where the ray leaves the cloud first. The collision's place
/// is walk.point(t). `extinction(segment, point)` is the exact mu_t; `segments` is a Walk or
/// anything else with next() and point(t).
///
/// Tentative collisions come at the rate of the majorant. The optical depth that a segment did not
/// use up is carried into the next one, so a flight takes one logarithm per tentative collision and
/// none per segment (THEORY.md, T3). With the `decomposition` tracker the share lo/hi of tentative
/// collisions belongs to the homogeneous control part and is real without a look-up; the residual
/// decides about the others (T4). With `delta` and `delta_global` every one costs a look-up.
/// Based on: Woodcock et al. 1965; Kutz et al. Spectral and Decomposition Tracking. 2017.
template <Tracker kTracker, class Segments, class Extinction, class Count>
[[nodiscard]] inline std::optional<double> free_flight(Segments& segments,
                                                       const Extinction& extinction, Rng& rng,
                                                       Count& count) {
  Rng::Tentative next = rng.tentative();
  while (const auto s = segments.next()) {
    count.segment();
    double t = s->t0;
    for (;;) {
      const float rest = s->hi * float(s->t1 - t);
      if (!(next.depth < rest)) {
        next.depth -= rest;
        break;
      }
      t += double(next.depth / s->hi);
      const float u = next.u * s->hi;
      if constexpr (kTracker == Tracker::decomposition) {
        count.bounds_test();
        if (u < s->lo) return t;
      }
      count.lookup();
      if (u < extinction(*s, segments.point(t))) return t;
      count.null_collision();
      next = rng.tentative();
    }
  }
  return std::nullopt;
}

}  // namespace pvol
