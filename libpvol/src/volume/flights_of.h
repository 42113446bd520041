// The loops behind flights.h: from a tracker's or an estimator's name to the code for it.
#pragma once

#include <utility>

#include "pvol/track/flight.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/extinction_source.h"
#include "volume/flights.h"

namespace pvol::detail {

/// Flights that ask on which side of a number the extinction lies, which bounds may decide.
template <class Field, class Count>
[[nodiscard, gnu::flatten]] Flight fly_by_decisions(Tracker tracker, const Field& field, Walk& walk,
                                                    Rng& rng, Count& count) {
  return tracker == Tracker::decomposition
             ? free_flight<Tracker::decomposition>(walk, field, rng, count)
             : free_flight<Tracker::delta>(walk, field, rng, count);
}

/// The other flights. Not inlined: they are the same whatever decides collisions.
template <class Field, class Count>
[[nodiscard, gnu::flatten, gnu::noinline]] Flight fly_by_look_ups(Tracker tracker,
                                                                  const Field& field, Walk& walk,
                                                                  Rng& rng, Count& count) {
  if constexpr (CellField<Field>) {  // others were refused
    if (tracker == Tracker::regular) {
      return free_flight<Tracker::regular>(walk, field, rng, count);
    }
  }
  return tracker == Tracker::weighted_delta
             ? free_flight<Tracker::weighted_delta>(walk, field, rng, count)
             : free_flight<Tracker::weighted_decomposition>(walk, field, rng, count);
}

/// Transmittances by other than flights.
template <class Field, class Count>
[[nodiscard, gnu::noinline]] float transmittance_by_look_ups(Transmittance estimator,
                                                             Tracker tracker, const Field& field,
                                                             Walk& walk, Rng& rng, Count& count) {
  if constexpr (CellField<Field>) {  // others were refused
    if (estimator == Transmittance::regular) {
      return transmittance<Transmittance::regular, Tracker::delta>(walk, field, rng, count);
    }
  }
  if (estimator == Transmittance::residual_ratio) {
    return transmittance<Transmittance::residual_ratio, Tracker::delta>(walk, field, rng, count);
  }
  return is_weighted(tracker)
             ? transmittance<Transmittance::ratio, Tracker::weighted_delta>(walk, field, rng, count)
             : transmittance<Transmittance::ratio, Tracker::delta>(walk, field, rng, count);
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

/// Flights through what kMake(field, monitor) makes of a volume's field. The scene's tracker is
/// chosen once a flight; it is the same all the time, so the branch costs nothing, and the loops
/// inside know it.
template <auto kMake>
[[nodiscard]] Flight fly(Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng,
                         FlightMonitor& monitor) {
  Tally& tally = monitor;
  const auto field = kMake(f, monitor);
  if (is_weighted(tracker) || tracker == Tracker::regular) {
    return fly_by_look_ups(tracker, cancellable(PlainField{field.source}, monitor), walk, rng,
                           tally);
  }
  return fly_by_decisions(tracker, cancellable(field, monitor), walk, rng, tally);
}

template <auto kMake>
[[nodiscard]] Flights make_flights() {
  return {fly<kMake>, [](Transmittance estimator, Tracker tracker, const VolumeField& f, Walk& walk,
                         Rng& rng, FlightMonitor& monitor) {
            if (estimator == Transmittance::analog) {
              const Flight flight = fly<kMake>(tracker, f, walk, rng, monitor);
              return flight.collided ? 0.0f : flight.weight;
            }
            Tally& tally = monitor;
            return transmittance_by_look_ups(
                estimator, tracker, cancellable(PlainField{kMake(f, monitor).source}, monitor),
                walk, rng, tally);
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
