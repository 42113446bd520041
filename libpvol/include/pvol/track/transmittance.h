// Transmittance of a ray through the cloud.
#pragma once

#include <algorithm>

#include "pvol/track/flight.h"

namespace pvol {

/// Products of null probabilities below this are continued with probability product / threshold and
/// weight `threshold`, and dropped otherwise: unbiased, and no ray lingers in the dark.
inline constexpr float kTransmittanceRoulette = 0.1f;

/// Unbiased estimate, in [0, 1], of exp(-int mu_t) over the segments.
/// `ratio` multiplies the probabilities 1 - mu_t/hi of passing each tentative collision
/// (Novak et al. Residual Ratio Tracking. 2014); `analog` is 1 if a free flight sampled with
/// kTracker leaves the cloud (THEORY.md, T7).
template <Transmittance kEstimator, Tracker kTracker, class Segments, class Extinction, class Count>
[[nodiscard]] inline float transmittance(Segments& segments, const Extinction& extinction, Rng& rng,
                                         Count& count) {
  if constexpr (kEstimator == Transmittance::analog) {
    return free_flight<kTracker>(segments, extinction, rng, count) ? 0.0f : 1.0f;
  } else {
    float weight = 1;
    const auto ends = [&](const auto& s, double t, float u) {
      count.lookup();
      // Rounding may lift mu_t above hi by 3 ulp; a negative weight would be noise only.
      weight *= std::max(0.0f, 1 - extinction(s, segments.point(t)) / s.hi);
      if (weight >= kTransmittanceRoulette) return false;
      if (!(u * kTransmittanceRoulette < weight)) return true;
      weight = kTransmittanceRoulette;
      return false;
    };
    return visit_tentative(segments, rng, count, ends) ? 0.0f : weight;
  }
}

}  // namespace pvol
