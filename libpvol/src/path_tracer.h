// One camera path: free flights, emission, next-event estimation, scattering.
#pragma once

#include <algorithm>
#include <cmath>

#include "traversal.h"

namespace pvol::detail {

/// Weight of a sample of one technique against another (Veach 1997, balance heuristic).
[[nodiscard]] inline float balance(float pdf, float other) { return pdf / (pdf + other); }

/// Paths of a throughput below this are continued with probability throughput / threshold.
inline constexpr float kPathRoulette = 1.0f / 16;

/// Most shadow rays for one light at one collision.
inline constexpr int kMostShadowRays = 8;

[[nodiscard]] inline float largest(Rgb c) {
  return std::max(std::abs(c.x), std::max(std::abs(c.y), std::abs(c.z)));
}

/// Traces paths through what `Traversal` makes of the scene's volumes. That is chosen once a scene,
/// not once a collision.
template <class Traversal>
class PathTracer {
 public:
  explicit PathTracer(const PathSetup& setup) : traversal(setup), s_(setup) {}

  struct Result {
    Rgb radiance{0.0f};
    float alpha = 0;  ///< estimate of 1 - transmittance
  };

  [[nodiscard]] Result trace(int x, int y, std::uint32_t sample) {
    Rng rng(s_.seed, std::uint64_t(y) * std::uint64_t(s_.width) + std::uint64_t(x), sample);
    const auto [jitter_x, jitter_y] = rng.uniform2();
    const Ray ray{s_.projection.origin,
                  s_.projection.direction(x + double(jitter_x), y + double(jitter_y))};
    direction_ = Vec3f(ray.d);
    if (!traversal.start(ray)) return {s_.background ? seen_light() : Rgb(0.0f), 0};
    return walk(rng);
  }

  Traversal traversal;
  std::uint64_t collisions = 0, shadow_rays = 0;

 private:
  const PathSetup& s_;
  Vec3f direction_;                          // of the flight, in the world
  Vec3f from_;                               // before the last scattering
  const HenyeyGreenstein* phase_ = nullptr;  // of the last scattering

  Result walk(Rng& rng) {
    Result r;
    Rgb throughput(1.0f);
    for (std::uint32_t bounces = 0;; ++bounces) {
      const Hit hit = traversal.fly(direction_, rng);
      throughput *= hit.weight;
      if (hit.matter == nullptr) {
        if (bounces > 0) {
          r.radiance += throughput * scattered_light();
        } else {
          r.alpha = 1 - hit.weight;
          if (s_.background) r.radiance += throughput * seen_light();
        }
        return r;
      }
      if (bounces == 0) r.alpha = 1;
      ++collisions;
      const Matter& matter = *hit.matter;
      r.radiance += throughput * matter.emitted;
      if (bounces == s_.max_bounces) return r;
      throughput *= matter.albedo;
      if (!survives(throughput, rng)) return r;
      phase_ = &matter.phase;
      r.radiance += light_here(throughput, rng);
      from_ = direction_;
      direction_ = sample_phase(*phase_, from_, rng);
    }
  }

  [[nodiscard]] static bool survives(Rgb& throughput, Rng& rng) {
    const float most = largest(throughput);
    if (most >= kPathRoulette) return true;
    if (!(rng.uniform() * kPathRoulette < most)) return false;
    throughput *= kPathRoulette / most;
    return true;
  }

  /// Light in the direction of a camera ray that met nothing.
  [[nodiscard]] Rgb seen_light() const {
    Rgb sum = s_.sky.radiance(direction_);
    for (const SunLight& sun : s_.suns) {
      if (sun.hit(direction_)) sum += sun.radiance;
    }
    return sum;
  }

  /// Light in the direction of a scattered ray that left the cloud, weighted against `light_here`.
  [[nodiscard]] Rgb scattered_light() const {
    const auto pdf = [&] { return pdf_phase(*phase_, from_, direction_); };
    Rgb sum = s_.sky.radiance(direction_);
    if (s_.sky.sampled()) sum *= balance(pdf(), s_.sky.pdf(direction_));
    for (const SunLight& sun : s_.suns) {
      if (sun.hit(direction_)) sum += sun.radiance * balance(pdf(), sun.pdf);
    }
    return sum;
  }

  /// Next-event estimation: light of every sun and of a sampled sky that scatters here into the
  /// path, times its throughput.
  [[nodiscard]] Rgb light_here(Rgb throughput, Rng& rng) {
    Rgb sum(0.0f);
    for (const SunLight& sun : s_.suns) {
      const LightSample l = sun.sample(rng);
      const float p = pdf_phase(*phase_, direction_, l.direction);
      const float weight = sun.delta() ? 1 : balance(l.pdf, p);
      sum += shadowed(throughput * l.radiance * (weight * p / l.pdf), l.direction, rng);
    }
    if (s_.sky.sampled()) {
      const LightSample l = s_.sky.sample(rng);
      const float p = pdf_phase(*phase_, direction_, l.direction);
      sum += shadowed(throughput * l.radiance * (p / (l.pdf + p)), l.direction, rng);
    }
    return sum;
  }

  /// `light` times an estimate of the transmittance in its direction. The more light, the more
  /// shadow rays: none or one by roulette, or the mean over several (THEORY.md, T22).
  [[nodiscard]] Rgb shadowed(Rgb light, Vec3f direction, Rng& rng) {
    const float value = std::abs(luminance(light)) / s_.shadow_unit;
    if (!(value > 0)) return Rgb(0.0f);
    if (value < 1) {
      if (!(rng.uniform() < value)) return Rgb(0.0f);
      ++shadow_rays;
      return light * (traversal.pass(direction, rng) / value);
    }
    const int rays = value < float(kMostShadowRays) ? int(value) : kMostShadowRays;
    shadow_rays += std::uint64_t(rays);
    float sum = 0;
    for (int i = 0; i < rays; ++i) sum += traversal.pass(direction, rng);
    return light * (sum / float(rays));
  }
};

}  // namespace pvol::detail
