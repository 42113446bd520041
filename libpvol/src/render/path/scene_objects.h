// What a film can tell apart of what the camera meets first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pvol/render/plan.h"
#include "render/path/instances.h"

namespace pvol::detail {

/// Each volume at each of its places, by the number of the instance, then each surface of the
/// scene.
struct SceneObjects {
  std::vector<std::string> names;  ///< "volume_1", "volume_2.3" (at its third place), "plane_1"
  std::size_t first_surface = 0;   ///< number of the first surface

  SceneObjects(const Scene& scene, const Instances& instances);
};

}  // namespace pvol::detail
