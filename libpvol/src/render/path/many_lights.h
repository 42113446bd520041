// What each of many lights brings to a place, about: some of them are drawn by it.
#pragma once

#include <span>
#include <vector>

#include "pvol/render/lights.h"

namespace pvol::detail {

/// The lights of a scene, with those that shine evenly from places (points and balls, which lie
/// side by side) as tables.
class ManyLights {
 public:
  explicit ManyLights(std::vector<LightSource> lights);

  /// The luminance of what each light would bring to a plane that faces it at a place, about; above
  /// 0 wherever it brings any. `to` has room for all lights.
  void weigh(Vec3d place, std::span<double> to) const;

 private:
  std::vector<LightSource> lights_;
  std::size_t first_ = 0;                  // of those in the tables
  std::vector<double> x_, y_, z_, power_;  // places, and luminances of intensities
};

}  // namespace pvol::detail
