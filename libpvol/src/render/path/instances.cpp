#include "render/path/instances.h"

#include "pvol/volume/facts.h"

namespace pvol::detail {

Instances::Instances(std::span<const Volume> volumes) {
  std::vector<Box> boxes;
  all.reserve(count_places(volumes));
  for (const Volume& v : volumes) {
    for (std::size_t place = 0; place < count_places(v); ++place) {
      all.push_back({.world_to_cells = v.density.world_to_cells * to_first_place(v, place),
                     .volume = std::uint32_t(&v - volumes.data()),
                     .place = std::uint32_t(place)});
      boxes.push_back(world_box(v.density, v, place));
    }
  }
  tree = BoxTree(boxes);
}

}  // namespace pvol::detail
