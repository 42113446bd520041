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

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

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
  if (box.contains(begin)) return {begin, true};
  const auto behind = intersect(box, {begin, -step}, 0, kEndless);
  return {behind ? begin - step * behind->t0 : max(box.lo, min(begin, box.hi)), true};
}

/// A ray within an instance has left that, or has come as far as nothing else is met. From there on
/// it is in the world; where it brings light on its way, from where it began.
template <class ComponentKind>
void enter_world(const World& w, const WavefrontScene& s, RayKind kind, const Waiting& of) {
  const EndWithin end = end_within(w, s.volume.volume.density.octree.support(), of.q, of.at);
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
    put(kRay);
    to.n += count(within);
  }
  if (w.cells != nullptr) find_rows(w, to, from);
  return n;
}

/// How far rays that a register's collisions have made meet nothing else, of those within.
HWY_INLINE F radii_of(const World& w, const Records& q, std::size_t at, M within) {
  F radii = splat(0);
  visit_instances_of(load(q.bits(kRay) + at), within, [&](std::uint32_t instance, M its) {
    const FreeRadii::Grid& g = w.setup.free_radii.of(instance);
    const float* const all = w.setup.free_radii.radii(g);
    if (g.has_one()) {
      radii = select(its, splat(*all), radii);
      return;
    }
    const auto along = [&](Field f, int axis) {
      const F cell = (load(q[f] + at) - splat(g.low[axis])) * splat(g.scale[axis]);
      return to_int(hn::Max(splat(0), hn::Min(cell, splat(float(g.size[axis] - 1)))));
    };
    const I cell =
        (along(kX, 0) * splat_int(g.size.y) + along(kY, 1)) * splat_int(g.size.z) + along(kZ, 2);
    radii = select(its, gather(all, cell), radii);
  });
  return radii;
}

/// Aims rays of a register that begin within instances, and stay there up to these radii.
HWY_INLINE void aim_within(const World& w, const Records& q, std::size_t at, M within, F radii,
                           Records& to, std::size_t n) {
  const U ray = load(q.bits(kRay) + at);
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
  store(radii, to[kLeft] + n);
  store(ray, to.bits(kRay) + n);
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
