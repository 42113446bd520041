// Rays that a collision has made in an instance, as far as nothing else of the scene bears on them:
// they are records alone, in the cells of the instance, and collide there at once (THEORY.md,
// "Free radii"). Then they are in the world.

#if defined(PVOL_LANE_WITHIN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_WITHIN_INL_H
#undef PVOL_LANE_WITHIN_INL_H
#else
#define PVOL_LANE_WITHIN_INL_H
#endif

#include "render/engine/wavefront/world-inl.h"
#include "volume/cell_look_up.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A stream of a record's random numbers, as kOnTheWay.
inline constexpr std::uint64_t kThinCollision = 8;

/// A ray of a record that is within an instance, from a place in its cells.
[[nodiscard]] inline WorldRay ray_within(const World& w, RayKind kind, const Records& q,
                                         std::size_t at, Vec3d from) {
  const std::uint32_t instance = instance_within(q.bits(kRay)[at]);
  WorldRay r;
  r.kind = kind, r.time = q[kTime][at];
  r.ray = {w.setup.free_radii.of(instance).to_world.point(from), Vec3d(direction_at(q, at))};
  r.begin_within(instance);
  return r;
}

/// Where a record is that has come to the end of its flight within an instance without a collision.
struct EndWithin {
  Vec3d place;  ///< in cells, from which on it may meet something else
  bool left;    ///< it has left the box of the support; else as far as it goes lies within
};
[[nodiscard]] inline EndWithin end_within(const World& w, const Box& box, const Records& q,
                                          std::size_t at) {
  // Records of flights without a collision are where these began. Some are beyond the box: lanes
  // fly to the ends of their cubes.
  const Vec3d begin = cells_at(q, at);
  const Instance& instance = w.setup.instances->all[instance_within(q.bits(kRay)[at])];
  const Vec3d step = instance.world_to_cells.vector(Vec3d(direction_at(q, at)));
  const double length = double(q[kLeft][at]);
  const auto ahead = intersect(box, {begin, step}, 0, kEndless);
  if (ahead && length < ahead->t1) return {begin + step * length, false};
  if (ahead) return {begin + step * ahead->t1, true};
  const auto behind = intersect(box, {begin, -step}, 0, kEndless);
  return {behind ? begin - step * behind->t0 : max(box.lo, min(begin, box.hi)), true};
}

/// How far a ray within an instance goes as a record, and by what it ends then.
struct Reach {
  float length;
  bool meets_thin;
};
/// From a place in its cells, as records have them, with numbers of its own.
[[nodiscard]] inline Reach reach_from(const World& w, std::uint32_t instance, Vec3f place,
                                      Rng& rng) {
  const FreeRadii& radii = w.setup.free_radii;
  const float radius = radii.at(instance, place);
  if (!(radius > 0) || !(radii.of(instance).majorant > 0)) return {radius, false};
  const float tentative = rng.tentative().depth / radii.of(instance).majorant;
  return {std::min(radius, tentative), tentative < radius};
}

/// Puts a record that goes on within its instance, from a place in its cells.
inline void put_within(const World& w, RayKind kind, const Waiting& of, Vec3d place, Rng& rng) {
  const std::uint32_t instance = instance_within(of.q.bits(kRay)[of.at]);
  const std::uint32_t volume = w.volume_of(instance);
  Records& to = w.m.queues[volume][std::size_t(kind)];
  const SimdField& field = w.scenes[volume].field;
  Vec3f from(place + Vec3d(DenseBounds::kBorder));
  for (int k = 0; k < 3; ++k) from[k] = std::clamp(from[k], field.low[k], field.high[k]);
  const Reach reach = reach_from(w, instance, from, rng);
  const std::uint32_t ray = kWithin | (reach.meets_thin ? kMeetsThin : 0) | instance;
  const std::size_t n = put_waiting(ray, of, to);
  for (std::size_t k = 0; k < 3; ++k) {
    to[kX + k][n] = from[int(k)];
    to[kStepX + k][n] = of.q[kStepX + k][of.at];
  }
  to[kTime][n] = of.q[kTime][of.at];
  to[kLeft][n] = reach.length, to[kDepth][n] = of.depth;
}

/// A ray within an instance has come to a tentative collision in one of the thin volumes around it,
/// at a place in the instance's cells: it collides there, or goes on.
template <class ComponentKind>
void meet_thin(const World& w, const WavefrontScene& s, RayKind kind, const Waiting& of,
               Vec3d place) {
  const FreeRadii& radii = w.setup.free_radii;
  const FreeRadii::Grid& grid = radii.of(instance_within(of.q.bits(kRay)[of.at]));
  Rng rng = of.stream(kThinCollision);
  const auto [u, v] = rng.uniform2();
  const FreeRadii::Thin& thin = radii.draw_thin(grid, u);
  const Instance& other = w.setup.instances->all[thin.instance];
  const Volume& volume = w.setup.volumes[other.volume].volume;
  const Vec3d cells = other.world_to_cells.point(grid.to_world.point(place));
  const float extinction = extinction_in_cells(volume, cells, of.q[kTime][of.at]);
  Tally& tally = kind == RayKind::shadow ? w.m.counts.shadow : w.m.counts.path;
  if (s.count) {  // photons have no slots
    tally.lookup();
    ++w.m.slots.counts[slot_of(of.q.bits(kId)[of.at])][std::size_t(PixelCounter::lookups)];
  }
  if (!(v * thin.majorant < extinction)) {
    if (s.count) tally.null_collision();
    return put_within(w, kind, of, place, rng);
  }
  if (kind == RayKind::shadow) return;
  const std::uint32_t number = w.m.rays.add();
  WorldRay& r = w.m.rays[number];
  r = ray_within(w, kind, of.q, of.at, place);
  r.searched = true;
  r.hit = thin.instance, r.nearest = 0;
  r.cells = Vec3f(cells + Vec3d(DenseBounds::kBorder));
  finish_ray<ComponentKind>(w, number, of);
}

/// A ray within an instance has left that, or has come as far as nothing else is met. From there on
/// it is in the world; where it brings light on its way, from where it began.
template <class ComponentKind>
void enter_world(const World& w, const WavefrontScene& s, RayKind kind, const Waiting& of) {
  const EndWithin end = end_within(w, s.volume.volume.density.octree.support(), of.q, of.at);
  if (!end.left && (of.q.bits(kRay)[of.at] & kMeetsThin) != 0) {
    return meet_thin<ComponentKind>(w, s, kind, of, end.place);
  }
  const bool lines = s.lines && kind != RayKind::shadow;
  const std::uint32_t number = w.m.rays.add();
  WorldRay& r = w.m.rays[number];
  r = ray_within(w, kind, of.q, of.at, lines ? cells_at(of.q, of.at, kFromX) : end.place);
  if (!end.left) {
    const Vec3d place = w.setup.free_radii.of(r.within).to_world.point(end.place);
    r.fly_on_within(length(place - r.ray.o));
  }
  go_on<ComponentKind>(w, number, of);
}

/// What rays bring on their ways that have collided in the instances in which they are.
template <class ComponentKind>
HWY_NOINLINE void add_flights_within(const World& w, RayKind kind) {
  const Records& q = w.m.arrived;
  for (std::size_t at = 0; at < q.n; ++at) {
    const std::uint32_t ray = q.bits(kRay)[at];
    if (!is_within(ray)) continue;
    WorldRay r = ray_within(w, kind, q, at, cells_at(q, at, kFromX));
    r.hit = instance_within(ray);
    r.cells = {q[kX][at], q[kY][at], q[kZ][at]};
    r.nearest = length(w.setup.free_radii.of(r.hit).to_world.point(cells_at(q, at)) - r.ray.o);
    const Waiting of{q, at, 0, q.bits(kRng0)[at], q.bits(kRng1)[at]};
    if (kind == RayKind::to_fire) {
      add_fire_ray<ComponentKind>(w, r, of);
    } else {
      add_flight<ComponentKind>(w, r, of);
    }
  }
}

HWY_INLINE M are_within(U ray, M on) {
  return hn::And(on, mask(hn::Lt(as_int(ray), splat_int(0))));
}
/// visit(instance, lanes) for each instance in which some of these rays are.
template <class Visit>
HWY_INLINE void visit_instances_of(U ray, M within, const Visit& visit) {
  alignas(64) std::uint32_t rays[kLanes];
  store(ray, rays);
  while (!hn::AllFalse(kF, within)) {
    const std::uint32_t one = rays[std::countr_zero(bits_of(within))];
    const M its = hn::And(within, mask(hn::Eq(ray, splat_bits(one))));
    visit(instance_within(one), its);
    within = hn::AndNot(its, within);
  }
}

/// The rows of the importance at collisions from one on, within instances.
inline void find_rows(const World& w, Records& hits, std::size_t from) {
  const CoarseCells& cells = *w.cells;
  for (std::size_t at = from; at < hits.n; at += kLanes) {
    const U ray = load(hits.bits(kRay) + at);
    const auto in_cells = [&](std::size_t f) {
      return load(hits[f] + at) - splat(float(DenseBounds::kBorder));
    };
    const V place{in_cells(kX), in_cells(kY), in_cells(kZ)};
    U rows = splat_bits(0);
    visit_instances_of(ray, first(hits.n - at), [&](std::uint32_t instance, M its) {
      const Affine map = cells.to_cells * w.setup.free_radii.of(instance).to_world;
      const auto along = [&](int axis) {
        const F cell =
            dot(splat(Vec3f(map.m[std::size_t(axis)])), place) + splat(float(map.t[axis]));
        return to_int(cell) + splat_int(DenseBounds::kBorder);
      };
      rows = select(its, as_bits(row_of(cells, along(0), along(1), along(2))), rows);
    });
    store(rows, hits.bits(kAux) + at);
  }
}

/// Collisions of paths within instances are collisions of the volume at once. The others that have
/// arrived are listed; returns how many these are.
template <class ComponentKind>
HWY_NOINLINE std::size_t put_hits_within(const World& w, std::size_t volume,
                                         std::uint32_t* others) {
  const WavefrontScene& s = w.scenes[volume];
  const Records& q = w.m.arrived;
  Records& to = w.m.hits[volume];
  to.reserve(q.n + kLanes);
  const std::size_t from = to.n;
  std::size_t n = 0;
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    const M on = first(q.n - at);
    const M within = are_within(load(q.bits(kRay) + at), on);
    const M other = hn::AndNot(within, on);
    pack(other, hn::Iota(kU, std::uint32_t(at)), others + n);
    n += count(other);
    const auto put = [&](std::size_t f) { pack(within, load(q[f] + at), to[f] + to.n); };
    for (const Field f : {kX, kY, kZ, kDX, kDY, kDZ, kRng0, kRng1, kId}) put(f);
    for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) put(kW0 + c);
    if (s.times) put(kTime);
    if (s.lines && s.volume.asks_lamps) put(kFromX), put(kFromY), put(kFromZ);
    const U ray = hn::AndNot(splat_bits(kMeetsThin), load(q.bits(kRay) + at));
    pack(within, ray, to.bits(kRay) + to.n);
    to.n += count(within);
  }
  if (w.cells != nullptr) find_rows(w, to, from);
  return n;
}

/// How far rays that a register's collisions have made go as records, of those within: up to their
/// radii, or to tentative collisions in thin volumes.
struct Reaches {
  F radii, majorants;
};
HWY_INLINE Reaches reaches_of(const World& w, const Records& q, std::size_t at, M within) {
  Reaches r{splat(0), splat(0)};
  visit_instances_of(load(q.bits(kRay) + at), within, [&](std::uint32_t instance, M its) {
    const FreeRadii::Grid& g = w.setup.free_radii.of(instance);
    const float* const all = w.setup.free_radii.radii(g);
    r.majorants = select(its, splat(g.majorant), r.majorants);
    if (g.is_endless()) {
      r.radii = select(its, splat(*all), r.radii);
      return;
    }
    const auto along = [&](Field f, int axis) {
      const F cell = (load(q[f] + at) - splat(g.low[axis])) * splat(g.scale[axis]);
      return to_int(hn::Max(splat(0), hn::Min(cell, splat(float(g.size[axis] - 1)))));
    };
    const I cell =
        (along(kX, 0) * splat_int(g.size.y) + along(kY, 1)) * splat_int(g.size.z) + along(kZ, 2);
    r.radii = select(its, gather(all, cell), r.radii);
  });
  return r;
}

/// Aims rays of a register that begin within instances, as far as they go there.
HWY_INLINE void aim_within(const World& w, const Records& q, std::size_t at, M within,
                           const Reaches& reaches, Records& to, std::size_t n) {
  U ray = load(q.bits(kRay) + at);
  const V d = direction_of(q, at);
  V step{splat(0), splat(0), splat(0)};
  visit_instances_of(ray, within, [&](std::uint32_t instance, M its) {
    const Affine& to_cells = w.setup.instances->all[instance].world_to_cells;
    const auto along = [&](std::size_t axis) { return dot(splat(Vec3f(to_cells.m[axis])), d); };
    step = {select(its, along(0), step.x), select(its, along(1), step.y),
            select(its, along(2), step.z)};
  });
  store(step.x, to[kStepX] + n), store(step.y, to[kStepY] + n), store(step.z, to[kStepZ] + n);
  store(load(q[kTime] + at), to[kTime] + n);
  F left = reaches.radii;
  const M thin = hn::Gt(reaches.majorants, splat(0));
  if (!hn::AllFalse(kF, thin)) {
    const Random::Seed seed{load(q.bits(kRng0) + at), load(q.bits(kRng1) + at)};
    Random own = Random::stream(seed, kThinCollision);
    const F tentative = own.exponential() / reaches.majorants;
    const M meets = hn::And(thin, hn::Lt(tentative, left));
    left = select(meets, tentative, left);
    ray = select(meets, ray | splat_bits(kMeetsThin), ray);
  }
  store(left, to[kLeft] + n);
  store(ray, to.bits(kRay) + n);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
