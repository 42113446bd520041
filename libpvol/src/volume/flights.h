// Flights and transmittances through a volume's field, compiled once for each kind of field: paths,
// photons and the embedder's samples share them.
#pragma once

#include "pvol/bounds/walk.h"
#include "pvol/math/rng.h"
#include "pvol/track/tally.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/volume.h"

namespace pvol::detail {

/// The loops for one kind of field, along a walk through its octree.
struct Flights {
  Flight (*fly)(Tracker, const VolumeField&, Walk&, Rng&, Tally&);
  /// An estimate of the transmittance; flights of `analog` are those of the tracker.
  float (*pass)(Transmittance, Tracker, const VolumeField&, Walk&, Rng&, Tally&);
};

/// For fields of this look-up; `micro_edge` is that of the micro-bounds which they have and which
/// are to be used, or 0. Without `count` tallies stay as they are. Estimators that are chosen by
/// volume (`automatic`), and closed forms (`regular`) for fields that have none, were refused
/// before.
[[nodiscard]] Flights find_flights(LookUp look_up, int micro_edge, bool count);

/// The same for one way of look-up (flights_of.h). Each is instantiated in a source of its own,
/// made of flights_of.cpp.in by the list in libpvol/CMakeLists.txt.
template <LookUp kLookUp>
[[nodiscard]] Flights find_flights_of(int micro_edge, bool count);

}  // namespace pvol::detail
