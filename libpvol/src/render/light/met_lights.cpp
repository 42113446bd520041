#include "render/light/met_lights.h"

#include <algorithm>
#include <vector>

namespace pvol::detail {

MetLights::MetLights(std::span<const LightSource> lights) {
  std::vector<Box> boxes;
  for (const LightSource& light : lights) {
    boxes.push_back(std::visit([](const auto& l) { return l.met_within(); }, light));
  }
  any_ = std::ranges::any_of(boxes, [](const Box& b) { return !b.empty(); });
  tree_ = BoxTree(boxes);
}

}  // namespace pvol::detail
