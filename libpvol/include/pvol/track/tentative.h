// Tentative collisions: the Poisson process that null-collision trackers thin out.
#pragma once

#include "pvol/bounds/walk.h"
#include "pvol/math/rng.h"
#include "pvol/track/tally.h"

namespace pvol {

/// Visits the tentative collisions along the segments, which come at the rate of each segment's
/// majorant, until `visit(segment, t, u)` returns true: then the result is true, and false where
/// the ray leaves the cloud first. u is uniform in [0, 1) and belongs to the collision at t.
/// `segments` is a Walk or anything else with its next().
///
/// The optical depth that a segment did not use up is carried into the next one, so there is one
/// logarithm per tentative collision and none per segment (THEORY.md, T3).
template <class Segments, class Count, class Visit>
[[nodiscard, gnu::always_inline]] inline bool visit_tentative(Segments& segments, Rng& rng,
                                                              Count& count, const Visit& visit) {
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
      if (visit(*s, t, next.u)) return true;
      next = rng.tentative();
    }
  }
  return false;
}

}  // namespace pvol
