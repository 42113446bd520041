// Flights through volumes that lanes do not serve, along walks through their octrees: for every
// tracker, every estimator of the transmittance, and fields of any size and density. Their places
// are those of rays in the world, in doubles.

#if defined(PVOL_LANE_ONE_BY_ONE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_ONE_BY_ONE_INL_H
#undef PVOL_LANE_ONE_BY_ONE_INL_H
#else
#define PVOL_LANE_ONE_BY_ONE_INL_H
#endif

#include "render/engine/wavefront/meet-inl.h"
#include "render/path/first_collision.h"
#include "volume/chromatic_flights.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Stream of a record's random numbers for its flight, as kOnTheWay.
inline constexpr std::uint64_t kFlight = 4;

/// How a flight ended, and the factor on what its ray carries.
struct Flown {
  bool collided;
  double t;
  Rgb weight;
};

/// Of a ray that carries so much in each channel.
[[nodiscard]] inline Flown fly_to_collision(const PathSetup& s, const VolumeSetup& v, Rgb carried,
                                            Walk& walk, Rng& rng, FlightMonitor& monitor) {
  const VolumeField& field = v.volume.density;
  if (s.by_channel) {
    const Rgb share = v.volume.medium.extinction_color;
    const ChromaticFlight f = fly_chromatic(field, share, carried, walk, rng, monitor);
    return {f.collided, f.t, f.weight};
  }
  const Flight f = v.flights.fly(s.options.tracker, field, walk, rng, monitor);
  return {f.collided, f.t, Rgb(f.weight)};
}

/// Of a shadow ray: its weight is an estimate of the transmittance, and no weight is a collision.
[[nodiscard]] inline Flown fly_through(const PathSetup& s, const VolumeSetup& v, Walk& walk,
                                       Rng& rng, FlightMonitor& monitor) {
  const VolumeField& field = v.volume.density;
  Rgb passed;
  if (s.by_channel) {
    const Rgb share = v.volume.medium.extinction_color;
    passed = chromatic_transmittance(field, share, walk, rng, monitor);
  } else {
    const RenderOptions& o = s.options;
    passed = Rgb(v.flights.transmittance(o.transmittance, o.tracker, field, walk, rng, monitor));
  }
  return {!(largest(passed) > 0), kEndless, passed};
}

/// Adds what a flight has done to the counts of all, and to those of its sample.
inline void add_work(const WavefrontScene& s, WavefrontMemory& m, std::uint32_t id,
                     const Tally& done, Tally& all) {
  if (!s.count) return;
  all.lookups += done.lookups, all.bounds_tests += done.bounds_tests;
  all.segments += done.segments, all.null_collisions += done.null_collisions;
  auto& counts = m.slots.counts[slot_of(id)];
  counts[std::size_t(PixelCounter::lookups)] += std::uint32_t(done.lookups);
  counts[std::size_t(PixelCounter::bounds_tests)] += std::uint32_t(done.bounds_tests);
  counts[std::size_t(PixelCounter::segments)] += std::uint32_t(done.segments);
}

/// Multiplies what a record carries, or of a grey shadow ray the share of its light that arrives.
template <class ComponentKind>
void weigh_record(const WavefrontScene& s, bool shadow, Rgb weight, Records& q, std::size_t at) {
  if (shadow && !s.setup.by_channel) {
    q[kPdf][at] *= weight.x;
    return;
  }
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) q[kW0 + c][at] *= weight[int(c)];
}

/// A record of the slice flies through the instance that its ray enters next.
template <class ComponentKind>
void fly_one(const World& w, const WavefrontScene& s, std::size_t at, Tally& tally) {
  WavefrontMemory& m = w.m;
  Records& q = m.flying;
  const std::uint32_t number = q.bits(kRay)[at];
  WorldRay& r = m.rays[number];
  const Visits::Visit visit = r.visits[r.next - 1];
  Instance moved;
  const Instance& instance = w.setup.instances->at_time(visit.instance, double(r.time), moved);
  Walk walk = walk_through(s.volume, instance, r.ray, visit.t0, r.end() - visit.t0);
  Rng rng(q.bits(kRng0)[at], q.bits(kRng1)[at], kFlight);
  FlightMonitor monitor{{}, w.setup.stop, r.time};
  const bool shadow = r.kind == RayKind::shadow;
  const Flown f = shadow ? fly_through(w.setup, s.volume, walk, rng, monitor)
                         : fly_to_collision(w.setup, s.volume, weight_at<ComponentKind>(q, at),
                                            walk, rng, monitor);
  add_work(s, m, q.bits(kId)[at], monitor, tally);
  if (shadow && f.collided) return m.rays.remove(number);
  weigh_record<ComponentKind>(s, shadow, f.weight, q, at);
  if (f.collided && visit.t0 + f.t < r.end()) {
    r.nearest = visit.t0 + f.t, r.hit = visit.instance;
    r.cells = Vec3f(instance.in_cells(r.ray).at(r.nearest) + Vec3d(DenseBounds::kBorder));
  }
  const float depth = rng.tentative().depth;
  const Philox::Block state = rng.block();
  go_on<ComponentKind>(w, number,
                       {q, at, depth, std::uint32_t(state.lo) | 1, std::uint32_t(state.hi)});
}

/// Rays of a queue fly, each to its collision or to its end.
template <class ComponentKind>
HWY_NOINLINE void fly_one_by_one(const World& w, const WavefrontScene& s, Records& queue,
                                 Tally& tally) {
  queue.take_last(slice_of(s), s.fields, w.m.flying);
  for (std::size_t at = 0; at < w.m.flying.n && !w.setup.stopped(); ++at) {
    fly_one<ComponentKind>(w, s, at, tally);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
