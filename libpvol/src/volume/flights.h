// Flights and transmittances through a volume's field, compiled once for each kind of field: paths,
// photons and the embedder's samples share them.
#pragma once

#include <atomic>

#include "math/philox.h"
#include "pvol/bounds/walk.h"
#include "pvol/track/tally.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// For flights that nobody stops.
inline const std::atomic<bool> kNeverStop = false;

/// What flights count, and what ends cancellable ones: once `stop` is true, they end
/// anywhere, and their results are to be dropped.
struct FlightMonitor : Tally {
  const std::atomic<bool>* stop = &kNeverStop;
  float time = 0;  ///< in frames, of what moves
};

/// Whether flights count what they do, or are cancellable and count: only these end when told to,
/// at the cost of a test at each look-up.
enum class Monitoring { none, count, cancel };

/// The loops for one kind of field, along a walk through its octree.
struct Flights {
  Flight (*fly)(Tracker, const VolumeField&, Walk&, Rng&, FlightMonitor&);
  /// An estimate of the transmittance; flights of `analog` are those of the tracker.
  float (*transmittance)(Transmittance, Tracker, const VolumeField&, Walk&, Rng&, FlightMonitor&);
};

/// What look-ups of fields are: `micro_edge` is that of the micro-bounds which they have and which
/// are to be used, or 0, as it is for fields with maps and for those that move.
struct FieldKind {
  LookUp look_up;
  int micro_edge;
  bool mapped = false;
  bool moving = false;
  bool shared = false;  ///< samples are shared
};

/// That of a volume's field.
[[nodiscard]] inline FieldKind kind_of(const VolumeField& f) {
  return {f.look_up, f.micro.edge, f.map != nullptr, f.motion != nullptr, f.shares_samples()};
}

/// For fields of a kind. Without counts tallies stay as they are. Estimators that are chosen by
/// volume (`automatic`), and closed forms (`regular`) for fields that have none, were refused
/// before.
[[nodiscard]] Flights find_flights(const FieldKind& kind, Monitoring monitoring);

/// The same among those that are compiled for the processor that all is compiled for, and among
/// those for x86-64-v3: same results to the last bit.
[[nodiscard]] Flights find_baseline_flights(const FieldKind& kind, Monitoring monitoring);
[[nodiscard]] Flights find_v3_flights(const FieldKind& kind, Monitoring monitoring);

/// The same for one way of look-up (flights_of.h). Each is instantiated in sources of its own, made
/// of flights_of.cpp.in and cancellable_flights_of.cpp.in by the list in libpvol/CMakeLists.txt.
template <LookUp kLookUp>
[[nodiscard]] Flights find_flights_of(int micro_edge, bool count);
template <LookUp kLookUp>
[[nodiscard]] Flights find_cancellable_flights_of(int micro_edge);
/// Of fields with maps: nearest and trilinear ones. These count always.
template <LookUp kLookUp>
[[nodiscard]] Flights find_mapped_flights_of(bool cancellable);

/// Of fields of which some share samples: nearest and trilinear ones. Always cancellable.
template <LookUp kLookUp>
[[nodiscard]] Flights find_shared_flights_of(int micro_edge);

}  // namespace pvol::detail
