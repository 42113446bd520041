// The flights for a kind of field and the processor that the program runs on.
#include "math/processor.h"
#include "pvol/volume/extinction_source.h"
#include "volume/flights.h"

namespace pvol::detail {

Flights find_flights(const FieldKind& kind) {
  const bool unusual_map = kind.mapped && (kind.shared || !has_closed_form(kind.look_up));
  if (kind.moving || unusual_map) return flights_of_any();
#ifdef PVOL_HAS_V3
  static const bool kHasV3 = has_x86_64_v3();
  if (kHasV3) return find_v3_flights(kind);
#endif
  return find_baseline_flights(kind);
}

}  // namespace pvol::detail
