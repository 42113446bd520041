// What a ray through shells of air meets, whatever shines there.
#pragma once

#include <vector>

#include "render/light/sky/air_ray.h"

namespace pvol::detail {

/// Light on its way by what scatters it last.
struct ByMatter {
  Spectrum molecules{}, aerosols{};
};

/// The way to the next level. Light that arrives at molecules and aerosols is linear in the
/// distance; its values at the near and the far end add to what the ray sees by these weights:
/// integrals of scattering times transmittance.
struct AirStep {
  int to;
  double t;  ///< there, in km from the ray's begin
  ByMatter near{}, far{};
  Spectrum transmittance{};  ///< transmittance of the step
};
struct AirPath {
  std::vector<AirStep> steps;
  bool grounded;  ///< whether it ends on the ground, rather than above the air
};

/// From a level, in a direction of this cosine with the zenith.
[[nodiscard]] AirPath make_path(const Atmosphere& a, int level, double cosine);

}  // namespace pvol::detail
