// How bright a sky is that is not sampled.
#pragma once

#include "pvol/render/sky_light.h"

namespace pvol::detail {

/// Luminance of a sky that is not sampled, averaged over the six directions of the axes; 0 of one
/// that is.
[[nodiscard]] inline float smooth_luminance(const SkyLight& sky) {
  if (sky.sampled()) return 0;
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      Vec3f d;
      d[axis] = sign;
      sum += luminance(sky.radiance(d)) / 6;
    }
  }
  return sum;
}

}  // namespace pvol::detail
