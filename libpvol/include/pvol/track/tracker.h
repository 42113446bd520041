// The ways to sample a free path, what one is, and the ways to estimate a transmittance.
#pragma once

#include <limits>

#include "pvol/math/names.h"

namespace pvol {

/// How free paths are sampled (THEORY.md, section 3). All give the same picture on average.
enum class Tracker {
  delta_global,    ///< one majorant over the box of the cloud: the baseline
  delta,           ///< null collisions against the majorant of each segment
  decomposition,   ///< control part from the minorant without a look-up, the residual as delta
  weighted_delta,  ///< delta with weights, for majorants that may lie too low
  weighted_decomposition,  ///< decomposition with weights, for bounds that may not bound
  regular,                 ///< closed form, cell by cell: no null collisions, a look-up a cell
};
[[nodiscard]] constexpr auto names(Tracker) {
  return std::to_array<Named<Tracker>>({
      {Tracker::delta_global, "delta-global"},
      {Tracker::delta, "delta"},
      {Tracker::decomposition, "decomposition"},
      {Tracker::weighted_delta, "weighted-delta"},
      {Tracker::weighted_decomposition, "weighted-decomposition"},
      {Tracker::regular, "regular"},
  });
}

/// Whether flights carry weights, and bounds need not bound.
[[nodiscard]] constexpr bool is_weighted(Tracker t) {
  return t == Tracker::weighted_delta || t == Tracker::weighted_decomposition;
}

/// The largest factor by which mu_t may exceed a majorant for trackers with weights: beyond it
/// their variance makes pictures useless before they are right.
inline constexpr double kMostBoundsExcess = 3;

/// The largest factor by which majorants may be scaled: looser bounds measure nothing new.
inline constexpr double kMostMajorantScale = 1000;

/// A sampled free flight. For any function g of the distance that is 0 where the ray leaves, the
/// mean of `weight g(t)` over flights that collided is int g(t) mu_t(t) exp(-int_0^t mu_t) dt; the
/// mean of `weight` over those that left is the transmittance.
struct Flight {
  double t = std::numeric_limits<double>::infinity();  ///< of the collision; infinite without one
  float weight = 1;  ///< exactly 1 for analog and regular trackers; else see flight.h
  bool collided = false;
};

/// How the transmittance of a ray is estimated (THEORY.md, T3.3).
enum class Transmittance {
  automatic,       ///< one of the others, chosen by `choose_transmittance` for the volume
  ratio,           ///< product of null probabilities, with unbiased roulette of small products
  analog,          ///< 1 where a sampled free path leaves the cloud, else 0
  residual_ratio,  ///< a control part in closed form times `ratio` of the rest
  regular,         ///< exact, cell by cell
};
[[nodiscard]] constexpr auto names(Transmittance) {
  return std::to_array<Named<Transmittance>>({
      {Transmittance::automatic, "auto"},
      {Transmittance::ratio, "ratio"},
      {Transmittance::analog, "analog"},
      {Transmittance::residual_ratio, "residual-ratio"},
      {Transmittance::regular, "regular"},
  });
}

}  // namespace pvol
