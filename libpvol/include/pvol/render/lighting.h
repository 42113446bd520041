// All light of a scene that comes from outside its media.
#pragma once

#include <vector>

#include "pvol/render/scene.h"
#include "pvol/render/sky_light.h"

namespace pvol {

/// What surrounds a scene, and every light: those that it lists, then the sun of a clear sky.
struct Lighting {
  SkyLight sky;
  std::vector<Light> lights;
};

/// Of valid scenes. A clear sky is computed here, once for all who share what comes of it.
[[nodiscard]] Lighting make_lighting(const Scene& scene);

/// Most lights of a scene.
inline constexpr std::size_t kMostLights = 16'383;

/// How many lights that has at most, without making it.
[[nodiscard]] std::size_t most_lights(const Scene& scene);

}  // namespace pvol
