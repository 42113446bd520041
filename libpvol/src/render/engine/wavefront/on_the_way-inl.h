// Light of fires and of lights that flights pass (THEORY.md, T5.11, T5.12), lane by lane.

#if defined(PVOL_LANE_ON_THE_WAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_ON_THE_WAY_INL_H
#undef PVOL_LANE_ON_THE_WAY_INL_H
#else
#define PVOL_LANE_ON_THE_WAY_INL_H
#endif

#include "render/engine/wavefront/along-inl.h"
#include "render/engine/wavefront/lights-inl.h"
#include "volume/simd/values-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Streams of a record's random numbers, for what its flight asks for.
inline constexpr std::uint64_t kOnTheWay = 1;

/// FireAtCollisions::source at a register of records' places, the first of which is `at`.
HWY_NOINLINE void find_fire(const WavefrontScene& s, const Records& q, std::size_t at,
                            PathColors& to) {
  for (auto& channel : to) channel.fill(0);
  const FireAtCollisions& fire = *s.volume.fire;
  const F x = load(q[kX] + at), y = load(q[kY] + at), z = load(q[kZ] + at);
  const SamplePlaces places(fire.fire().field, fire.cells_to_fire(), x, y, z);
  const M on = hn::And(first(q.n - at), places.inside);
  const M held = hn::And(on, is_at_collisions(fire, where(on, places.brick)));
  if (hn::AllFalse(kF, held)) return;
  const VolumeField& density = s.volume.volume.density;
  const F mu = splat(density.scale) * values_at(density, Affine{}, x, y, z);
  const M collide = hn::And(held, hn::Gt(mu, splat(0)));
  const V emitted = emission_at(fire.fire(), places, fire.cells_to_color(), x, y, z, collide);
  const F per_mu = splat(1) / mu;
  const F channels[] = {emitted.x, emitted.y, emitted.z};
  for (std::size_t c = 0; c < 3; ++c) {
    const F source = channels[c] * splat(1 / s.share[int(c)]) * per_mu;
    store(hn::IfThenElseZero(collide, source), to[c].data());
  }
}

/// visit(at, source) for each record from one on, with what a fire brings at its place.
template <class Visit>
HWY_INLINE void visit_ends(const WavefrontScene& s, WavefrontMemory& m, const Records& q,
                           std::size_t from, const Visit& visit) {
  const FireAtCollisions* const fire = s.volume.fire;
  PathColors& found = m.fire;
  for (std::size_t at = from; at < q.n; ++at) {
    if (fire == nullptr) {
      visit(at, Rgb(0.0f));
    } else if (!s.fire_in_lanes) {
      visit(at, fire->source(cells_at(q, at)));
    } else {
      const std::size_t k = (at - from) % kLanes;
      if (k == 0) find_fire(s, q, at, found);
      visit(at, Rgb(found[0][k], found[1][k], found[2][k]));
    }
  }
}

/// The straight line of a record's flight, which has left, or has ended at its place, where a fire
/// brings `at_end`.
[[nodiscard]] inline FlightLine flight_of(const WavefrontScene& s, const Records& q, std::size_t at,
                                          bool left, Rgb at_end) {
  FlightLine flight{world_place(s, q, at, kFromX), direction_at(q, at), kEndless};
  if (left) return flight;
  flight.length = length(world_place(s, q, at) - flight.from);
  flight.at_end = at_end;
  return flight;
}

/// Light that the flight of a record of this weight brings on its way, which has left, or has ended
/// at its place, where a fire brings `at_end`.
inline void add_on_the_way(const WavefrontScene& s, WavefrontMemory& m, const Records& q,
                           std::size_t at, bool left, Rgb at_end, Rgb weight) {
  const FlightLine flight = flight_of(s, q, at, left, at_end);
  Rng rng(q.bits(kRng0)[at], q.bits(kRng1)[at], kOnTheWay);
  const std::uint32_t id = q.bits(kId)[at];
  const float pdf = q[kPdf][at];  // 0: of a camera ray
  const Along along{{&s, 1}, rng, pdf > 0 ? kFewerWhereScattered : 1};
  m.slots.add(slot_of(id), number_of(id), [&](PathResult& r) {
    detail::add_on_the_way(
        s.setup, flight, [&] { return pdf; }, weight, along, r);
  });
}

/// detail::value_of_fire_ray in lanes.
template <class ComponentKind>
HWY_INLINE F value_of_fire_ray(const Paths<ComponentKind>& p, F pdf) {
  constexpr float kEven = 4 * std::numbers::pi_v<float>, kSideways = 4;
  const F luminance = p.luminance() * p.pixel;
  return hn::Min(luminance * hn::Min(splat(kSideways * kEven) * pdf, splat(1)), splat(1));
}

/// Rays from collisions towards fires (THEORY.md, T5.12).
template <class ComponentKind>
HWY_NOINLINE void ask_fires(const WavefrontScene& s, WavefrontMemory& m, Paths<ComponentKind>& p) {
  const LaneStreams streams(p.rng);
  const LanePlaces place(s, m, p);
  TowardsByLane lanes_to;
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    Rng own = streams.of(k, s.lights.size() + 1);
    const EmissionLights::Towards l = s.setup.emission->lights.sample(place(k), place.time(k), own);
    if (l.pdf > 0) lanes_to.set(k, {.direction = l.direction, .radiance = {}, .pdf = l.pdf}, {}, 1);
  }
  const Towards to = lanes_to.in_lanes();
  const F pdf = ComponentKind(s, p.component).pdf(p.from, to.direction);
  const F value = value_of_fire_ray(p, pdf);
  const M chosen = hn::And(hn::And(p.alive, hn::Gt(to.pdf * value, splat(0))),
                           hn::Lt(p.rng.fine_uniform(), value));
  const F weight = pdf / ((to.pdf + pdf) * value);
  Random own = Random::stream(p.rng.seed(), 0);
  Records& q = m.to_fires;
  q.reserve(kLanes);
  pack(chosen, own.exponential(), q[kDepth] + q.n);
  p.put_place(chosen, q);
  p.put_place(chosen, q, kFromX);
  p.put_random(chosen, own, q);
  pack(chosen, to.direction.x, q[kDX] + q.n), pack(chosen, to.direction.y, q[kDY] + q.n);
  pack(chosen, to.direction.z, q[kDZ] + q.n);
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) {
    pack(chosen, p.w[c] * weight, q[kW0 + c] + q.n);
  }
  if (s.setup.pilot != nullptr) pack(chosen, pdf / ((to.pdf + pdf) * value), q[kPdf] + q.n);
  pack(chosen, p.id, q.bits(kId) + q.n);
  if (s.many) pack(chosen, p.ray, q.bits(kRay) + q.n);
  if (s.times) pack(chosen, p.time, q[kTime] + q.n);
  q.n += count(chosen);
  m.counts.shadow_rays += count(chosen);
}

/// Light of fires that reaches the place of a record's ray.
inline void add_fire(const PathSetup& s, WavefrontMemory& m, const Records& q, std::size_t at,
                     Rgb light) {
  if (s.pilot != nullptr) note_sample(*s.pilot, luminance(light), q[kPdf][at]);
  const std::uint32_t id = q.bits(kId)[at];
  m.slots.add(slot_of(id), number_of(id), [&](PathResult& r) {
    r.radiance += light;
    if (r.in_layers()) r.emission() += light;
  });
}

/// What rays towards fires have met, up to where they left, or to their places, where a fire brings
/// `at_end`.
template <class ComponentKind>
inline void end_fire_ray(const WavefrontScene& s, WavefrontMemory& m, const Records& q,
                         std::size_t at, bool left, Rgb at_end) {
  const FlightLine flight = flight_of(s, q, at, left, at_end);
  Rng rng(q.bits(kRng0)[at], q.bits(kRng1)[at], kOnTheWay);
  const Rgb light = emission_of(s.setup, flight, Along{{&s, 1}, rng, kFewerWhereScattered}) *
                    weight_at<ComponentKind>(q, at);
  add_fire(s.setup, m, q, at, light);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
