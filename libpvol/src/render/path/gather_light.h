// All light that a path gathers: at the end of a ray, by emission, and by next-event estimation at
// a collision.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/path/path_result.h"
#include "render/path/roulette.h"

namespace pvol::detail {

/// Weight of a sample of one technique against another (Veach 1997, balance heuristic).
[[nodiscard]] inline float balance(float pdf, float other) { return pdf / (pdf + other); }

/// Most shadow rays for one light at one collision.
inline constexpr int kMostShadowRays = 8;

/// How many are traced where their number is to be this (THEORY.md, T5.2), if roulette lets one
/// through where that is below 1.
[[nodiscard]] inline int count_shadow_rays(float value) {
  return value < 1 ? 1 : value < float(kMostShadowRays) ? int(value) : kMostShadowRays;
}

/// Luminance of the sizes of channels, which may be negative.
[[nodiscard]] inline float absolute_luminance(Rgb c) {
  return luminance(Rgb(std::abs(c.x), std::abs(c.y), std::abs(c.z)));
}

/// The constant that is left out of all else.
inline void add_constant(const PathSetup& s, Rgb throughput, PathResult& r) {
  r.radiance += throughput * s.constant;
  if (r.in_layers()) r.sky() += throughput * s.constant;
}
inline void add_constant(const PathSetup& s, PathResult& r) { add_constant(s, Rgb(1.0f), r); }

/// What a surface of this albedo, which a path of this throughput meets, absorbs of the constant.
inline void subtract_absorbed(const PathSetup& s, Rgb albedo, Rgb throughput, PathResult& r) {
  const Rgb absorbed = throughput * (Rgb(1.0f) - albedo) * s.constant;
  r.radiance -= absorbed;
  if (r.in_layers()) r.sky() -= absorbed;
}

/// What a collision of a path of this throughput emits, less what it absorbs of the constant, which
/// is the sky's.
inline void add_emitted(const PathSetup& s, const LocalMedium& medium, Rgb throughput,
                        PathResult& r) {
  r.radiance += throughput * medium.emitted;
  if (!r.in_layers()) return;
  const Rgb absorbed = (Rgb(1.0f) - medium.albedo) * s.constant;
  r.emission() += throughput * (medium.emitted + absorbed);
  r.sky() -= throughput * absorbed;
}

/// The straight line of a flight in the world.
struct FlightLine {
  Vec3d from;
  Vec3f direction;
  double length;     ///< infinite where it left
  Rgb at_end{0.0f};  ///< what a fire brings where it collided (FireAtCollisions)
  float time = 0;    ///< of its path, in frames
};

/// Light of a source, or of the sky, which has the number after them, has arrived.
inline void add_light(const PathSetup& s, std::size_t light, Rgb arrived, PathResult& r) {
  r.radiance += arrived;
  if (!r.in_layers()) return;
  (light == s.light.sources.size() ? r.sky() : r.layers[light]) += arrived;
}

/// What is emitted along a flight, or where it collides. along(lines, ray, distance, time) is an
/// estimate of what is emitted along a ray of the world up to a distance that may be infinite, at a
/// time in frames: as it is, without the extinction in between. Up to the end of a free flight that
/// is right on average, for flights pass a place with the probability of its transmittance
/// (THEORY.md, T5.11).
template <class Along>
[[nodiscard]] inline Rgb emission_of(const PathSetup& s, const FlightLine& flight,
                                     const Along& along) {
  if (s.emission->lines.sources.empty()) return flight.at_end;
  const Ray ray{flight.from, Vec3d(flight.direction)};
  return along(s.emission->lines, ray, flight.length, flight.time) + flight.at_end;
}

/// That of a flight of a path, weighted against samples of fires if these were asked for where the
/// path was scattered with the density pdf(); else pdf() is 0.
template <class Pdf, class Along>
[[gnu::noinline]] inline void add_along(const PathSetup& s, const FlightLine& flight,
                                        const Pdf& pdf, Rgb throughput, const Along& along,
                                        PathResult& r) {
  Rgb sum = emission_of(s, flight, along);
  if (!(largest(sum) > 0)) return;
  if (const float p = pdf(); p > 0) {
    const EmissionLights& lights = s.emission->lights;
    const float share = balance(p, lights.pdf(flight.from, flight.direction, flight.time));
    if (s.pilot) note_hit(*s.pilot, luminance(throughput * sum), share);
    sum *= share;
  }
  r.radiance += throughput * sum;
  if (r.in_layers()) r.emission() += throughput * sum;
}

/// Light of lights that a flight meets; of a path that was scattered with the density pdf(),
/// weighted against samples of lights; where pdf() is 0, of those that the camera sees, if flights
/// add these.
template <class Pdf>
[[gnu::noinline]] inline void add_met(const PathSetup& s, const FlightLine& flight, const Pdf& pdf,
                                      Rgb throughput, PathResult& r) {
  const float p = pdf();
  if (p == 0 && s.depths != nullptr) return;
  const Ray ray{flight.from, Vec3d(flight.direction)};
  s.light.met.visit(ray, flight.length, [&](std::size_t i) {
    const LightMet met = std::visit(
        [&](const auto& light) { return light.met(ray, flight.length); }, s.light.sources[i]);
    if (!(largest(met.radiance) > 0)) return;
    if (p == 0 && !met.visible) return;  // of the camera
    add_light(s, i, throughput * met.radiance * (p > 0 ? balance(p, met.pdf) : 1.0f), r);
  });
}

/// What a flight brings besides its end: emission along it, and lights that it passes.
template <class Pdf, class Along>
inline void add_on_the_way(const PathSetup& s, const FlightLine& flight, const Pdf& pdf,
                           Rgb throughput, const Along& along, PathResult& r) {
  if (s.emission) {
    const auto sampled = [&] { return s.emission->sampled_in_volumes ? pdf() : 0.0f; };
    add_along(s, flight, sampled, throughput, along, r);
  }
  if (s.light.met.any()) add_met(s, flight, pdf, throughput, r);
}

/// Light of suns and of the sky in the direction of a camera ray that met nothing.
inline void add_seen(const PathSetup& s, Vec3f direction, Rgb throughput, PathResult& r) {
  add_light(s, s.light.sources.size(), throughput * (s.light.sky.radiance(direction) - s.constant),
            r);
  for (const std::uint32_t i : s.light.suns) {
    add_light(s, i, throughput * std::get<SunLight>(s.light.sources[i]).seen(direction), r);
  }
}

/// The sky in that direction where it is bright, and seen through volumes as lights are; or where
/// it is not; else 0.
[[nodiscard]] inline Rgb sky_part(const PathSetup& s, Vec3f direction, bool bright) {
  const Rgb sky = s.light.sky.radiance(direction);
  return (luminance(sky) < s.light.bright_sky) != bright ? sky - s.constant : Rgb(0.0f);
}

/// Light in the direction of a ray that left the cloud after it was scattered there with the
/// density pdf(), weighted against samples of lights.
template <class Pdf>
inline void add_scattered(const PathSetup& s, const Pdf& pdf, Vec3f direction, Rgb throughput,
                          PathResult& r) {
  Rgb sum = s.light.sky.radiance(direction) - s.constant;
  if (s.light.sky.sampled()) sum *= balance(pdf(), s.light.sky.pdf(direction));
  if (r.in_layers()) r.sky() += throughput * sum;
  for (const std::uint32_t i : s.light.suns) {
    const auto& sun = std::get<SunLight>(s.light.sources[i]);
    const Rgb seen = sun.seen(direction);
    if (!(largest(seen) > 0)) continue;
    const Rgb weighted = seen * balance(pdf(), sun.pdf());
    sum += weighted;
    if (r.in_layers()) r.layers[i] += throughput * weighted;
  }
  r.radiance += throughput * sum;
}

/// A sample of a light, seen from a place of the world.
[[nodiscard]] inline LightSample sample_light(const LightSource& light, Vec3d place, Rng& rng) {
  return std::visit([&](const auto& l) { return l.sample([&] { return place; }, rng); }, light);
}

/// Of many lights so many are drawn.
inline constexpr int kAsked = 4;

/// ask(i, 1 / expected number of times that it is asked) on a surface for all lights, or for some
/// of many; on shadow catchers, which shall be clean in the open, of more than elsewhere. `cut` is
/// for its own use.
template <class Ask>
inline void ask_each(const LightSetup& lights, const OnPlane& at, bool catcher, LightCut& cut,
                     Rng& rng, const Ask& ask) {
  if (catcher ? lights.drawn_in_volumes : lights.drawn_on_surfaces)
    return lights.many->draw(at, kAsked, nullptr, cut, rng, ask);
  for (std::size_t i = 0; i < lights.sources.size(); ++i) ask(i, 1.0f);
}

/// The probability of a ray towards a fire, into whose direction a path of this throughput is
/// scattered with this density: by what the flight may bring beside the path's other light, which
/// falls with the distance to the fire as much. Faint and sideways ones are drawn by roulette.
[[nodiscard]] inline float value_of_fire_ray(Rgb throughput, float pdf) {
  constexpr float kEven = 4 * std::numbers::pi_v<float>, kSideways = 4;
  return std::min(absolute_luminance(throughput) * std::min(kSideways * kEven * pdf, 1.0f), 1.0f);
}

}  // namespace pvol::detail
