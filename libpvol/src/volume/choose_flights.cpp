// The flights for the processor that the program runs on.
#include "math/processor.h"
#include "volume/flights.h"

namespace pvol::detail {

Flights find_flights(const FieldKind& kind, Watching watching) {
#ifdef PVOL_HAS_V3
  static const bool kHasV3 = has_x86_64_v3();
  if (kHasV3) return find_v3_flights(kind, watching);
#endif
  return find_baseline_flights(kind, watching);
}

}  // namespace pvol::detail
