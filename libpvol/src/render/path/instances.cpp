#include "render/path/instances.h"

#include <algorithm>

#include "pvol/volume/facts.h"
#include "pvol/volume/moving_places.h"

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
  if (std::ranges::any_of(volumes, places_move)) add_motion(volumes);
}

void Instances::add_motion(std::span<const Volume> volumes) {
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    const Volume& v = volumes[all[i].volume];
    motion.push_back({nullptr, {}});
    if (!place_moves(v, all[i].place)) continue;
    const MovingPlaces& moving = *v.moving_places;
    motion.back() = {&moving.all[all[i].place], cells_to_object(v.density, v)};
    all[i] = at_time(i, moving.shutter.at(0.5));
  }
}

Instance Instances::at_time(std::uint32_t number, double frames) const {
  Instance at = all[number];
  if (motion.empty() || motion[number].place == nullptr) return at;
  const InstanceMotion& m = motion[number];
  at.world_to_cells = inverse(m.place->at(frames) * m.cells_to_object);
  return at;
}

}  // namespace pvol::detail
