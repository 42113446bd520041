// One camera path: free flights, emission, next-event estimation, scattering.
#pragma once

#include "render/path/direct_light.h"
#include "render/path/traversal.h"

namespace pvol::detail {

/// Paths of a throughput below this are continued with probability throughput / threshold.
inline constexpr float kPathRoulette = 1.0f / 16;

struct PathResult {
  Rgb radiance{0.0f};
  float alpha = 0;  ///< estimate of 1 - transmittance
};

/// Traces paths through what `Traversal` makes of the scene's volumes. That is chosen once a scene,
/// not once a collision.
template <class Traversal>
class PathTracer {
 public:
  explicit PathTracer(const PathSetup& setup) : traversal(setup), s_(setup) {}

  [[nodiscard]] PathResult trace(int x, int y, std::uint32_t sample) {
    Rng rng(s_.seed, std::uint64_t(y) * std::uint64_t(s_.width) + std::uint64_t(x), sample);
    const auto [jitter_x, jitter_y] = rng.uniform2();
    const Ray ray{s_.projection.origin,
                  s_.projection.direction(x + double(jitter_x), y + double(jitter_y))};
    direction_ = Vec3f(ray.d);
    if (!traversal.start(ray)) return {s_.background ? seen_light(s_, direction_) : Rgb(0.0f), 0};
    return walk(rng);
  }

  Traversal traversal;
  std::uint64_t collisions = 0, shadow_rays = 0;

 private:
  const PathSetup& s_;
  Vec3f direction_;                       // of the flight, in the world
  Vec3f from_;                            // before the last scattering
  const PhaseFunction* phase_ = nullptr;  // of the last scattering

  PathResult walk(Rng& rng) {
    PathResult r;
    Rgb throughput(1.0f);
    for (std::uint32_t bounces = 0;; ++bounces) {
      const Hit hit = traversal.fly(direction_, rng);
      throughput *= hit.weight;
      if (hit.matter == nullptr) {
        if (bounces > 0) {
          r.radiance += throughput * scattered_light(s_, *phase_, from_, direction_);
        } else {
          r.alpha = 1 - hit.weight;
          if (s_.background) r.radiance += throughput * seen_light(s_, direction_);
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
      const auto worth = [](std::size_t) { return 1.0f; };
      r.radiance +=
          light_here(s_, *phase_, direction_, throughput, worth, traversal, rng, shadow_rays);
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
};

}  // namespace pvol::detail
