#include "render/plan/choose_wavefront.h"

#include "render/engine/wavefront/wavefront_scene.h"

namespace pvol::detail {

KernelChoice choose_wavefront(std::span<const Volume> volumes, const Scene& scene) {
  const KernelKind wanted = scene.options.kernel;
  const char* const obstacle =
      wanted == KernelKind::scalar ? nullptr : wavefront_obstacle(volumes, scene);
  return choose_kernel(wanted, obstacle, {.rays = "paths", .subject = "scene"});
}

}  // namespace pvol::detail
