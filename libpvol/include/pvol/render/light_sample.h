// What a light answers that is asked for a direction towards it.
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

}  // namespace pvol
