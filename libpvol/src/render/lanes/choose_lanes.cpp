#include "render/lanes/choose_lanes.h"

#include "render/lanes/lane_scene.h"

namespace pvol::detail {

LaneChoice choose_lanes(std::span<const Volume> volumes, const Scene& scene) {
  const Lanes wanted = scene.options.kernel;
  const char* const obstacle = wanted == Lanes::scalar ? nullptr : lane_obstacle(volumes, scene);
  return choose_lanes(wanted, obstacle, {.rays = "paths", .subject = "scene"});
}

}  // namespace pvol::detail
