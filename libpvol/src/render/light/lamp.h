// Lights at places, as points.
#pragma once

#include <span>
#include <vector>

#include "pvol/render/lights.h"

namespace pvol::detail {

/// A light at a place, as a point there.
struct Lamp {
  Vec3d position{};
  double power = 0;  ///< luminance of its intensity; 0 of a sun
};

[[nodiscard]] Lamp lamp_of(const LightSource& light);

/// Whether it has an extent that the camera sees.
[[nodiscard]] bool camera_meets(const Light& light);

/// Those of a scene by the numbers of its lights, and as tables of floats for choices among many.
struct Lamps {
  std::vector<Lamp> all{};
  std::vector<double> x{}, y{}, z{};  ///< places
  std::vector<float> power{};         ///< with the greatest as unit

  Lamps() = default;
  explicit Lamps(std::span<const LightSource> lights);
};

}  // namespace pvol::detail
