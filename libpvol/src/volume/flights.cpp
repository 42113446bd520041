#include "volume/flights.h"

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

Flights find_flights(LookUp look_up, int micro_edge, Watching watching, bool moving) {
  return visit_look_up(look_up, [&](auto kind) {
    if constexpr (kind != LookUp::procedural) {
      if (moving) return find_moving_flights_of<kind>(watching != Watching::none);
    }
    return watching == Watching::stop
               ? find_watched_flights_of<kind>(micro_edge)
               : find_flights_of<kind>(micro_edge, watching == Watching::count);
  });
}

}  // namespace pvol::detail
