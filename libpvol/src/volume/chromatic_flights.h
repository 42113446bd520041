// Flights through a volume's field whose extinction differs by channel, compiled once.
#pragma once

#include "pvol/track/chromatic.h"
#include "volume/flights.h"

namespace pvol::detail {

/// See track/chromatic.h. They always count.
[[nodiscard]] ChromaticFlight fly_chromatic(const VolumeField& field, Rgb share, Rgb throughput,
                                            Walk& walk, Rng& rng, FlightMonitor& monitor);
[[nodiscard]] Rgb chromatic_transmittance(const VolumeField& field, Rgb share, Walk& walk, Rng& rng,
                                          FlightMonitor& monitor);

}  // namespace pvol::detail
