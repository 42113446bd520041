// A batch of samples through many volumes, or one at many places, which may overlap, and among
// surfaces: a ray flies through each instance on its way as if that were alone, and the nearest
// collision counts (THEORY.md, T3.8).

#if defined(PVOL_LANE_MANY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MANY_INL_H
#undef PVOL_LANE_MANY_INL_H
#else
#define PVOL_LANE_MANY_INL_H
#endif

#include "render/engine/wavefront/one_by_one-inl.h"
#include "render/engine/wavefront/within-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A ray has left an instance, or has collided there.
template <class ComponentKind>
void arrive(const World& w, bool collided, const Waiting& of) {
  const std::uint32_t number = of.q.bits(kRay)[of.at];
  WorldRay& r = w.m.rays[number];
  if (collided) {
    if (r.kind == RayKind::shadow) return w.m.rays.remove(number);
    r.hit = r.visits[r.next - 1].instance;
    const Ray cells = w.in_cells(r.hit, r);
    const double t = dot(cells_at(of.q, of.at) - cells.o, cells.d) / dot(cells.d, cells.d);
    r.nearest = std::clamp(t, 0.0, r.end());
    r.cells = {of.q[kX][of.at], of.q[kY][of.at], of.q[kZ][of.at]};
  }
  go_on<ComponentKind>(w, number, of);
}

/// arrive() for records of a queue, those that `which` names or the first.
template <class ComponentKind>
HWY_NOINLINE void arrive_all(const World& w, const WavefrontScene& s, RayKind kind, bool collided,
                             const Records& q, const std::uint32_t* which, std::size_t n) {
  alignas(64) float depth[kLanes];
  alignas(64) std::uint32_t rng0[kLanes], rng1[kLanes], at[kLanes], rays[kLanes];
  for (std::size_t k = 0; k < n; k += kLanes) {
    const U all = which == nullptr ? hn::Iota(kU, std::uint32_t(k)) : load(which + k);
    const I index = where(first(n - k), as_int(all));
    Random rng = random_of(q, index);
    store(rng.exponential(), depth);
    store(rng.s0, rng0), store(rng.s1, rng1), store(as_bits(index), at);
    store(gather(q.bits(kRay), index), rays);
    const std::size_t lanes = std::min(kLanes, n - k);
    w.m.rays.prefetch(rays, lanes);
    for (std::size_t i = 0; i < lanes; ++i) {
      const Waiting of{q, at[i], depth[i], rng0[i], rng1[i]};
      if (!is_within(rays[i])) {
        arrive<ComponentKind>(w, collided, of);
      } else if (!collided) {
        enter_world<ComponentKind>(w, s, kind, of);
      }
    }
  }
}

template <class ComponentKind>
HWY_NOINLINE void fly_in(const World& w, std::size_t volume, RayKind kind) {
  WavefrontMemory& m = w.m;
  const WavefrontScene& s = w.scenes[volume];
  const bool shadow = kind == RayKind::shadow || kind == RayKind::to_fire;
  Tally& tally = shadow ? m.counts.shadow : m.counts.path;
  Records& queue = m.queues[volume][std::size_t(kind)];
  if (s.volume.one_by_one) return fly_one_by_one<ComponentKind>(w, s, queue, tally);
  take_and_fly<true>(s, m, queue, tally);
  if (kind == RayKind::shadow && s.ratio) {
    weigh(s, m, queue, tally, [&](std::uint32_t at) { m.rays.remove(m.flying.bits(kRay)[at]); });
  } else {
    decide(s, m, queue, &m.arrived, tally);
  }
  // What has left is told first: what arrives goes into queues, not into the slice.
  arrive_all<ComponentKind>(w, s, kind, false, m.flying, m.events.gone_source.data(),
                            m.events.gone);
  const bool scattered = kind == RayKind::path || kind == RayKind::photon;
  const bool brings_light = kind == RayKind::path || kind == RayKind::to_fire;
  const bool any_within = w.setup.free_radii.any();
  if (any_within && s.lines && brings_light) add_flights_within<ComponentKind>(w, kind);
  if (any_within && scattered) {
    m.others.resize(m.arrived.n + kLanes);
    const std::size_t n = put_hits_within<ComponentKind>(w, volume, m.others.data());
    arrive_all<ComponentKind>(w, s, kind, true, m.arrived, m.others.data(), n);
  } else {
    arrive_all<ComponentKind>(w, s, kind, true, m.arrived, nullptr, m.arrived.n);
  }
  m.arrived.n = 0;
}

/// Aims a ray that a collision has made, record `at` of the queue: it flies on from there, as
/// record `n` of `to`, which has the rest of it. Those that end at a lamp are always in the world:
/// its distance from a wall that it lies on is exact there.
inline void aim(const World& w, RayKind kind, const Records& q, std::size_t at, Records& to,
                std::size_t n) {
  WorldRays& rays = w.m.rays;
  const std::uint32_t parent = q.bits(kRay)[at];
  const bool within = is_within(parent);
  const std::uint32_t instance = within ? instance_within(parent) : rays[parent].within;
  const float time = within ? q[kTime][at] : rays[parent].time;
  const Vec3f direction = direction_at(q, at);
  Instance moved;
  const Float4 step = w.setup.instances->at_time(instance, double(time), moved).in_cells(direction);
  for (std::size_t k = 0; k < 3; ++k) to[kStepX + k][n] = step[int(k)];
  to[kTime][n] = time;
  const bool ends = kind == RayKind::shadow && q[kLeft][at] < 0x1p99f;
  if (!ends) {
    Rng own(q.bits(kRng0)[at], q.bits(kRng1)[at], kThinCollision);
    const Vec3f place(q[kX][at], q[kY][at], q[kZ][at]);
    if (const Reach reach = reach_from(w, instance, place, own); reach.length > 0) {
      to[kLeft][n] = reach.length;
      to.bits(kRay)[n] = kWithin | (reach.meets_thin ? kMeetsThin : 0) | instance;
      return;
    }
  }
  const std::uint32_t number = rays.add();
  WorldRay& r = rays[number];
  r.kind = kind, r.time = time;
  r.ray = {
      within ? w.setup.free_radii.of(instance).to_world.point(cells_at(q, at)) : rays[parent].place,
      Vec3d(direction)};
  r.begin_within(instance);
  r.limit = ends ? double(q[kLeft][at]) : kEndless;
  if (w.setup.weighs) {
    rays.look_ahead(w.setup, r, {q.bits(kRng0)[at], q.bits(kRng1)[at], kAhead}, w.shells);
  }
  to[kLeft][n] = float(std::min(r.end(), 0x1p100));
  to.bits(kRay)[n] = number;
}

/// Rays that collisions in a volume have made fly on there first: records have their places in its
/// cells.
template <class ComponentKind>
HWY_NOINLINE void aim_all(const World& w, std::size_t volume, RayKind kind, Records& q) {
  Records& to = w.m.queues[volume][std::size_t(kind)];
  const bool lines = w.scenes[volume].lines;
  to.reserve(q.n + kLanes);
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const std::size_t lanes = std::min(kLanes, q.n - at), n = to.n;
    const auto copy = [&](std::size_t field) { store(load(q[field] + at), to[field] + n); };
    for (std::size_t field = kX; field < kW0 + ComponentKind::kWeights; ++field) copy(field);
    copy(kPdf);
    if (lines) copy(kFromX), copy(kFromY), copy(kFromZ);
    M within = are_within(load(q.bits(kRay) + at), first(lanes));
    if (kind == RayKind::shadow)
      within = hn::And(within, hn::Ge(load(q[kLeft] + at), splat(0x1p99f)));
    if (!hn::AllFalse(kF, within)) {
      const Reaches reaches = reaches_of(w, q, at, within);
      within = hn::And(within, hn::Gt(reaches.radii, splat(0)));
      aim_within(w, q, at, within, reaches, to, n);
    }
    w.m.rays.prefetch(q.bits(kRay) + at, lanes);
    for (std::uint32_t others = bits_of(hn::AndNot(within, first(lanes))); others != 0;
         others &= others - 1) {
      const auto i = std::size_t(std::countr_zero(others));
      aim(w, kind, q, at + i, to, n + i);
    }
    to.n += lanes;
  }
  q.n = 0;
}

/// Sends the rays to lamps for which flights have asked.
template <class ComponentKind>
HWY_NOINLINE void send_to_lamps(const World& w) {
  while (!w.m.to_lamps.empty()) {
    auto [ray, time, rng] = w.m.to_lamps.back();
    w.m.to_lamps.pop_back();
    const Sent sent{.kind = RayKind::shadow,
                    .ray = {ray.from, Vec3d(ray.direction)},
                    .id = ray.id,
                    .weight = ray.weight,
                    .pdf = 1,  // what passes, where shadow rays have weights
                    .limit = ray.distance,
                    .time = time};
    send<ComponentKind>(w, sent, rng);
  }
}

/// Calls collide(scene) while the collisions of a volume are those of the memory, which it is to
/// empty; their rays end then.
template <class Collide>
void collide_in(const World& w, std::size_t volume, const Collide& collide) {
  WavefrontMemory& m = w.m;
  std::swap(m.collisions, m.hits[volume]);
  const std::size_t parents = m.collisions.n;
  collide(w.scenes[volume]);
  for (std::size_t k = 0; k < parents; ++k) m.rays.remove(m.collisions.bits(kRay)[k]);
  std::swap(m.collisions, m.hits[volume]);
}

/// Paths at their collisions in a volume.
template <bool kGuided, class ComponentKind>
void collide_paths(const World& w, std::size_t volume) {
  WavefrontMemory& m = w.m;
  collide_in(w, volume, [&](const WavefrontScene& s) {
    collide<kGuided, ComponentKind>(s, m);
    scatter<ComponentKind>(s, m.straight, m.paths);
    if constexpr (kGuided) scatter_guided<ComponentKind>(s, m.turned, m.paths);
    aim_all<ComponentKind>(w, volume, RayKind::shadow, m.shadows);
    aim_all<ComponentKind>(w, volume, RayKind::to_fire, m.to_fires);
    aim_all<ComponentKind>(w, volume, RayKind::path, m.paths);
  });
}

/// A sample's ray of the camera.
template <class ComponentKind>
void start(const World& w, const CameraRays& all, std::size_t k) {
  const PixelSample& sample = all.sample[k];
  const auto slot = std::uint32_t(all.rays.ray[k]);
  const Ray ray = all.rays.in_world(k);
  w.m.slots.note_pixel(slot, sample.x, sample.y);
  Sent sent{.kind = RayKind::camera, .ray = ray, .id = slot};
  if (w.setup.moving) {
    sent.time = sample_time(w.setup, sample);
    w.m.slots.times[slot] = sent.time;
  }
  if (w.setup.depths != nullptr) {
    see_lights(w.scenes, w.m, slot, ray, sent.time, numbers_aside(w.setup, sample, Aside::lights));
  }
  Rng rng = numbers_of(w.setup, sample);
  send<ComponentKind>(w, sent, rng);
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

/// Follows rays to their ends: those that start() begins while any() is true, and all that come of
/// them; collide(volume) is to empty the volume's collisions. False where the setup stops it.
template <class ComponentKind, class Any, class Start, class Collide>
bool follow_all(const World& w, const Any& any, const Start& start, const Collide& collide) {
  WavefrontMemory& m = w.m;
  m.rays.clear();
  for (auto& kinds : m.queues) {
    for (Records& q : kinds) q.n = 0;
  }
  for (Records& q : m.hits) q.n = 0;
  m.paths.n = m.shadows.n = m.to_fires.n = m.straight.n = m.turned.n = m.arrived.n = 0;
  m.met.n = m.meeting.n = 0;
  m.to_lamps.clear();
  const auto collide_where = [&](std::size_t least) {
    for (std::size_t v = 0; v < w.scenes.size(); ++v) {
      if (m.hits[v].n >= least) collide(v);
    }
  };
  constexpr std::size_t kEnough = 4 * kLanes;  // collisions that fill registers
  const std::size_t slice = slice_of(w.scenes.front());
  for (;;) {
    if (w.setup.stop->load(std::memory_order_relaxed)) return false;
    const Fullest fullest(m);
    if (fullest.n >= slice || (fullest.n > 0 && !any())) {
      fly_in<ComponentKind>(w, fullest.volume, fullest.kind);
    } else if (any()) {
      for (std::size_t k = 0; k < slice && any(); ++k) start();
    } else if (std::ranges::any_of(m.hits, [](const Records& q) { return q.n > 0; })) {
      collide_where(1);
    } else {
      return true;
    }
    meet_all<ComponentKind>(w);
    send_to_lamps<ComponentKind>(w);
    collide_where(kEnough);
  }
}

/// Traces and adds a tile's samples; see WavefrontKernel.
template <bool kGuided, class ComponentKind>
bool trace_many(std::span<const WavefrontScene> scenes, WavefrontMemory& m, const ImagePart& tile,
                const SampleTargets& targets, Film& film, Counts& counts) {
  const PathSetup& setup = scenes.front().setup;
  ShellCounts shells;
  const World w{scenes, setup, m, shells, kGuided ? &setup.importance->cells() : nullptr};
  Samples samples(tile, targets, film);
  m.slots.start(count_samples(tile, targets, film));
  m.counts = {};
  CameraRays& starting = m.starting;
  starting.clear();
  const auto start_next = [&] {
    if (!starting.any()) take_samples(setup, samples, starting);
    start<ComponentKind>(w, starting, starting.next++);
  };
  const bool whole = follow_all<ComponentKind>(
      w, [&] { return starting.any() || samples.any(); }, start_next,
      [&](std::size_t volume) { collide_paths<kGuided, ComponentKind>(w, volume); });
  if (!whole) return false;
  finish(setup, m, tile, targets, film);
  m.counts.shell_tests = shells.tests;
  m.counts.shell_rejections = shells.rejections;
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
