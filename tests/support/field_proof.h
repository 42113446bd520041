// Free flights and transmittance of a field that has no closed form, against an oracle in double.
#pragma once

#include <string>
#include <type_traits>

#include "pvol/track/transmittance.h"
#include "support/flight_histogram.h"
#include "support/flights.h"
#include "support/statistics.h"

namespace pvol::test {

/// `f(name, constant)` for each tracker that takes any ExtinctionField.
template <class F>
void for_each_tracker(const F& f) {
  f("delta", std::integral_constant<Tracker, Tracker::delta>{});
  f("decomposition", std::integral_constant<Tracker, Tracker::decomposition>{});
  f("weighted delta", std::integral_constant<Tracker, Tracker::weighted_delta>{});
  f("weighted decomposition", std::integral_constant<Tracker, Tracker::weighted_decomposition>{});
}

/// A start as in flights.h: cursor, direction, and an oracle of the ray.
template <Tracker kTracker, class Start, class Field>
[[nodiscard]] FlightHistogram sample_flights(const Octree& tree, const Start& a, const Field& field,
                                             int flights, std::uint64_t stream) {
  FlightHistogram histogram(a.oracle);
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, stream, std::uint64_t(i));
    Walk walk(tree, a.cursor, a.direction);
    NoTally none;
    const Flight flight = free_flight<kTracker>(walk, field, rng, none);
    // Where bounds hold, a look-up exceeds them by rounding at most.
    EXPECT_NEAR(double(flight.weight), 1, 1e-4);
    histogram.add(flight);
  }
  return histogram;
}

/// The p-value of the mean of an estimator of transmittance.
template <Transmittance kEstimator, class Start, class Field>
[[nodiscard]] double transmittance_p_value(const Octree& tree, const Start& a, const Field& field,
                                           int rays, std::uint64_t stream) {
  proof::Moments m;
  for (int i = 0; i < rays; ++i) {
    Rng rng(kSeed, stream, std::uint64_t(i));
    Walk walk(tree, a.cursor, a.direction);
    NoTally none;
    m.add(double(transmittance<kEstimator, Tracker::delta>(walk, field, rng, none)));
  }
  const double expected = std::exp(-a.oracle.optical_depth());
  return proof::mean_p_value(m, expected, 1e-5 * expected);
}

/// Every tracker and estimator along one ray, to `family`; the flights also to the sum of their
/// tracker, by name.
template <class Start, class Field, class Sums>
void prove(const Octree& tree, const Start& a, const Field& field, int flights,
           const std::string& name, std::uint64_t& stream, proof::Family& family, Sums& sums) {
  for_each_tracker([&](const std::string& tracker, auto constant) {
    const auto h = sample_flights<decltype(constant)::value>(tree, a, field, flights, ++stream);
    family.add(name + ", " + tracker, h.p_value());
    sums.try_emplace(tracker, FlightHistogram(a.oracle)).first->second.add(h);
  });
  using enum Transmittance;
  family.add(name + ", ratio", transmittance_p_value<ratio>(tree, a, field, flights, ++stream));
  family.add(name + ", residual ratio",
             transmittance_p_value<residual_ratio>(tree, a, field, flights, ++stream));
}

/// The same flights in both fields: equal to the last bit, as are the random numbers that follow.
/// Returns the look-ups of the second over those of the first.
template <Tracker kTracker, class Start, class Plain, class Squeezed>
[[nodiscard]] double compare_flights(const Octree& tree, const Start& a, const Plain& plain,
                                     const Squeezed& squeezed, int flights) {
  int different = 0;
  Tally all, fewer;
  for (int i = 0; i < flights; ++i) {
    Rng rng(kSeed, 5, std::uint64_t(i)), same = rng;
    Walk walk(tree, a.cursor, a.direction), again = walk;
    const Flight f = free_flight<kTracker>(walk, plain, rng, all);
    const Flight g = free_flight<kTracker>(again, squeezed, same, fewer);
    different += !(f.collided == g.collided && f.t == g.t && g.weight == 1);
    different += all.null_collisions != fewer.null_collisions;
    different += rng.block().lo != same.block().lo;
  }
  EXPECT_EQ(different, 0);
  return double(fewer.lookups) / double(all.lookups);
}

}  // namespace pvol::test
