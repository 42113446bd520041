// Photons: the stages of paths, with collisions that count the light that arrives.

#if defined(PVOL_LANE_PHOTONS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_PHOTONS_INL_H
#undef PVOL_LANE_PHOTONS_INL_H
#else
#define PVOL_LANE_PHOTONS_INL_H
#endif

#include "render/engine/wavefront/many-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Puts a photon where it enters the box of the support. Its id has the number of its source, and
/// above it that of its flights.
inline void start(const WavefrontScene& s, WavefrontMemory& m, const PhotonTask& task,
                  std::uint64_t number) {
  Rng rng(kPhotonKey, 0, number);
  const Photon p = task.sources.sample(rng);
  const Ray cells = s.volume.in_cells(p.ray);
  const auto span = s.volume.in_box(cells);
  if (!span || !is_finite(p.power)) return;
  // In a grey medium all that counts is a photon's luminance.
  const Rgb weight = s.one_lobe ? Rgb(luminance(p.power)) : p.power;
  const auto source = std::uint32_t(std::min<std::size_t>(p.source, kMostSlots - 1));
  put_ray(s, m.paths, cells.at(span->t0), Vec3f(p.ray.d), weight, source, rng);
}

/// Counts what arrives in the cells of collisions, lane by lane.
template <class ComponentKind>
HWY_NOINLINE void count_light(const PhotonTask& task, const Paths<ComponentKind>& p, I row) {
  alignas(64) float w[ComponentKind::kWeights][kLanes], d[3][kLanes];
  alignas(64) std::uint32_t id[kLanes], rows[kLanes];
  for (std::size_t c = 0; c < ComponentKind::kWeights; ++c) store(p.w[c], w[c]);
  store(p.from.x, d[0]), store(p.from.y, d[1]), store(p.from.z, d[2]);
  store(p.id, id), store(as_bits(row), rows);
  for (std::uint32_t lanes = bits_of(p.alive); lanes != 0; lanes &= lanes - 1) {
    const auto k = std::size_t(std::countr_zero(lanes));
    const float power = ComponentKind::kWeights == 1
                            ? w[0][k]
                            : luminance(Rgb(w[0][k], w[ComponentKind::kWeights / 2][k],
                                            w[ComponentKind::kWeights - 1][k]));
    task.counts.add(rows[k], Vec3f(-d[0][k], -d[1][k], -d[2][k]), power);
    if (number_of(id[k]) == 0) task.counts.add_direct(rows[k], slot_of(id[k]), power);
  }
}

template <class ComponentKind>
HWY_NOINLINE void collide_photons(const WavefrontScene& s, WavefrontMemory& m,
                                  const PhotonTask& task) {
  Records& q = m.collisions;
  for (std::size_t at = 0; at < q.n; at += kLanes) {
    Paths<ComponentKind> p(q, at);
    p.component = ComponentKind::choose(s, p.rng);
    if (s.many) {
      p.row = as_int(load(q.bits(kAux) + at));
    } else {
      const Place place(s.field.bounds, p.x, p.y, p.z);
      p.row = row_of(task.cells, place.x, place.y, place.z);
    }
    count_light(task, p, where(p.alive, p.row));
    p.id = p.id + splat_bits(kMostSlots);
    const I flights = as_int(hn::ShiftRight<16>(p.id));
    p.alive = hn::And(p.alive, mask(hn::Lt(flights, splat_int(kMostPhotonFlights))));
    weaken(s, m, false, p);
    end_faint(p, kPhotonRoulette);
    p.alive = hn::And(p.alive, hn::Gt(p.largest(), splat(0)));
    put_paths(s, m, p, splat_int(1), first(0));
  }
  q.n = 0;
}

/// Traces the photons of a task; see PhotonKernel.
template <class ComponentKind>
void trace_photons(std::span<const WavefrontScene> scenes, WavefrontMemory& m,
                   const PhotonTask& task) {
  const WavefrontScene& s = scenes.front();
  Tally none;
  for (std::uint64_t next = task.begin; !s.setup.stop->load(std::memory_order_relaxed);) {
    m.paths.reserve(kSlice);
    while (m.paths.n < kSlice && next < task.end) start(s, m, task, next++);
    if (m.paths.n == 0) break;
    take_and_fly(s, m, m.paths, none);
    decide(s, m, m.paths, &m.collisions, none);
    collide_photons<ComponentKind>(s, m, task);
    scatter<ComponentKind>(s, m.straight, m.paths);
  }
}

/// A photon in the world.
template <class ComponentKind>
void start(const World& w, const PhotonTask& task, std::uint64_t number) {
  Rng rng(kPhotonKey, 0, number);
  const Photon p = task.sources.sample(rng);
  if (!is_finite(p.power) || !(largest(p.power) > 0)) return;
  const auto source = std::uint32_t(std::min<std::size_t>(p.source, kMostSlots - 1));
  Sent sent{.kind = RayKind::photon, .ray = p.ray, .id = source};
  sent.weight = w.scenes.front().one_lobe ? Rgb(luminance(p.power)) : p.power;
  if (w.setup.moving) sent.time = sample_time(w.setup, {0, 0, std::uint32_t(number)});
  send<ComponentKind>(w, sent, rng);
}

/// The same through many volumes, or among surfaces.
template <class ComponentKind>
void trace_photons_in_world(std::span<const WavefrontScene> scenes, WavefrontMemory& m,
                            const PhotonTask& task) {
  ShellCounts shells;
  const World w{scenes, scenes.front().setup, m, shells, &task.cells};
  std::uint64_t next = task.begin;
  const auto collide = [&](std::size_t volume) {
    collide_in(w, volume, [&](const WavefrontScene& s) {
      collide_photons<ComponentKind>(s, m, task);
      scatter<ComponentKind>(s, m.straight, m.paths);
      aim_all<ComponentKind>(w, volume, RayKind::photon, m.paths);
    });
  };
  (void)follow_all<ComponentKind>(
      w, [&] { return next < task.end; }, [&] { start<ComponentKind>(w, task, next++); }, collide);
}

[[nodiscard]] inline PhotonKernel find_photons(bool one_lobe, bool many) {
  if (many)
    return one_lobe ? &trace_photons_in_world<OneLobe> : &trace_photons_in_world<AnyComponent>;
  return one_lobe ? &trace_photons<OneLobe> : &trace_photons<AnyComponent>;
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
