#include "render/plan/choose_wavefront.h"

#include "render/engine/wavefront/lane_scene.h"

namespace pvol::detail {

LaneChoice choose_lanes(std::span<const Volume> volumes, const Scene& scene) {
  const KernelKind wanted = scene.options.kernel;
  const char* const obstacle =
      wanted == KernelKind::scalar ? nullptr : lane_obstacle(volumes, scene);
  return choose_lanes(wanted, obstacle, {.rays = "paths", .subject = "scene"});
}

}  // namespace pvol::detail
