// What lights answer that are asked for a direction towards them, or met by rays.
#pragma once

#include <limits>

#include "pvol/math/vec.h"

namespace pvol {

/// A direction towards a light with what comes from there.
struct LightSample {
  Vec3f direction;  ///< unit, from the scene
  Rgb radiance;     ///< of a delta light: irradiance of a plane that faces it
  float pdf = 0;    ///< per steradian; 0 of a delta light, which no ray meets by chance
  double distance = std::numeric_limits<double>::infinity();  ///< to the light, world units
};

/// A light that a ray met on its way.
struct LightMet {
  Rgb radiance{0.0f};  ///< 0: it did not
  float pdf = 0;  ///< per steradian, with which a sample from the ray's origin has its direction
  bool visible = true;                                        ///< to the camera
  double distance = std::numeric_limits<double>::infinity();  ///< to the light, world units
};

}  // namespace pvol
