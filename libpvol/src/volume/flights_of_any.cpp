#include "volume/any_source.h"
#include "volume/flights_of.h"

namespace pvol::detail {

Flights flights_of_any() {
  return make_flights<[](const VolumeField& f, const FlightMonitor& monitor) {
    return PlainField{AnyExtinction{f, monitor.time}};
  }>();
}

}  // namespace pvol::detail
