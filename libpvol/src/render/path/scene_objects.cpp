#include "render/path/scene_objects.h"

#include <algorithm>

namespace pvol::detail {

SceneObjects::SceneObjects(const Scene& scene, const Instances& instances)
    : first_surface(instances.all.size()) {
  for (const Instance& at : instances.all) {
    const auto is_there = [&](const Instance& other) { return other.volume == at.volume; };
    std::string name = "volume_" + std::to_string(at.volume + 1);
    if (std::ranges::count_if(instances.all, is_there) > 1) {
      name += '.' + std::to_string(at.place + 1);
    }
    names.push_back(std::move(name));
  }
  std::vector<int> of_kind(std::variant_size_v<Surface>);
  for (const Surface& surface : scene.surfaces) {
    names.push_back(kind_name(surface) + ('_' + std::to_string(++of_kind[surface.index()])));
  }
}

}  // namespace pvol::detail
