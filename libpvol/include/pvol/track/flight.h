// Free flights: the distance to the next real collision.
#pragma once

#include <cmath>

#include "pvol/track/field.h"
#include "pvol/track/regular.h"
#include "pvol/track/tentative.h"
#include "pvol/track/tracker.h"

namespace pvol {

namespace detail {

/// One decision of a weighted tracker: an event of rate `real` (of either sign) among tentative
/// collisions whose rate is `real` + `null`, by probabilities in proportion to the absolute rates
/// (Galtier et al. 2013; Kutz et al. 2017, section 5.2). x is uniform in [0, 1).
/// Multiplies `weight` by rate / (probability of it times all the rates), whose absolute value is 1
/// where neither is negative.
[[nodiscard]] inline bool weighted_choice(float real, float null, float x, float& weight) {
  const float sum = std::abs(real) + std::abs(null), all = real + null;
  const bool is_real = x * sum < std::abs(real);
  // Where no rate is negative the two sums are one number, and weights stay 1 to the last bit.
  if (sum != all) weight *= std::copysign(sum / all, is_real ? real : null);
  return is_real;
}

/// What the field makes of a tentative collision at p that the control part, if there is one, left
/// open.
template <Tracker kTracker, class Field, class Count>
[[nodiscard]] inline bool is_real_in_field(const Field& field, const Segment& s,
                                           const LatticePoint& p, float u, float& weight,
                                           Count& count) {
  if constexpr (kTracker == Tracker::weighted_delta) {
    const float mu_t = field.extinction(s, p, count);
    return weighted_choice(mu_t, s.hi - mu_t, u, weight);
  } else if constexpr (kTracker == Tracker::weighted_decomposition) {
    const float mu_t = field.extinction(s, p, count);
    const float rest = (u * s.hi - s.lo) / (s.hi - s.lo);  // uniform in [0, 1) again
    return weighted_choice(mu_t - s.lo, s.hi - mu_t, rest, weight);
  } else {
    return field.exceeds(s, p, u * s.hi, count);
  }
}

}  // namespace detail

/// Samples the distance t of the next collision of the ray through `segments` (a Walk, or anything
/// else with its next() and point(t)), with density mu_t(t) exp(-int_0^t mu_t). The collision's
/// place is segments.point(t). `field` is an ExtinctionField; a CellField for `regular`.
///
/// `delta` and `delta_global` decide every tentative collision by the field, `decomposition` only
/// those that the control part leaves open, the share 1 - lo/hi (THEORY.md, T3.1, T3.2). Both need
/// bounds that hold; their flights weigh 1. `regular` needs none.
///
/// `weighted_delta` is right for any hi > 0, `weighted_decomposition` for any 0 <= lo < hi (or lo =
/// hi = mu_t) (T3.5). Weights are 1 as long as bounds hold, else of either sign and without limit:
/// their second moment grows as exp(int ((mu_t + |hi - mu_t|)^2 / hi - hi) dt) along the ray.
///
/// Based on: Woodcock et al. 1965; Galtier et al. Integral Formulation of Null-Collision Monte
/// Carlo Algorithms. 2013; Kutz et al. Spectral and Decomposition Tracking. 2017.
template <Tracker kTracker, class Segments, class Field, class Numbers, class Count>
[[nodiscard, gnu::always_inline]] inline Flight free_flight(Segments& segments, const Field& field,
                                                            Numbers& rng, Count& count) {
  static_assert(ExtinctionField<Field, Count>);
  if constexpr (kTracker == Tracker::regular) {
    const auto t = regular_flight(segments, field, double(rng.tentative().depth), count);
    return t ? Flight{*t, 1, true} : Flight{};
  } else {
    double hit = 0;
    float weight = 1;
    const auto is_real = [&](const auto& s, double t, float u) {
      hit = t;
      const float mu = u * s.hi;
      if constexpr (kTracker == Tracker::decomposition ||
                    kTracker == Tracker::weighted_decomposition) {
        count.bounds_test();
        if (mu < s.lo) return true;
      }
      if (detail::is_real_in_field<kTracker>(field, s, segments.point(t), u, weight, count)) {
        return true;
      }
      count.null_collision();
      return false;
    };
    if (visit_tentative(segments, rng, count, is_real)) return {hit, weight, true};
    return {.weight = weight};
  }
}

}  // namespace pvol
