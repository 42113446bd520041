#include "volume/chromatic_flights.h"

#include <type_traits>

#include "volume/any_source.h"

namespace pvol::detail {
namespace {

/// A field along which flights end once they are to stop.
template <class Source>
struct CancellableSource : PlainField<Source> {
  const std::atomic<bool>& stop;
  [[nodiscard]] bool ends() const { return stop.load(std::memory_order_relaxed); }
};

/// f(cancellable) and its result, of what the field has at the monitor's time.
template <class F>
decltype(auto) visit_cancellable(const VolumeField& field, const FlightMonitor& monitor,
                                 const F& f) {
  return visit_source_at(field, monitor.time, [&](const auto& source) {
    return f(CancellableSource<std::decay_t<decltype(source)>>{{source}, *monitor.stop});
  });
}

}  // namespace

ChromaticFlight fly_chromatic(const VolumeField& field, Rgb share, Rgb throughput, Walk& walk,
                              Rng& rng, FlightMonitor& monitor) {
  Tally& tally = monitor;
  return visit_cancellable(field, monitor, [&](const auto& cancellable) {
    return chromatic_flight(walk, cancellable, share, throughput, rng, tally);
  });
}

Rgb chromatic_transmittance(const VolumeField& field, Rgb share, Walk& walk, Rng& rng,
                            FlightMonitor& monitor) {
  Tally& tally = monitor;
  return visit_cancellable(field, monitor, [&](const auto& cancellable) {
    return chromatic_transmittance(walk, cancellable, share, rng, tally);
  });
}

}  // namespace pvol::detail
