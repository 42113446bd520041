// The stage of surfaces: what paths do that have met one, path by path.

#if defined(PVOL_LANE_MEET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MEET_INL_H
#undef PVOL_LANE_MEET_INL_H
#else
#define PVOL_LANE_MEET_INL_H
#endif

#include "render/engine/wavefront/world-inl.h"
#include "render/guide/photons.h"
#include "render/path/lambert.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A path on the surface that scatters it.
struct OnSurface {
  Vec3d place;
  Lambert lobe;
  std::uint32_t id;  ///< of the path once it is scattered
  float time;
  bool seen;     ///< by the camera: its light is its pixel's noise
  bool catcher;  ///< which shows shadows alone
  Rng& rng;

  [[nodiscard]] std::uint32_t slot() const { return slot_of(id); }
  /// How often light from there is scattered: as layers tell that apart.
  [[nodiscard]] std::uint32_t scatterings() const {
    return std::min<std::uint32_t>(number_of(id), PathResult::kOrders - 1);
  }
  /// A ray from there.
  [[nodiscard]] Sent ray(RayKind kind, Vec3f direction) const {
    return {.kind = kind,
            .ray = {place, Vec3d(direction)},
            .id = id,
            .time = time,
            .off_surface = true};
  }
};

/// Whether a volume may dim light that comes along a ray from this distance.
[[nodiscard]] inline bool meets_volume(const World& w, const Ray& ray, double distance,
                                       float time) {
  bool meets = false;
  visit_instances(w.setup, ray, time, distance, WorldRay::kNowhere, w.shells,
                  [&](std::uint32_t, double, double) {
                    meets = true;
                    return 0.0;  // ends the visit
                  });
  return meets;
}

/// Light of a source, or of the sky after them, that a surface scatters into a path, if nothing is
/// in the way; `own` is the light's radiance that shadow rays bring, and `weight` theirs. Where
/// volumes may be in the way it is left to ask_through_volumes.
template <class ComponentKind>
void ask_light(const World& w, const OnSurface& v, std::size_t light, const LightSample& towards,
               Rgb weight, Rgb own) {
  const PathSetup& s = w.setup;
  if (!(absolute_luminance(weight * own) > 0)) return;
  // Here it is asked once: rays off surfaces do not ask again.
  const Ray way{v.place, Vec3d(towards.direction)};
  if (s.surfaces->hide(way, towards.distance, v.time)) return;
  if (meets_volume(w, way, towards.distance, v.time)) {
    w.m.through_volumes.push_back({light, towards.direction, towards.distance, weight, own});
    return;
  }
  const auto add = [&](PathResult& r) { add_light(s, light, weight * own, r); };
  v.catcher ? w.m.slots.add_caught(v.slot(), add) : w.m.slots.add(v.slot(), v.scatterings(), add);
}

/// Sends shadow rays to a light through volumes: as many as it is worth.
template <class ComponentKind>
void send_to_light(const World& w, const OnSurface& v, const LightThroughVolumes& l, float value) {
  if (v.seen) value = std::max(value, 1.0f);
  if (value < 1 && !(v.rng.uniform() < value)) return;
  const int rays = count_shadow_rays(value);
  w.m.counts.shadow_rays += std::uint64_t(rays);
  Sent sent = v.ray(RayKind::shadow, l.direction);
  sent.id = v.slot() | std::uint32_t(l.number) << 16;
  if (w.scenes.front().orders) sent.id |= v.scatterings() << 30;
  sent.weight = l.weight * (1 / (value < 1 ? value : float(rays)));
  sent.pdf = 1;  // what passes, where shadow rays have weights
  sent.limit = l.distance;
  sent.on_catcher = v.catcher;
  for (int k = 0; k < rays; ++k) send<ComponentKind>(w, sent, v.rng);
}

/// Of more lights that are behind volumes, perhaps, so many are drawn.
inline constexpr int kAskedThroughVolumes = 2;

/// Asks the lights that ask_light has left, or some of them, drawn by what they would bring.
template <class ComponentKind>
void ask_through_volumes(const World& w, const OnSurface& v) {
  std::vector<LightThroughVolumes>& lights = w.m.through_volumes;
  std::vector<float>& brought = w.m.brought;
  brought.clear();
  for (const LightThroughVolumes& l : lights) {
    brought.push_back(absolute_luminance(l.weight * l.own));
  }
  const auto send = [&](std::size_t i, float times) {
    LightThroughVolumes l = lights[i];
    l.weight *= times;
    // Bright pixels do not go without shadow rays (THEORY.md, T5.2).
    const float value = brought[i] * times / w.setup.light.shadow_unit *
                        std::max(w.m.slots.importance_of(v.slot()), 1.0f);
    send_to_light<ComponentKind>(w, v, l, value);
  };
  if (lights.size() <= std::size_t(kAskedThroughVolumes)) {
    for (std::size_t i = 0; i < lights.size(); ++i) send(i, 1);
  } else {
    draw_some(brought, kAskedThroughVolumes, v.rng, send);
  }
  lights.clear();
}

/// Light of all lights and the sky that a surface scatters into a path of this throughput.
template <class ComponentKind>
void ask_lights(const World& w, const OnSurface& v, Rgb throughput) {
  const PathSetup& s = w.setup;
  const auto share = [&](const LightSample& l) {
    const float p = pdf_phase(v.lobe, {}, l.direction);
    return l.pdf > 0 ? p / (l.pdf + p) : p;
  };
  const OnPlane at{v.place, Vec3d(v.lobe.normal)};
  ask_each(s.light, at, v.catcher, w.m.light_cut, v.rng, [&](std::size_t i, float factor) {
    const LightSample l = detail::sample_light(s.light.sources[i], v.place, v.rng);
    const Rgb own = w.scenes.front().lights[i].radiance;
    const float most = largest(own);
    if (!(most > 0)) return;
    const float of_own = largest(l.radiance) / most;
    ask_light<ComponentKind>(w, v, i, l, throughput * (share(l) * factor * of_own), own);
  });
  if (s.light.sky.sampled()) {
    const LightSample l = s.light.sky.sample(v.rng);
    ask_light<ComponentKind>(w, v, s.light.sources.size(), l, throughput * share(l),
                             l.radiance - s.constant);
  }
  ask_through_volumes<ComponentKind>(w, v);
}

/// A ray towards a fire, as from collisions.
template <class ComponentKind>
void ask_fires(const World& w, const OnSurface& v, Rgb throughput) {
  const EmissionLights::Towards to = w.setup.emission->lights.sample(v.place, v.time, v.rng);
  if (!(to.pdf > 0)) return;
  const float p = pdf_phase(v.lobe, {}, to.direction);
  const float pixel = w.m.slots.importance_of(v.slot());
  const float value = v.seen ? 1.0f : detail::value_of_fire_ray(throughput * pixel, p);
  if (!(value * p > 0) || (value < 1 && !(v.rng.uniform() < value))) return;
  ++w.m.counts.shadow_rays;
  Sent sent = v.ray(RayKind::to_fire, to.direction);
  sent.pdf = p / (to.pdf + p) / value;
  sent.weight = throughput * sent.pdf;
  send<ComponentKind>(w, sent, v.rng);
}

/// Sends the path on its way.
template <class ComponentKind>
void scatter(const World& w, const OnSurface& v, Rgb throughput) {
  const Vec3f to = sample_phase(v.lobe, {}, v.rng);
  Sent sent = v.ray(RayKind::path, to);
  sent.on_catcher = v.catcher;
  (v.catcher ? sent.throughput : sent.weight) = throughput;
  sent.pdf = pdf_phase(v.lobe, {}, to);
  send<ComponentKind>(w, sent, v.rng);
}

[[nodiscard]] inline bool samples_fires_on_surfaces(const PathSetup& s) {
  return s.emission != nullptr && s.emission->sampled_on_surfaces;
}

/// A shadow catcher before the camera: light that reaches it unscattered tells how much it covers;
/// all other light it scatters as what it is.
template <class ComponentKind>
void catch_shadow(const World& w, const OnSurface& v, const SurfaceHit& surface, Vec3f direction,
                  Rgb weight) {
  const PathSetup& s = w.setup;
  const Rgb open = w.m.open_light(s.light, surface);
  w.m.slots.see_catcher(v.slot(), direction, open, weight);
  if (s.first_collisions) w.m.slots.first[v.slot()].place = surface.place;
  w.m.slots.seen[v.slot()].material = surface.material;
  if (largest(open) > 0) ask_lights<ComponentKind>(w, v, Rgb(1.0f));
  const Rgb throughput = s.max_bounces > 0 ? weight * surface.material->albedo : Rgb(0.0f);
  const bool scatters = largest(throughput) > 0;
  if (scatters && samples_fires_on_surfaces(s)) ask_fires<ComponentKind>(w, v, throughput);
  if (scatters || largest(open) > 0) scatter<ComponentKind>(w, v, throughput);
}

/// A path of a record that has met a surface.
template <class ComponentKind>
void meet(const World& w, const Records& q, std::size_t at) {
  const PathSetup& s = w.setup;
  const std::uint32_t number = q.bits(kRay)[at], id = q.bits(kId)[at];
  const WorldRay& r = w.m.rays[number];
  const SurfaceHit surface = r.among.surface;
  const Material& material = *surface.material;
  const std::uint32_t scatterings = number_of(id);
  const bool counts = w.scenes.front().counts_collisions && scatterings < kMostBounces;
  Rng rng(q.bits(kRng0)[at], q.bits(kRng1)[at], kMet);
  const bool seen = r.kind == RayKind::camera;
  const OnSurface v{surface.place,
                    {Vec3f(surface.normal)},
                    counts ? id + kMostSlots : id,
                    r.time,
                    seen,
                    seen && material.visibility == Visibility::shadow_catcher,
                    rng};
  w.m.rays.remove(number);
  ++w.m.counts.surface_hits;
  Rgb throughput = weight_at<ComponentKind>(q, at);
  if (seen) {
    if (material.visibility == Visibility::holdout) {
      if (s.weighs) w.m.slots.dim(v.slot(), throughput);
      return;
    }
    if (v.catcher)
      return catch_shadow<ComponentKind>(w, v, surface, direction_at(q, at), throughput);
    add_first_collision(s, w.m, v.slot(), {surface.place}, throughput);
    w.m.slots.seen[v.slot()] = {&material, surface.normal, surface.moves};
  }
  if (largest(s.constant) > 0) {
    w.m.slots.add(v.slot(), scatterings,
                  [&](PathResult& r) { subtract_absorbed(s, material.albedo, throughput, r); });
  }
  if (scatterings >= s.max_bounces) return;
  throughput *= material.albedo;
  if (seen) {  // it is its pixel's noise, and no roulette decides on it
    if (!(largest(throughput) > 0)) return;
    w.m.slots.note_albedo(v.slot(), largest(throughput));
  } else if (!survives(throughput, kPathRoulette / w.m.slots.importance_of(v.slot()), rng)) {
    return;
  }
  ask_lights<ComponentKind>(w, v, throughput);
  if (samples_fires_on_surfaces(s)) ask_fires<ComponentKind>(w, v, throughput);
  scatter<ComponentKind>(w, v, throughput);
}

/// A photon of a record that has met a surface, as a guide follows them.
template <class ComponentKind>
void meet_photon(const World& w, const Records& q, std::size_t at) {
  const std::uint32_t number = q.bits(kRay)[at], id = q.bits(kId)[at] + kMostSlots;
  const WorldRay& r = w.m.rays[number];
  const SurfaceHit surface = r.among.surface;
  Rng rng(q.bits(kRng0)[at], q.bits(kRng1)[at], kMet);
  const OnSurface v{surface.place, {Vec3f(surface.normal)}, id, r.time, false, false, rng};
  w.m.rays.remove(number);
  Rgb power = weight_at<ComponentKind>(q, at) * surface.material->albedo;
  if (number_of(id) >= kMostPhotonFlights || !survives(power, kPhotonRoulette, rng)) return;
  const Vec3f to = sample_phase(v.lobe, {}, rng);
  Sent sent = v.ray(RayKind::photon, to);
  sent.weight = power;
  send<ComponentKind>(w, sent, rng);
}

/// All that have met one; rays that they send may meet others.
template <class ComponentKind>
HWY_NOINLINE void meet_all(const World& w) {
  WavefrontMemory& m = w.m;
  while (m.met.n > 0) {
    std::swap(m.met, m.meeting);
    for (std::size_t at = 0; at < m.meeting.n; ++at) {
      const bool photon = m.rays[m.meeting.bits(kRay)[at]].kind == RayKind::photon;
      (photon ? &meet_photon<ComponentKind> : &meet<ComponentKind>)(w, m.meeting, at);
    }
    m.meeting.n = 0;
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
