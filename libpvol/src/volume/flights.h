// Flights and transmittances through a volume's field, compiled once for each kind of field: paths,
// photons and the embedder's samples share them.
#pragma once

#include <atomic>

#include "math/philox.h"
#include "pvol/bounds/walk.h"
#include "pvol/track/tally.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/extinction_source.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// For flights that nobody stops.
inline const std::atomic<bool> kNeverStop = false;

/// What flights count, and what ends them: once `stop` is true, they end anywhere, however many
/// null collisions lie ahead, and their results are to be dropped.
struct FlightMonitor : Tally {
  const std::atomic<bool>* stop = &kNeverStop;
  float time = 0;  ///< in frames, of what moves
};

/// The loops for one kind of field, along a walk through its octree.
struct Flights {
  Flight (*fly)(Tracker, const VolumeField&, Walk&, Rng&, FlightMonitor&);
  /// An estimate of the transmittance; flights of `analog` are those of the tracker.
  float (*transmittance)(Transmittance, Tracker, const VolumeField&, Walk&, Rng&, FlightMonitor&);
};

/// What look-ups of fields are.
struct FieldKind {
  LookUp look_up;
  Squeeze squeeze;  ///< none for fields with maps and those that move
  bool mapped = false;
  bool moving = false;
  bool shared = false;  ///< samples are shared
};

/// That of a volume's field.
[[nodiscard]] inline FieldKind kind_of(const VolumeField& f) {
  return {f.look_up, squeeze_of(f), f.map != nullptr, f.motion != nullptr, f.shares_samples()};
}

/// For fields of a kind. Estimators that are chosen by volume (`automatic`), and closed forms
/// (`regular`) for fields that have none, were refused before.
[[nodiscard]] Flights find_flights(const FieldKind& kind);

/// The same among those that are compiled for the processor that all is compiled for, and among
/// those for x86-64-v3: same results to the last bit.
[[nodiscard]] Flights find_baseline_flights(const FieldKind& kind);
[[nodiscard]] Flights find_v3_flights(const FieldKind& kind);

/// For fields of every kind: which look-ups they have is found at each.
[[nodiscard]] Flights flights_of_any();

/// For one way of look-up (flights_of.h). Each is instantiated in a source of its own, made of
/// flights_of.cpp.in by the list in libpvol/CMakeLists.txt. The kind is usual: it stands still, and
/// where it has a map, or shares samples, its look-ups have closed forms.
template <LookUp kLookUp>
[[nodiscard]] Flights find_flights_of(const FieldKind& kind);

}  // namespace pvol::detail
