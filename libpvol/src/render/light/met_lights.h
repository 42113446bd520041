// Lights with an extent, which flights may meet.
#pragma once

#include <span>

#include "pvol/render/lights.h"
#include "render/scene/box_tree.h"

namespace pvol::detail {

/// Those of a scene's lights that are met, by their boxes.
class MetLights {
 public:
  explicit MetLights(std::span<const LightSource> lights);

  [[nodiscard]] bool any() const { return any_; }

  /// visit(number) for the lights that a ray of unit direction may meet before a distance.
  template <class Visit>
  void visit(const Ray& ray, double distance, const Visit& visit) const {
    if (!any_) return;
    tree_.visit(ray, distance, [&](std::uint32_t light, double limit) {
      visit(std::size_t(light));
      return limit;
    });
  }

 private:
  bool any_ = false;
  BoxTree tree_;
};

}  // namespace pvol::detail
