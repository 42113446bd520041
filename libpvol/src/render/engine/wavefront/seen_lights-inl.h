// Lights that the camera sees through volumes (THEORY.md, T5.26), ray by ray.

#if defined(PVOL_LANE_SEEN_LIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_SEEN_LIGHTS_INL_H
#undef PVOL_LANE_SEEN_LIGHTS_INL_H
#else
#define PVOL_LANE_SEEN_LIGHTS_INL_H
#endif

#include <cmath>
#include <variant>

#include "render/engine/wavefront/along-inl.h"
#include "render/engine/wavefront/wavefront_memory.h"
#include "render/path/transmittance_series.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// What would be seen of a light, or of the sky, along a ray of the camera if no volume were in the
/// way.
[[nodiscard]] inline LightMet seen_unshaded(const PathSetup& s, std::size_t light, const Ray& ray) {
  const bool background = s.options.background;
  const Vec3f d(ray.d);
  if (light == s.light.sources.size())
    return {.radiance = sky_part(s, d, true), .visible = background};
  const LightSource& source = s.light.sources[light];
  if (const auto* const sun = std::get_if<SunLight>(&source)) {
    return {.radiance = sun->seen(d), .visible = background};
  }
  return std::visit([&](const auto& l) { return l.met(ray, kEndless); }, source);
}

/// Whether a surface hides from the camera what lies at a distance.
[[nodiscard]] inline bool is_hidden(const PathSetup& s, const Ray& ray, double distance,
                                    float time) {
  if (s.surfaces == nullptr) return false;
  const SurfaceHit hit = s.surfaces->camera->first_hit(ray, distance, time);
  return hit.material != nullptr && !(distance < hit.distance + hit.beyond_for_lamps());
}

/// The radiance that is seen of a light at a distance, through all volumes before it.
[[nodiscard]] inline Rgb seen_through(std::span<const WavefrontScene> scenes, WavefrontMemory& m,
                                      std::uint32_t slot, const Ray& ray, double distance,
                                      float time, Rgb radiance, Rng& rng) {
  constexpr int kFewer = 4;       // points of the pivot, whose error hardly counts
  constexpr float kFaint = 0.1f;  // shares of the unit of shadow rays
  const PathSetup& s = scenes.front().setup;
  const Rgb pivot = Along{scenes, rng, kFewer}(*s.depths, ray, distance, time);
  Rgb about = radiance;
  for (int c = 0; c < 3; ++c) about[c] *= std::exp(-pivot[c]);
  const float brightness = absolute_luminance(about);
  if (!(brightness > 0)) return Rgb(0.0f);
  // What is faint beside the light of the volumes is looked at now and then.
  const float value = brightness * m.slots.importance_of(slot) / (kFaint * s.light.shadow_unit);
  const bool certain = !(value < 1) || pivot == Rgb(0.0f);
  if (!certain && !(rng.uniform() < value)) return Rgb(0.0f);
  const Along along{scenes, rng};
  const Rgb passed = transmittance_around(
      pivot, [&] { return along(*s.depths, ray, distance, time); }, rng);
  return radiance * passed * (certain ? 1.0f : 1 / value);
}

/// Adds what a ray of the camera sees of lights, at a time in frames.
HWY_NOINLINE void see_lights(std::span<const WavefrontScene> scenes, WavefrontMemory& m,
                             std::uint32_t slot, const Ray& ray, float time, Rng rng) {
  const PathSetup& s = scenes.front().setup;
  for (const std::uint32_t i : s.light.seen) {
    const LightMet light = seen_unshaded(s, i, ray);
    if (!light.visible || !(largest(light.radiance) > 0)) continue;
    if (is_hidden(s, ray, light.distance, time)) continue;
    const Rgb seen = seen_through(scenes, m, slot, ray, light.distance, time, light.radiance, rng);
    m.slots.add(slot, 0, [&](PathResult& r) { add_light(s, i, seen, r); });
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
