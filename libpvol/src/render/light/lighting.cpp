#include "pvol/render/lighting.h"

#include <utility>

#include "pvol/render/daylight.h"

namespace pvol {

Lighting make_lighting(const Scene& scene) {
  const auto* clear = std::get_if<ClearSky>(&scene.environment);
  if (clear == nullptr) return {SkyLight(scene.environment), scene.lights};
  Daylight day = make_daylight(*clear, scene.options.color_space);
  Lighting all{SkyLight(SkyPicture(std::move(day.picture), SkyPixels::smooth)), scene.lights};
  if (clear->sun) all.lights.emplace_back(std::move(day.sun));
  return all;
}

std::size_t most_lights(const Scene& scene) {
  return scene.lights.size() + (std::holds_alternative<ClearSky>(scene.environment) ? 1 : 0);
}

}  // namespace pvol
