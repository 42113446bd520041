// A batch of samples through many volumes, or one at many places, which may overlap: a ray flies
// through each instance on its way as if that were alone, and the nearest collision counts
// (THEORY.md, T3.8).

#if defined(PVOL_LANE_MANY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MANY_INL_H
#undef PVOL_LANE_MANY_INL_H
#else
#define PVOL_LANE_MANY_INL_H
#endif

#include "render/engine/wavefront/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// What a scene's rays share; scenes are those of its volumes, by number.
struct ManyVolumesAtOnce {
  std::span<const WavefrontScene> scenes;
  const PathSetup& setup;
  WavefrontMemory& m;
  Work& work;

  [[nodiscard]] const Instance& instance(std::uint32_t i) const { return setup.instances->all[i]; }
};

/// A record that waits for where its ray goes next, with the numbers for its next flight.
struct Waiting {
  const Records& q;
  std::size_t at;
  RayKind kind;
  float depth;
  std::uint32_t rng0, rng1;
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

/// Puts a ray where it enters an instance.
inline void enter(const ManyVolumesAtOnce& w, std::uint32_t number, const WorldRay::Visit& visit,
                  const Waiting& of) {
  const WorldRay& r = w.m.rays[number];
  const Instance& in = w.instance(visit.instance);
  const WavefrontScene& s = w.scenes[in.volume];
  Records& to = w.m.queues[in.volume][std::size_t(of.kind)];
  const std::size_t n = put_waiting(number, of, to);
  const Ray cells = in.in_cells(r.ray);
  const Vec3d place = cells.at(visit.t0) + Vec3d(DenseBounds::kBorder);
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = std::size_t(axis);
    to[kX + k][n] = std::clamp(float(place[axis]), s.field.low[axis], s.field.high[axis]);
    to[kStepX + k][n] = float(cells.d[axis]);
  }
  to[kLeft][n] = float(std::min(r.end() - visit.t0, 0x1p100));
  to[kDepth][n] = of.depth;
}

/// Puts a path that has collided among the collisions of the volume.
inline void put_hit(const ManyVolumesAtOnce& w, std::uint32_t number, const Waiting& of) {
  WorldRay& r = w.m.rays[number];
  r.within = r.hit;
  Records& to = w.m.hits[w.instance(r.hit).volume];
  const std::size_t n = put_waiting(number, of, to);
  for (std::size_t k = 0; k < 3; ++k) to[kX + k][n] = r.cells[int(k)];
  if (const Importance* const importance = w.setup.importance.get()) {
    to.bits(kAux)[n] = importance->cells().row(WorldPlace{r.place});
  }
}

/// A ray has met all that lies on its way: its nearest collision, its light, or nothing.
template <class ComponentKind>
void finish_ray(const ManyVolumesAtOnce& w, std::uint32_t number, const Waiting& of) {
  WavefrontMemory& m = w.m;
  WorldRay& r = m.rays[number];
  const WavefrontScene& s = w.scenes.front();
  const std::uint32_t id = of.q.bits(kId)[of.at];
  if (of.kind == RayKind::shadow) {
    end_shadow_ray<ComponentKind>(s, m, of.q, of.at);
    return m.rays.remove(number);
  }
  const bool collided = r.hit != WorldRay::kNowhere, seen = of.kind == RayKind::camera;
  FlightLine flight{r.ray.o, direction_at(of.q, of.at), kEndless};
  if (collided) {
    r.place = r.ray.at(r.nearest);
    flight.length = r.nearest;
    flight.end = {&w.setup.volumes[w.instance(r.hit).volume],
                  Vec3d(r.cells) - Vec3d(DenseBounds::kBorder)};
  }
  const Rgb weight = seen ? Rgb(1.0f) : weight_at<ComponentKind>(of.q, of.at);
  Rng rng(of.rng0, of.rng1, kOnTheWay);
  if (of.kind == RayKind::to_fire) {
    add_fire(m, id, emission_of(w.setup, flight, rng) * weight);
    return m.rays.remove(number);
  }
  if (w.setup.flights_bring_light()) {
    m.slots.add(slot_of(id), number_of(id), [&](PathResult& to) {
      const auto pdf = [&] { return seen ? 0.0f : of.q[kPdf][of.at]; };
      detail::add_on_the_way(w.setup, flight, pdf, weight, rng, to);
    });
  }
  if (collided) {
    if (seen) add_first_collision(w.setup, m, slot_of(id), r.place);
    return put_hit(w, number, of);
  }
  if (seen) {
    see_behind(w.setup, m, slot_of(id), direction_at(of.q, of.at));
  } else {
    end_path<ComponentKind>(s, m, of.q, of.at);
  }
  m.rays.remove(number);
}

template <class ComponentKind>
void go_on(const ManyVolumesAtOnce& w, std::uint32_t number, const Waiting& of) {
  WorldRay& r = w.m.rays[number];
  if (const WorldRay::Visit* const visit = w.m.rays.next_visit(w.setup, r, w.work)) {
    enter(w, number, *visit, of);
  } else {
    finish_ray<ComponentKind>(w, number, of);
  }
}

/// A ray has left an instance, or has collided there.
template <class ComponentKind>
void arrive(const ManyVolumesAtOnce& w, bool collided, const Waiting& of) {
  const std::uint32_t number = of.q.bits(kRay)[of.at];
  WorldRay& r = w.m.rays[number];
  if (collided) {
    if (of.kind == RayKind::shadow) return w.m.rays.remove(number);
    r.hit = r.visits[r.next - 1].instance;
    const Ray cells = w.instance(r.hit).in_cells(r.ray);
    const double t = dot(cells_at(of.q, of.at) - cells.o, cells.d) / dot(cells.d, cells.d);
    r.nearest = std::clamp(t, 0.0, r.end());
    r.cells = {of.q[kX][of.at], of.q[kY][of.at], of.q[kZ][of.at]};
  }
  go_on<ComponentKind>(w, number, of);
}

/// arrive() for records of a queue, those that `which` names or the first.
template <class ComponentKind>
HWY_NOINLINE void arrive_all(const ManyVolumesAtOnce& w, RayKind kind, bool collided,
                             const Records& q, const std::uint32_t* which, std::size_t n) {
  alignas(64) float depth[kLanes];
  alignas(64) std::uint32_t rng0[kLanes], rng1[kLanes], at[kLanes];
  for (std::size_t k = 0; k < n; k += kLanes) {
    const U all = which == nullptr ? hn::Iota(kU, std::uint32_t(k)) : load(which + k);
    const I index = where(first(n - k), as_int(all));
    Random rng{gather(q.bits(kRng0), index), gather(q.bits(kRng1), index)};
    store(rng.exponential(), depth);
    store(rng.s0, rng0), store(rng.s1, rng1), store(as_bits(index), at);
    for (std::size_t i = 0; i < std::min(kLanes, n - k); ++i) {
      arrive<ComponentKind>(w, collided, {q, at[i], kind, depth[i], rng0[i], rng1[i]});
    }
  }
}

template <class ComponentKind>
HWY_NOINLINE void fly_in(const ManyVolumesAtOnce& w, std::size_t volume, RayKind kind) {
  WavefrontMemory& m = w.m;
  const WavefrontScene& s = w.scenes[volume];
  const bool shadow = kind == RayKind::shadow || kind == RayKind::to_fire;
  Tally& tally = shadow ? m.counts.shadow : m.counts.path;
  Records& queue = m.queues[volume][std::size_t(kind)];
  take_and_fly<true>(s, m, queue, tally);
  if (kind == RayKind::shadow && s.ratio) {
    weigh(s, m, queue, tally, [&](std::uint32_t at) { m.rays.remove(m.flying.bits(kRay)[at]); });
  } else {
    decide(s, m, queue, &m.arrived, tally);
  }
  // What has left is told first: what arrives goes into queues, not into the slice.
  arrive_all<ComponentKind>(w, kind, false, m.flying, m.events.gone_source.data(), m.events.gone);
  arrive_all<ComponentKind>(w, kind, true, m.arrived, nullptr, m.arrived.n);
  m.arrived.n = 0;
}

/// Sends rays that collisions have made into the world.
template <class ComponentKind>
HWY_NOINLINE void aim_all(const ManyVolumesAtOnce& w, RayKind kind, Records& q) {
  for (std::size_t at = 0; at < q.n; ++at) {
    const WorldRay& parent = w.m.rays[q.bits(kRay)[at]];
    const Ray ray{parent.place, Vec3d(direction_at(q, at))};
    const double left = kind == RayKind::shadow ? double(q[kLeft][at]) : kEndless;
    const std::uint32_t number = w.m.rays.add(ray, left < 0x1p99 ? left : kEndless, parent.within);
    go_on<ComponentKind>(w, number,
                         {q, at, kind, q[kDepth][at], q.bits(kRng0)[at], q.bits(kRng1)[at]});
  }
  q.n = 0;
}

template <bool kGuided, class ComponentKind>
void collide_in(const ManyVolumesAtOnce& w, std::size_t volume) {
  WavefrontMemory& m = w.m;
  const WavefrontScene& s = w.scenes[volume];
  std::swap(m.collisions, m.hits[volume]);
  const std::size_t parents = m.collisions.n;
  collide<kGuided, ComponentKind>(s, m);
  scatter<ComponentKind>(s, m.straight, m.paths);
  if constexpr (kGuided) scatter_guided<ComponentKind>(s, m.turned, m.paths);
  aim_all<ComponentKind>(w, RayKind::shadow, m.shadows);
  aim_all<ComponentKind>(w, RayKind::to_fire, m.to_fires);
  aim_all<ComponentKind>(w, RayKind::path, m.paths);
  for (std::size_t k = 0; k < parents; ++k) m.rays.remove(m.collisions.bits(kRay)[k]);
  std::swap(m.collisions, m.hits[volume]);
}

/// A sample's ray of the camera.
template <class ComponentKind>
void start(const ManyVolumesAtOnce& w, const Samples::Sample& sample, std::uint32_t slot,
           const Film& film) {
  auto [rng, ray] = CameraSample(w.setup, film.x + sample.x, film.y + sample.y,
                                 film.first_sample + sample.number);
  Records& q = w.m.camera;
  for (int axis = 0; axis < 3; ++axis) q[kDX + std::size_t(axis)][0] = float(ray.d[axis]);
  for (const std::size_t f : {std::size_t(kW0), std::size_t(kW1), std::size_t(kW2)}) q[f][0] = 1;
  q[kPdf][0] = 0;
  q.bits(kId)[0] = slot;
  const float depth = rng.tentative().depth;
  const Philox::Block state = rng.block();
  const std::uint32_t number = w.m.rays.add(ray, kEndless, WorldRay::kNowhere);
  go_on<ComponentKind>(
      w, number,
      {q, 0, RayKind::camera, depth, std::uint32_t(state.lo) | 1, std::uint32_t(state.hi)});
}

/// The fullest of the queues.
struct Fullest {
  std::size_t volume = 0;
  RayKind kind = RayKind::camera;
  std::size_t n = 0;

  explicit Fullest(const WavefrontMemory& m) {
    for (std::size_t v = 0; v < m.queues.size(); ++v) {
      for (std::size_t k = kRayKinds; k-- > 0;) {
        if (m.queues[v][k].n > n) volume = v, kind = RayKind(k), n = m.queues[v][k].n;
      }
    }
  }
};

/// Collides where there are at least so many collisions.
template <bool kGuided, class ComponentKind>
void collide_where(const ManyVolumesAtOnce& w, std::size_t least) {
  for (std::size_t v = 0; v < w.scenes.size(); ++v) {
    if (w.m.hits[v].n >= least) collide_in<kGuided, ComponentKind>(w, v);
  }
}

/// Traces and adds a tile's samples; see WavefrontKernel.
template <bool kGuided, class ComponentKind>
bool trace_many(std::span<const WavefrontScene> scenes, WavefrontMemory& m, const ImagePart& tile,
                const SampleTargets& targets, Film& film, Counts& counts) {
  const PathSetup& setup = scenes.front().setup;
  Work work(setup);
  const ManyVolumesAtOnce w{scenes, setup, m, work};
  Samples samples(tile, targets, film);
  m.slots.start(count_samples(tile, targets, film));
  m.counts = {};
  m.rays.clear();
  for (auto& kinds : m.queues) {
    for (Records& q : kinds) q.n = 0;
  }
  for (Records& q : m.hits) q.n = 0;
  m.paths.n = m.shadows.n = m.to_fires.n = m.straight.n = m.turned.n = m.arrived.n = 0;
  constexpr std::size_t kEnough = 16 * kLanes;  // collisions that fill registers
  std::uint32_t next = 0;
  for (;;) {
    if (setup.stop->load(std::memory_order_relaxed)) return false;
    const Fullest fullest(m);
    if (fullest.n >= kSlice || (fullest.n > 0 && !samples.any())) {
      fly_in<ComponentKind>(w, fullest.volume, fullest.kind);
    } else if (samples.any()) {
      for (std::size_t k = 0; k < kSlice && samples.any(); ++k) {
        start<ComponentKind>(w, samples.next(), next++, film);
      }
    } else {
      std::size_t left = 0;
      for (const Records& q : m.hits) left += q.n;
      if (left == 0) break;
      collide_where<kGuided, ComponentKind>(w, 1);
    }
    collide_where<kGuided, ComponentKind>(w, kEnough);
  }
  finish(setup, m, tile, targets, film);
  m.counts.shell_tests = work.shell_tests;
  m.counts.shell_rejections = work.shell_rejections;
  if (setup.count) counts += m.counts;
  return true;
}

[[nodiscard]] inline WavefrontKernel find_kernel(bool guided, bool one_lobe, bool many) {
  if (many) {
    if (guided) return one_lobe ? &trace_many<true, OneLobe> : &trace_many<true, AnyComponent>;
    return one_lobe ? &trace_many<false, OneLobe> : &trace_many<false, AnyComponent>;
  }
  if (guided) return one_lobe ? &trace<true, OneLobe> : &trace<true, AnyComponent>;
  return one_lobe ? &trace<false, OneLobe> : &trace<false, AnyComponent>;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
