#include "volume/chromatic_flights.h"

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

ChromaticFlight fly_chromatic(const VolumeField& field, Rgb share, Rgb throughput, Walk& walk,
                              Rng& rng, Watch& watch) {
  Tally& tally = watch;
  return visit_source(field, [&](const auto& source) {
    return chromatic_flight(walk, PlainField{source}, share, throughput, rng, tally);
  });
}

Rgb pass_chromatic(const VolumeField& field, Rgb share, Walk& walk, Rng& rng, Watch& watch) {
  Tally& tally = watch;
  return visit_source(field, [&](const auto& source) {
    return chromatic_transmittance(walk, PlainField{source}, share, rng, tally);
  });
}

}  // namespace pvol::detail
