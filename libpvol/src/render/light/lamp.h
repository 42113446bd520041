// Lights at places, as points.
#pragma once

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

}  // namespace pvol::detail
