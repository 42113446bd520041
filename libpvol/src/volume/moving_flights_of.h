// The loops behind flights.h for fields in motion: a watch knows the time.
#pragma once

#include "volume/flights_of.h"
#include "volume/moving_field.h"

namespace pvol::detail {

template <LookUp kLookUp, bool kCount>
[[nodiscard]] Flights make_moving_flights() {
  using Field = MovingField<kLookUp>;
  return {[](Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng, Watch& watch) {
            return with_count<kCount>(watch, [&](auto& count) {
              return fly(tracker, Field{f, watch.time, *watch.stop}, walk, rng, count);
            });
          },
          [](Transmittance estimator, Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng,
             Watch& watch) {
            return with_count<kCount>(watch, [&](auto& count) {
              return pass(estimator, tracker, Field{f, watch.time, *watch.stop}, walk, rng, count);
            });
          }};
}

template <LookUp kLookUp>
Flights find_moving_flights_of(bool count) {
  return count ? make_moving_flights<kLookUp, true>() : make_moving_flights<kLookUp, false>();
}

}  // namespace pvol::detail
