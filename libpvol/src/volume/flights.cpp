#include "volume/flights.h"

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

Flights find_flights(const FieldKind& kind, Watching watching) {
  if (kind.mapped) {
    return kind.look_up == LookUp::nearest
               ? find_mapped_flights_of<LookUp::nearest>(watching == Watching::stop)
               : find_mapped_flights_of<LookUp::trilinear>(watching == Watching::stop);
  }
  return visit_look_up(kind.look_up, [&](auto look_up) {
    if constexpr (look_up != LookUp::procedural) {
      if (kind.moving) return find_moving_flights_of<look_up>(watching != Watching::none);
    }
    return watching == Watching::stop
               ? find_watched_flights_of<look_up>(kind.micro_edge)
               : find_flights_of<look_up>(kind.micro_edge, watching == Watching::count);
  });
}

}  // namespace pvol::detail
