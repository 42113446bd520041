#include "volume/chromatic_flights.h"

#include <type_traits>

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {
namespace {

/// A field along which flights end once they are to stop.
template <class Source>
struct CancellableSource : PlainField<Source> {
  const std::atomic<bool>& stop;
  [[nodiscard]] bool ends() const { return stop.load(std::memory_order_relaxed); }
};

}  // namespace

ChromaticFlight fly_chromatic(const VolumeField& field, Rgb share, Rgb throughput, Walk& walk,
                              Rng& rng, FlightMonitor& monitor) {
  Tally& tally = monitor;
  return visit_source(field, [&](const auto& source) {
    const CancellableSource<std::decay_t<decltype(source)>> cancellable{{source}, *monitor.stop};
    return chromatic_flight(walk, cancellable, share, throughput, rng, tally);
  });
}

Rgb chromatic_transmittance(const VolumeField& field, Rgb share, Walk& walk, Rng& rng,
                            FlightMonitor& monitor) {
  Tally& tally = monitor;
  return visit_source(field, [&](const auto& source) {
    const CancellableSource<std::decay_t<decltype(source)>> cancellable{{source}, *monitor.stop};
    return chromatic_transmittance(walk, cancellable, share, rng, tally);
  });
}

}  // namespace pvol::detail
