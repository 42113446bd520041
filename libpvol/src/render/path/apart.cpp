#include "render/path/apart.h"

#include <algorithm>
#include <numeric>

#include "pvol/volume/facts.h"
#include "render/scene/meet_boxes.h"

namespace pvol::detail {
namespace {

/// With a rim in which the rounding of places in cells is lost.
Box world_box_of(const Volume& v, std::size_t place) {
  constexpr double kRim = 1e-3;  // of the extent
  const Box box = world_box(v.density, v, place);
  const Vec3d rim = box.extent() * kRim;
  return {box.lo - rim, box.hi + rim};
}

/// Whether each box meets none of the others.
std::vector<std::uint8_t> are_alone(const std::vector<Box>& boxes) {
  std::vector<std::uint8_t> alone(boxes.size(), 1);
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return boxes[i].lo.x; });
  for (std::size_t a = 0; a < order.size(); ++a) {
    const std::uint32_t i = order[a];
    for (std::size_t b = a + 1; b < order.size() && boxes[order[b]].lo.x <= boxes[i].hi.x; ++b) {
      if (meet(boxes[i], boxes[order[b]])) alone[i] = alone[order[b]] = 0;
    }
  }
  return alone;
}

}  // namespace

ApartInstances::ApartInstances(std::span<const VolumeSetup> volumes, const Instances& instances,
                               const Surfaces* surfaces) {
  std::vector<Box> boxes;
  for (const Instance& i : instances.all) {
    boxes.push_back(world_box_of(volumes[i.volume].volume, i.place));
    to_world_.push_back(inverse(i.world_to_cells));
  }
  apart_ = are_alone(boxes);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const bool moves = instances.moves() && instances.motion[i].place != nullptr;
    const bool in_lanes = !volumes[instances.all[i].volume].one_by_one;
    const bool may_be = apart_[i] != 0 && !moves && in_lanes && !boxes[i].empty();
    apart_[i] = may_be && (surfaces == nullptr || !surfaces->may_reach(boxes[i]));
  }
  if (std::ranges::find(apart_, 1) == apart_.end()) *this = {};
}

}  // namespace pvol::detail
