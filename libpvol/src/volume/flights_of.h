// The loops behind flights.h: from a tracker's or an estimator's name to the code for it.
#pragma once

#include <utility>

#include "pvol/track/flight.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/extinction_source.h"
#include "volume/flights.h"

namespace pvol::detail {

/// The scene's tracker is chosen once a flight; it is the same all the time, so the branch costs
/// nothing, and the loops inside know it.
template <class Field, class Count>
[[nodiscard, gnu::flatten]] Flight fly(Tracker tracker, const Field& field, Walk& walk, Rng& rng,
                                       Count& count) {
  switch (tracker) {
    case Tracker::decomposition:
      return free_flight<Tracker::decomposition>(walk, field, rng, count);
    case Tracker::weighted_delta:
      return free_flight<Tracker::weighted_delta>(walk, field, rng, count);
    case Tracker::weighted_decomposition:
      return free_flight<Tracker::weighted_decomposition>(walk, field, rng, count);
    case Tracker::regular:
      if constexpr (CellField<Field>) {
        return free_flight<Tracker::regular>(walk, field, rng, count);
      }
      break;                     // was refused
    case Tracker::delta_global:  // delta on a tree of one terminal
    case Tracker::delta:
      break;
  }
  return free_flight<Tracker::delta>(walk, field, rng, count);
}

template <class Field, class Count>
[[nodiscard]] float estimate_transmittance(Transmittance estimator, Tracker tracker,
                                           const Field& field, Walk& walk, Rng& rng, Count& count) {
  switch (estimator) {
    case Transmittance::ratio:
      return is_weighted(tracker)
                 ? transmittance<Transmittance::ratio, Tracker::weighted_delta>(walk, field, rng,
                                                                                count)
                 : transmittance<Transmittance::ratio, Tracker::delta>(walk, field, rng, count);
    case Transmittance::residual_ratio:
      return transmittance<Transmittance::residual_ratio, Tracker::delta>(walk, field, rng, count);
    case Transmittance::regular:
      if constexpr (CellField<Field>) {
        return transmittance<Transmittance::regular, Tracker::delta>(walk, field, rng, count);
      }
      break;                        // was refused
    case Transmittance::automatic:  // was resolved
    case Transmittance::analog:
      break;
  }
  const Flight f = fly(tracker, field, walk, rng, count);
  return f.collided ? 0.0f : f.weight;
}

/// A field that ends flights once it is to stop, however many null collisions lie ahead: all it is
/// asked about collides, and nothing passes it.
template <class Field>
struct CancellableField : Field {
  const std::atomic<bool>& stop;

  template <class Count>
  [[nodiscard]] float extinction(const Segment& s, const LatticePoint& p, Count& count) const {
    if (stop.load(std::memory_order_relaxed)) return s.hi;
    return Field::extinction(s, p, count);
  }

  template <class Count>
  [[nodiscard]] bool exceeds(const Segment& s, const LatticePoint& p, float mu,
                             Count& count) const {
    return stop.load(std::memory_order_relaxed) || Field::exceeds(s, p, mu, count);
  }
};

template <class Field>
[[nodiscard]] CancellableField<Field> cancellable(const Field& field,
                                                  const FlightMonitor& monitor) {
  return {field, *monitor.stop};
}

/// Flights through what kMake(field, monitor) makes of a volume's field.
template <auto kMake>
[[nodiscard]] Flights make_flights() {
  return {[](Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng, FlightMonitor& monitor) {
            Tally& tally = monitor;
            return fly(tracker, cancellable(kMake(f, monitor), monitor), walk, rng, tally);
          },
          [](Transmittance estimator, Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng,
             FlightMonitor& monitor) {
            Tally& tally = monitor;
            return estimate_transmittance(
                estimator, tracker, cancellable(kMake(f, monitor), monitor), walk, rng, tally);
          }};
}

/// Of fields without maps.
template <LookUp kLookUp, bool kShared>
[[nodiscard]] Flights find_plain_flights(Squeeze squeeze) {
  return visit_squeeze<kLookUp>(squeeze, [](auto kind) {
    return make_flights<[](const VolumeField& f, const FlightMonitor&) {
      return make_field<kLookUp, decltype(kind)::value, kShared>(f);
    }>();
  });
}

template <LookUp kLookUp>
Flights find_flights_of(const FieldKind& kind) {
  static_assert(
      has_closed_form(kLookUp) ==
      CellField<decltype(make_field<kLookUp, Squeeze::none>(std::declval<const VolumeField&>()))>);
  if constexpr (has_closed_form(kLookUp)) {
    if (kind.mapped) {
      return make_flights<[](const VolumeField& f, const FlightMonitor&) {
        return PlainField{mapped_source<kLookUp>(f)};
      }>();
    }
    if (kind.shared) return find_plain_flights<kLookUp, true>(kind.squeeze);
  }
  return find_plain_flights<kLookUp, false>(kind.squeeze);
}

}  // namespace pvol::detail
