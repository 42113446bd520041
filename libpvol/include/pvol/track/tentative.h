// Tentative collisions: the Poisson process that null-collision trackers thin out.
#pragma once

#include "pvol/bounds/walk.h"
#include "pvol/math/rng.h"
#include "pvol/track/tally.h"

namespace pvol {

/// Visits the tentative collisions of one segment, which come at `rate` > 0, until `visit(segment,
/// t, u)` returns true: then the result is true. u is uniform in [0, 1) and belongs to the
/// collision at t, which exceeds the segment's end by rounding at most. `next` is the tentative
/// collision ahead.
///
/// The optical depth that a segment did not use up stays in `next` for the segment that follows, so
/// there is one logarithm per tentative collision and none per segment (THEORY.md, T3.1).
template <class Numbers, class Visit>
[[nodiscard, gnu::always_inline]] inline bool visit_segment(const Segment& s, float rate,
                                                            Rng::Tentative& next, Numbers& rng,
                                                            const Visit& visit) {
  double t = s.t0;
  for (;;) {
    const float rest = rate * float(s.t1 - t);
    if (!(next.depth < rest)) {
      next.depth -= rest;
      return false;
    }
    t += double(next.depth / rate);
    if (visit(s, t, next.u)) return true;
    next = rng.tentative();
  }
}

/// The same along all segments, at the rate of each one's majorant; false where the ray leaves the
/// cloud first. `segments` is a Walk or anything else with its next().
template <class Segments, class Numbers, class Count, class Visit>
[[nodiscard, gnu::always_inline]] inline bool visit_tentative(Segments& segments, Numbers& rng,
                                                              Count& count, const Visit& visit) {
  Rng::Tentative next = rng.tentative();
  while (const auto s = segments.next()) {
    count.segment();
    if (visit_segment(*s, s->hi, next, rng, visit)) return true;
  }
  return false;
}

/// Segments whose bounds are multiplied: majorants by `hi`, minorants by `lo`. A ray through them
/// meets the same medium under other bounds, looser ones or ones that do not hold.
template <class Segments>
struct ScaledSegments {
  Segments& segments;
  float hi = 1, lo = 1;

  [[nodiscard]] std::optional<Segment> next() {
    auto s = segments.next();
    if (s) s->hi *= hi, s->lo *= lo;
    return s;
  }
  [[nodiscard]] LatticePoint point(double t) const { return segments.point(t); }
};

}  // namespace pvol
