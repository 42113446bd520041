#include "volume/chromatic_flights.h"

#include <type_traits>

#include "pvol/volume/extinction_source.h"

namespace pvol::detail {
namespace {

/// A field along which flights end once they are to stop.
template <class Source>
struct WatchedSource : PlainField<Source> {
  const std::atomic<bool>& stop;
  [[nodiscard]] bool ends() const { return stop.load(std::memory_order_relaxed); }
};

}  // namespace

ChromaticFlight fly_chromatic(const VolumeField& field, Rgb share, Rgb throughput, Walk& walk,
                              Rng& rng, Watch& watch) {
  Tally& tally = watch;
  return visit_source(field, [&](const auto& source) {
    const WatchedSource<std::decay_t<decltype(source)>> watched{{source}, *watch.stop};
    return chromatic_flight(walk, watched, share, throughput, rng, tally);
  });
}

Rgb pass_chromatic(const VolumeField& field, Rgb share, Walk& walk, Rng& rng, Watch& watch) {
  Tally& tally = watch;
  return visit_source(field, [&](const auto& source) {
    const WatchedSource<std::decay_t<decltype(source)>> watched{{source}, *watch.stop};
    return chromatic_transmittance(walk, watched, share, rng, tally);
  });
}

}  // namespace pvol::detail
