#include "volume/flights.h"

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

Flights find_flights(LookUp look_up, int micro_edge, bool count) {
  return visit_look_up(look_up,
                       [&](auto kind) { return find_flights_of<kind>(micro_edge, count); });
}

}  // namespace pvol::detail
