// The flights for the processor that the program runs on.
#include "math/processor.h"
#include "volume/flights.h"

namespace pvol::detail {

Flights find_flights(const FieldKind& kind, Monitoring monitoring) {
#ifdef PVOL_HAS_V3
  static const bool kHasV3 = has_x86_64_v3();
  if (kHasV3) return find_v3_flights(kind, monitoring);
#endif
  return find_baseline_flights(kind, monitoring);
}

}  // namespace pvol::detail
