// Shadow rays to lamps from all along flights (THEORY.md, T5.25), flight by flight.

#if defined(PVOL_LANE_LAMPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_LAMPS_INL_H
#undef PVOL_LANE_LAMPS_INL_H
#else
#define PVOL_LANE_LAMPS_INL_H
#endif

#include "render/engine/wavefront/paths-inl.h"
#include "render/path/lamps_along.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Streams of a record's random numbers, for the lamps along its flight and for rays to them.
inline constexpr std::uint64_t kLamps = 6, kToLamp = 7;

/// The flight through the scene's volume of a record that has collided there, or `left`.
[[nodiscard]] inline FlightThrough flight_through(const WavefrontScene& s, WavefrontMemory& m,
                                                  const Records& q, std::size_t at, bool left) {
  const Vec3d d(direction_at(q, at));
  if (s.many && is_within(q.bits(kRay)[at])) {
    const std::uint32_t instance = instance_within(q.bits(kRay)[at]);
    const Affine& to_world = s.setup.free_radii.of(instance).to_world;
    const Ray world{to_world.point(cells_at(q, at, kFromX)), d};
    const double end = length(to_world.point(cells_at(q, at)) - world.o);
    return {s.volume, world, s.setup.instances->all[instance].in_cells(world), end, q[kTime][at]};
  }
  if (s.many) {
    const WorldRay& r = m.rays[q.bits(kRay)[at]];
    Instance moved;
    const Instance& here = s.setup.instances->at_time(r.hit, double(r.time), moved);
    return {s.volume, {r.ray.o, d}, here.in_cells(r.ray), r.nearest, r.time};
  }
  const Ray world{world_place(s, q, at, kFromX), d};
  const double end = left ? kEndless : length(world_place(s, q, at) - world.o);
  return {s.volume, world, s.volume.in_cells(world), end, 0};
}

/// Keeps the flights of a register's paths for what their collisions bring of lamps: those of the
/// `lanes` of collisions from this number on.
HWY_NOINLINE void keep_flights(const WavefrontScene& s, WavefrontMemory& m, std::size_t from,
                               std::uint32_t lanes) {
  m.colliding.resize(kLanes);
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    m.colliding[k].emplace(flight_through(s, m, m.collisions, from + k, false));
  }
}

/// send(ray, random numbers of its own) for shadow rays to lamps from a flight of a path of this
/// weight.
template <class Send>
void ask_lamps(const WavefrontScene& s, WavefrontMemory& m, const FlightThrough& f, Rgb weight,
               std::uint32_t id, Rng& rng, const Send& send) {
  // So many times more rays than from a collision that brings as much: a pixel sees the light of
  // all its flights, and few collisions.
  constexpr float kMoreRays = 16;
  const PathSetup& setup = s.setup;
  if (number_of(id) >= setup.max_bounces) return;
  detail::ask_lamps(
      f, setup.lamps, *setup.light.many, m.light_cut, rng, [&](std::size_t i, float times) {
        if (setup.lamp_pilot != nullptr) ++setup.lamp_pilot->flights;
        const auto p = draw_lamp_point(f, setup.light.sources[i], setup.lamps[i], rng);
        const Rgb own = s.lights[i].radiance;
        if (!p || !(largest(own) > 0)) return;
        LampRay ray{p->place, p->towards.direction, p->towards.distance,
                    weight * p->factor * (times * (largest(p->towards.radiance) / largest(own))),
                    slot_of(id) | std::uint32_t(i) << 16};
        if (setup.lamp_pilot != nullptr) {
          const auto brought = double(absolute_luminance(ray.weight * own));
          note_lamp(*setup.lamp_pilot, brought, *p, double(times));
        }
        if (s.orders) ray.id |= std::min<std::uint32_t>(number_of(id) + 1, 2) << 30;
        const float value = kMoreRays * absolute_luminance(ray.weight * own) /
                            setup.light.shadow_unit * m.slots.importance_of(slot_of(id));
        if (!(value > 0) || (value < 1 && !(rng.uniform() < value))) return;
        if (value < 1) ray.weight *= 1 / value;
        const Philox::Block state = rng.block();
        ++m.counts.shadow_rays;
        send(ray, Rng(std::uint32_t(state.lo), std::uint32_t(state.hi), kToLamp));
      });
}

/// Those of a record's flight through the one volume of a scene, which has collided or `left`.
inline void ask_lamps(const WavefrontScene& s, WavefrontMemory& m, const Records& q, std::size_t at,
                      bool left, Rgb weight) {
  Rng own(q.bits(kRng0)[at], q.bits(kRng1)[at], kLamps);
  Records& to = m.shadows;
  to.reserve(std::size_t(kAskedAlong));
  ask_lamps(s, m, flight_through(s, m, q, at, left), weight, q.bits(kId)[at], own,
            [&](const LampRay& ray, Rng rng) {
              const Vec3d place = s.volume.volume.density.world_to_cells.point(ray.from);
              const std::size_t n = put_ray(s.field, to, place, ray.direction, rng);
              to[kW0][n] = ray.weight.x, to[kW1][n] = ray.weight.y, to[kW2][n] = ray.weight.z;
              to[kPdf][n] = 1;
              to[kLeft][n] = float(ray.distance);
              to.bits(kId)[n] = ray.id;
            });
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
