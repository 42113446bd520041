// Rays in the world: where they go next, and what becomes of those that have met all that lies on
// their way.

#if defined(PVOL_LANE_WORLD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_WORLD_INL_H
#undef PVOL_LANE_WORLD_INL_H
#else
#define PVOL_LANE_WORLD_INL_H
#endif

#include "render/engine/wavefront/trace-inl.h"
#include "render/path/local_medium.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// What a scene's rays share; scenes are those of its volumes, by number.
struct World {
  std::span<const WavefrontScene> scenes;
  const PathSetup& setup;
  WavefrontMemory& m;
  ShellCounts& shells;
  const CoarseCells* cells;  ///< whose rows collisions have; null: none

  /// A ray in the cells of an instance, where that is at its time.
  [[nodiscard]] Ray in_cells(std::uint32_t i, const WorldRay& r) const {
    Instance moved;
    return setup.instances->at_time(i, double(r.time), moved).in_cells(r.ray);
  }
  [[nodiscard]] std::uint32_t volume_of(std::uint32_t i) const {
    return setup.instances->all[i].volume;
  }
};

/// Streams of a record's random numbers, as kOnTheWay.
inline constexpr std::uint64_t kAhead = 2, kMet = 3;

/// A record that waits for where its ray goes next, with the numbers for its next flight.
struct Waiting {
  const Records& q;
  std::size_t at;
  float depth;
  std::uint32_t rng0, rng1;

  [[nodiscard]] Rng stream(std::uint64_t number) const { return {rng0, rng1, number}; }
};

/// Adds a record of the ray to a queue, with all but its place; returns its number.
inline std::size_t put_waiting(std::uint32_t number, const Waiting& of, Records& to) {
  to.reserve(1);
  const std::size_t n = to.n++;
  for (const std::size_t f :
       {std::size_t(kDX), std::size_t(kDY), std::size_t(kDZ), std::size_t(kW0), std::size_t(kW1),
        std::size_t(kW2), std::size_t(kPdf)}) {
    to[f][n] = of.q[f][of.at];
  }
  to.bits(kRng0)[n] = of.rng0, to.bits(kRng1)[n] = of.rng1;
  to.bits(kId)[n] = of.q.bits(kId)[of.at];
  to.bits(kRay)[n] = number;
  return n;
}

/// What light that comes by the ray to its path is multiplied by; from a shadow catcher that is
/// light that was scattered before.
[[nodiscard]] inline Rgb factor_of(const WorldRay& r) {
  return r.on_catcher ? r.throughput * r.among.factor : Rgb(r.among.factor);
}
template <class ComponentKind>
[[nodiscard]] Rgb path_weight(const WorldRay& r, const Records& q, std::size_t at) {
  return weight_at<ComponentKind>(q, at) * factor_of(r);
}
/// Of light that comes unscattered.
template <class ComponentKind>
[[nodiscard]] Rgb direct_weight(const WorldRay& r, const Records& q, std::size_t at) {
  return weight_at<ComponentKind>(q, at) * r.among.factor;
}

/// put_waiting() where the ray has ended: the record has the weight of the path now.
inline std::size_t put_ended(const WorldRay& r, std::uint32_t number, const Waiting& of,
                             Records& to) {
  const std::size_t n = put_waiting(number, of, to);
  const Rgb factor = factor_of(r);
  to[kW0][n] *= factor.x, to[kW1][n] *= factor.y, to[kW2][n] *= factor.z;
  return n;
}

/// Puts a ray where it enters an instance.
inline void enter(const World& w, std::uint32_t number, const Visits::Visit& visit,
                  const Waiting& of) {
  const WorldRay& r = w.m.rays[number];
  const std::uint32_t volume = w.volume_of(visit.instance);
  const WavefrontScene& s = w.scenes[volume];
  Records& to = w.m.queues[volume][std::size_t(r.kind)];
  const std::size_t n = put_waiting(number, of, to);
  const Ray cells = w.in_cells(visit.instance, r);
  const Vec3d place = cells.at(visit.t0) + Vec3d(DenseBounds::kBorder);
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = std::size_t(axis);
    to[kX + k][n] = std::clamp(float(place[axis]), s.field.low[axis], s.field.high[axis]);
    to[kStepX + k][n] = float(cells.d[axis]);
  }
  to[kTime][n] = r.time;
  to[kLeft][n] = float(std::min(r.end() - visit.t0, 0x1p100));
  to[kDepth][n] = of.depth;
}

/// Puts a path that has collided among the collisions of the volume.
inline void put_hit(const World& w, std::uint32_t number, const Waiting& of) {
  WorldRay& r = w.m.rays[number];
  r.within = r.hit;
  Records& to = w.m.hits[w.volume_of(r.hit)];
  const std::size_t n = put_ended(r, number, of, to);
  for (std::size_t k = 0; k < 3; ++k) to[kX + k][n] = r.cells[int(k)];
  if (w.cells != nullptr) to.bits(kAux)[n] = w.cells->row(r.place);
}

/// The line of a ray as far as it brings light by itself.
[[nodiscard]] inline FlightLine line_of(const World& w, const WorldRay& r, const Records& q,
                                        std::size_t at) {
  FlightLine line{r.ray.o, direction_at(q, at), kEndless, Rgb(0.0f), r.time};
  if (r.collides()) {
    line.length = r.nearest;
  } else if (r.among.surface.material != nullptr) {
    line.length = r.among.surface.distance;
  }
  if (line.length > r.among.direct_until) {
    line.length = r.among.direct_until;
  } else if (r.collides()) {
    const FireAtCollisions* const fire = w.setup.volumes[w.volume_of(r.hit)].fire;
    if (fire != nullptr) line.at_end = fire->source(Vec3d(r.cells) - Vec3d(DenseBounds::kBorder));
  }
  return line;
}

/// How far a ray meets lamps.
[[nodiscard]] inline double end_for_lamps(const WorldRay& r) {
  double end = kEndless;
  if (r.collides()) {
    end = r.nearest;
  } else if (const SurfaceHit& surface = r.among.surface; surface.material != nullptr) {
    end = surface.distance + surface.beyond_for_lamps();
  }
  return std::min(end, r.among.lamps_until);
}

/// Light that a path's ray meets on its way.
template <class ComponentKind>
void add_line(const World& w, const WorldRay& r, const Waiting& of) {
  const PathSetup& s = w.setup;
  const std::uint32_t id = of.q.bits(kId)[of.at];
  const bool scattered = r.kind != RayKind::camera;
  const auto pdf = [&] { return scattered ? of.q[kPdf][of.at] : 0.0f; };
  const Rgb weight = path_weight<ComponentKind>(r, of.q, of.at);
  FlightLine line = line_of(w, r, of.q, of.at);
  if (s.emission) {
    const bool sampled =
        r.off_surface ? s.emission->sampled_on_surfaces : s.emission->sampled_in_volumes;
    Rng rng = of.stream(kOnTheWay);
    const Along along{w.scenes, rng, scattered ? kFewerWhereScattered : 1};
    w.m.slots.add(slot_of(id), number_of(id), [&](PathResult& to) {
      const auto pdf_of_fires = [&] { return sampled ? pdf() : 0.0f; };
      add_along(s, line, pdf_of_fires, weight, along, to);
    });
  }
  if (!s.light.met.any() || (!scattered && s.depths != nullptr)) return;
  line.length = end_for_lamps(r);
  if (r.on_catcher) {
    w.m.slots.add_caught(slot_of(id), [&](PathResult& to) {
      add_met(s, line, pdf, direct_weight<ComponentKind>(r, of.q, of.at), to);
    });
  } else {
    w.m.slots.add(slot_of(id), number_of(id),
                  [&](PathResult& to) { add_met(s, line, pdf, weight, to); });
  }
}

/// Lamps are asked along a path's ray, in each volume on its way.
template <class ComponentKind>
void ask_lamps(const World& w, const WorldRay& r, const Waiting& of) {
  const Ray ray{r.ray.o, Vec3d(direction_at(of.q, of.at))};
  const Rgb weight = path_weight<ComponentKind>(r, of.q, of.at);
  Rng rng = of.stream(kLamps);
  for (std::size_t k = 0; k < r.visits.size(); ++k) {
    const std::uint32_t i = r.visits[k].instance;
    const WavefrontScene& s = w.scenes[w.volume_of(i)];
    if (!s.volume.asks_lamps) continue;
    ask_lamps(s, w.m, {s.volume, ray, w.in_cells(i, r), r.end(), r.time}, weight,
              of.q.bits(kId)[of.at], rng, [&](const LampRay& to, const Rng& own) {
                w.m.to_lamps.push_back({to, r.time, own});
              });
  }
}

/// A shadow ray that nothing has stopped.
template <class ComponentKind>
void finish_shadow_ray(const World& w, const WorldRay& r, const Records& q, std::size_t at) {
  const WavefrontScene& s = w.scenes.front();
  if (r.on_catcher) {
    const std::uint32_t id = q.bits(kId)[at];
    w.m.slots.add_caught(slot_of(id), [&](PathResult& to) {
      add_light(w.setup, light_of(id), arrived_by<ComponentKind>(s, q, at), to);
    });
  } else if (!r.among.hidden) {
    end_shadow_ray<ComponentKind>(s, w.m, q, at);
  }
}

/// A ray of the camera or of a path that has met nothing.
template <class ComponentKind>
void leave(const World& w, const WorldRay& r, const Records& q, std::size_t at) {
  if (r.among.direct_until != kEndless) return;
  const std::uint32_t slot = slot_of(q.bits(kId)[at]);
  const auto pdf = [&] { return q[kPdf][at]; };
  if (r.kind == RayKind::camera) {
    see_behind(w.setup, w.m, slot, direction_at(q, at), weight_at<ComponentKind>(q, at));
  } else if (r.on_catcher) {
    w.m.slots.add_caught(slot, [&](PathResult& to) {
      add_scattered(w.setup, pdf, direction_at(q, at), direct_weight<ComponentKind>(r, q, at), to);
    });
  } else {
    end_path<ComponentKind>(w.scenes.front(), w.m, q, at, r.among.factor);
  }
}

/// What a collision emits on a path that is not scattered there.
template <class ComponentKind>
void add_last_emission(const World& w, const WorldRay& r, const Waiting& of) {
  if (!(r.nearest < r.among.direct_until)) return;
  const VolumeSetup& v = w.setup.volumes[w.volume_of(r.hit)];
  const CollisionPlace here{&v, Vec3d(r.cells) - Vec3d(DenseBounds::kBorder)};
  const LocalMedium medium = local_medium(here, r.time);
  const std::uint32_t id = of.q.bits(kId)[of.at];
  w.m.slots.add(slot_of(id), number_of(id), [&](PathResult& to) {
    add_emitted(w.setup, medium, path_weight<ComponentKind>(r, of.q, of.at), to);
  });
}

/// What a path's flight brings on its way.
template <class ComponentKind>
void add_flight(const World& w, const WorldRay& r, const Waiting& of) {
  if (w.setup.flights_bring_light()) add_line<ComponentKind>(w, r, of);
  if (r.among.scatters && !w.setup.lamps.empty()) ask_lamps<ComponentKind>(w, r, of);
}

/// What a ray towards a fire brings to the path that has asked.
template <class ComponentKind>
void add_fire_ray(const World& w, const WorldRay& r, const Waiting& of) {
  Rng rng = of.stream(kOnTheWay);
  add_fire(w.setup, w.m, of.q, of.at,
           emission_of(w.setup, line_of(w, r, of.q, of.at),
                       Along{w.scenes, rng, kFewerWhereScattered}) *
               weight_at<ComponentKind>(of.q, of.at));
}

/// A ray has met all that lies on its way: its nearest collision, a surface, its light, or nothing.
template <class ComponentKind>
void finish_ray(const World& w, std::uint32_t number, const Waiting& of) {
  WavefrontMemory& m = w.m;
  WorldRay& r = m.rays[number];
  const std::uint32_t id = of.q.bits(kId)[of.at];
  if (r.kind == RayKind::shadow) {
    finish_shadow_ray<ComponentKind>(w, r, of.q, of.at);
    return m.rays.remove(number);
  }
  if (r.kind == RayKind::to_fire) {
    add_fire_ray<ComponentKind>(w, r, of);
    return m.rays.remove(number);
  }
  const bool brings_light = r.kind != RayKind::photon;
  if (brings_light) add_flight<ComponentKind>(w, r, of);
  if (!r.collides() && r.among.surface.material != nullptr) {
    put_ended(r, number, of, m.met);
    return;
  }
  if (!r.collides()) {
    if (brings_light) leave<ComponentKind>(w, r, of.q, of.at);
    return m.rays.remove(number);
  }
  r.place = r.ray.at(r.nearest);
  if (r.kind == RayKind::camera) {
    add_first_collision(w.setup, m, slot_of(id), {r.place, r.hit},
                        weight_at<ComponentKind>(of.q, of.at));
  }
  if (r.among.scatters) return put_hit(w, number, of);
  add_last_emission<ComponentKind>(w, r, of);
  m.rays.remove(number);
}

template <class ComponentKind>
void go_on(const World& w, std::uint32_t number, const Waiting& of) {
  WorldRay& r = w.m.rays[number];
  const Visits::Visit* const visit = w.m.rays.next_visit(w.setup, r, of.stream(kAhead), w.shells);
  if (visit != nullptr) {
    enter(w, number, *visit, of);
  } else {
    finish_ray<ComponentKind>(w, number, of);
  }
}

/// A ray to be sent on its way from a place in the world.
struct Sent {
  RayKind kind;
  Ray ray;
  std::uint32_t id;
  Rgb weight{1.0f};
  Rgb throughput{1.0f};  ///< as of WorldRay
  float pdf = 0;
  double limit = kEndless;
  float time = 0;
  bool off_surface = false, on_catcher = false;  ///< as of WorldRay
};

/// With random numbers that follow on `rng`.
template <class ComponentKind>
void send(const World& w, const Sent& sent, Rng& rng) {
  Records& q = w.m.sent;
  for (int c = 0; c < 3; ++c) {
    q[kDX + std::size_t(c)][0] = float(sent.ray.d[c]);
    q[std::size_t(c == 0 ? std::size_t(kW0) : kW1 + std::size_t(c) - 1)][0] = sent.weight[c];
  }
  q[kPdf][0] = sent.pdf;
  q.bits(kId)[0] = sent.id;
  const float depth = rng.tentative().depth;
  const Philox::Block state = rng.block();
  const std::uint32_t number = w.m.rays.add();
  WorldRay& r = w.m.rays[number];
  r.kind = sent.kind, r.ray = sent.ray, r.limit = sent.limit, r.time = sent.time;
  r.off_surface = sent.off_surface, r.on_catcher = sent.on_catcher;
  if (r.on_catcher) r.throughput = sent.throughput;
  go_on<ComponentKind>(w, number,
                       {q, 0, depth, std::uint32_t(state.lo) | 1, std::uint32_t(state.hi)});
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
