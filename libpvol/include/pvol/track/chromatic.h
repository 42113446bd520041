// Free flights and transmittances where the extinction differs by channel.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include "pvol/math/vec.h"
#include "pvol/track/field.h"
#include "pvol/track/tentative.h"
#include "pvol/track/transmittance.h"

namespace pvol {

/// A field whose flights may be told to end: `ends()` is true from then on.
template <class Field>
concept EndsFlights = requires(const Field& field) {
  { field.ends() } -> std::same_as<bool>;
};

/// Whether flights through a field are to end, wherever they are.
template <class Field>
[[nodiscard]] bool is_over(const Field& field) {
  if constexpr (EndsFlights<Field>) return field.ends();
  return false;
}

/// A flight that serves all channels at once, each with a weight of its own.
struct ChromaticFlight {
  double t = 0;
  Rgb weight{1.0f};
  bool collided = false;
};

/// Samples a collision of a medium of extinction share * mu_t by channel, where mu_t is the field's
/// and shares are in [0, 1]: of each tentative collision at the rate of the majorant, one decision
/// for all channels, by probabilities in proportion to what they carry, `throughput` times their
/// weights so far. So none of the products exceeds the sum of them all, however far the channels
/// are apart. Majorants need not hold: then weights may be negative, and grow. E[weight f(t)] is
/// the integral of share mu_t T f by channel (THEORY.md, T3.9).
/// Based on: Kutz, Habel, Li, Novak. Spectral and Decomposition Tracking. 2017, section 5.1, with
/// probabilities by path history.
template <class Segments, class Field, class Numbers, class Count>
[[nodiscard]] ChromaticFlight chromatic_flight(Segments& segments, const Field& field, Rgb share,
                                               Rgb throughput, Numbers& rng, Count& count) {
  static_assert(ExtinctionField<Field, Count>);
  ChromaticFlight flight;
  const auto carried = [&](Rgb x) {
    const Rgb product = throughput * x;
    return std::abs(product.x) + std::abs(product.y) + std::abs(product.z);
  };
  const auto is_real = [&](const Segment& s, double t, float u) {
    const float mu = field.extinction(s, segments.point(t), count) / s.hi;
    const Rgb real = share * mu;
    const Rgb excess = max(real - Rgb(1.0f), Rgb(0.0f));
    const float all = carried(flight.weight) + 2 * carried(flight.weight * excess),
                p = all > 0 ? carried(flight.weight * real) / all : std::min(mu, 1.0f);
    flight.t = t;
    if (is_over(field)) return true;
    if (u < p) {
      flight.weight *= real / p;
      return true;
    }
    flight.weight *= (Rgb(1.0f) - real) / (1 - p);
    count.null_collision();
    return false;
  };
  flight.collided = visit_tentative(segments, rng, count, is_real);
  return flight;
}

/// An unbiased estimate of the transmittance by channel; where majorants hold, each in [0, 1] but
/// for roulette, which lifts the largest to kTransmittanceRoulette.
template <class Segments, class Field, class Numbers, class Count>
[[nodiscard]] Rgb chromatic_transmittance(Segments& segments, const Field& field, Rgb share,
                                          Numbers& rng, Count& count) {
  Rgb weight(1.0f);
  const auto ends = [&](const Segment& s, double t, float u) {
    const float mu = field.extinction(s, segments.point(t), count) / s.hi;
    weight *= Rgb(1.0f) - share * mu;
    if (is_over(field)) return true;
    const float most = max_component(max(weight, -weight));
    if (most >= kTransmittanceRoulette) return false;
    if (!(u * kTransmittanceRoulette < most)) return true;
    weight *= kTransmittanceRoulette / most;
    return false;
  };
  return visit_tentative(segments, rng, count, ends) ? Rgb(0.0f) : weight;
}

}  // namespace pvol
