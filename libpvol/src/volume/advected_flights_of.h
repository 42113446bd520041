// The loops behind flights.h for advected fields; the monitor holds the time.
#pragma once

#include "volume/advected_field.h"
#include "volume/flights_of.h"

namespace pvol::detail {

template <LookUp kLookUp, bool kCount>
[[nodiscard]] Flights make_advected_flights() {
  using Field = AdvectedField<kLookUp>;
  return {[](Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng, FlightMonitor& monitor) {
            return with_count<kCount>(monitor, [&](auto& count) {
              return fly(tracker, Field{f, monitor.time, *monitor.stop}, walk, rng, count);
            });
          },
          [](Transmittance estimator, Tracker tracker, const VolumeField& f, Walk& walk, Rng& rng,
             FlightMonitor& monitor) {
            return with_count<kCount>(monitor, [&](auto& count) {
              return estimate_transmittance(estimator, tracker, Field{f, monitor.time, *monitor.stop},
                                            walk, rng, count);
            });
          }};
}

template <LookUp kLookUp>
Flights find_advected_flights_of(bool count) {
  return count ? make_advected_flights<kLookUp, true>() : make_advected_flights<kLookUp, false>();
}

}  // namespace pvol::detail
