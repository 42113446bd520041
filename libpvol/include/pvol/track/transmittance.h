// Transmittance of a ray through the cloud.
#pragma once

#include <algorithm>
#include <cmath>

#include "pvol/track/flight.h"

namespace pvol {

/// Products of weights below this are continued with probability product / threshold and weight
/// `threshold`, and dropped otherwise: unbiased, and no ray lingers in the dark.
inline constexpr float kTransmittanceRoulette = 0.1f;

/// The control part of residual ratio tracking that bounds alone provide: nothing of the medium is
/// below it, so that no factor exceeds 1.
struct MinorantControl {
  [[nodiscard]] float operator()(const Segment& s) const { return s.lo; }
};

namespace detail {

/// The roulette of a product, of either sign; false where it is dropped. u is uniform in [0, 1).
[[nodiscard]] inline bool survives(float& weight, float u) {
  const float size = std::abs(weight);
  if (size >= kTransmittanceRoulette) return true;
  if (!(u * kTransmittanceRoulette < size)) return false;
  weight = std::copysign(kTransmittanceRoulette, weight);
  return true;
}

template <Tracker kTracker, class Segments, class Field, class Numbers, class Count>
[[nodiscard]] inline float ratio_transmittance(Segments& segments, const Field& field, Numbers& rng,
                                               Count& count) {
  float weight = 1;
  const auto ends = [&](const Segment& s, double t, float u) {
    const float null = 1 - field.extinction(s, segments.point(t), count) / s.hi;
    // Where bounds hold, rounding may lift mu_t above hi by 3 ulp; a negative weight would be noise
    // only.
    weight *= is_weighted(kTracker) ? null : std::max(0.0f, null);
    return !survives(weight, u);
  };
  return visit_tentative(segments, rng, count, ends) ? 0.0f : weight;
}

template <class Segments, class Field, class Numbers, class Count, class Control>
[[nodiscard]] inline float residual_transmittance(Segments& segments, const Field& field,
                                                  Numbers& rng, Count& count,
                                                  const Control& control) {
  float weight = 1;
  Rng::Tentative next = rng.tentative();
  while (const auto s = segments.next()) {
    count.segment();
    const float c = control(*s), rate = std::max(s->hi - c, c - s->lo);
    if (c > 0) {
      weight *= std::exp(-c * float(s->t1 - s->t0));
      if (std::abs(weight) < kTransmittanceRoulette && !survives(weight, rng.uniform())) return 0;
    }
    if (!(rate > 0)) continue;
    const auto ends = [&](const Segment& here, double t, float u) {
      weight *= 1 - (field.extinction(here, segments.point(t), count) - c) / rate;
      return !survives(weight, u);
    };
    if (visit_segment(*s, rate, next, rng, ends)) return 0;
  }
  return weight;
}

}  // namespace detail

/// Unbiased estimate of exp(-int mu_t) over the segments (THEORY.md, T3.3), of an ExtinctionField;
/// a CellField for `regular`. `analog`: the weight of a free flight of kTracker that leaves the
/// cloud, else 0. `ratio` multiplies the probabilities 1 - mu_t/hi of passing each tentative
/// collision (Novak et al. Residual Ratio Tracking. 2014). In [0, 1]; with a weighted kTracker
/// bounds need not bound, and the estimate has either sign and no limit. `residual_ratio` takes the
/// factor exp(-c length) of a control c = control(segment) in closed form and tracks the rest at
/// the rate r = max(hi - c, c - lo) by factors 1 - (mu_t - c)/r, which lie in [0, 2] where bounds
/// hold, in [0, 1] for c <= lo. c >= 0 may be any constant of the segment, such as its mean; with c
/// = lo = hi it must be mu_t itself. `regular` is exact, without random numbers.
template <Transmittance kEstimator, Tracker kTracker, class Segments, class Field, class Numbers,
          class Count, class Control = MinorantControl>
[[nodiscard]] inline float transmittance(Segments& segments, const Field& field, Numbers& rng,
                                         Count& count, const Control& control = {}) {
  static_assert(ExtinctionField<Field, Count>);
  if constexpr (kEstimator == Transmittance::analog) {
    const Flight flight = free_flight<kTracker>(segments, field, rng, count);
    return flight.collided ? 0.0f : flight.weight;
  } else if constexpr (kEstimator == Transmittance::ratio) {
    return detail::ratio_transmittance<kTracker>(segments, field, rng, count);
  } else if constexpr (kEstimator == Transmittance::residual_ratio) {
    return detail::residual_transmittance(segments, field, rng, count, control);
  } else {
    return float(std::exp(-optical_depth(segments, field, count)));
  }
}

}  // namespace pvol
