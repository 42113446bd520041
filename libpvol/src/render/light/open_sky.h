// The light of the whole sky on planes that see all of their side of it.
#pragma once

#include <array>
#include <vector>

#include "pvol/render/sky_light.h"

namespace pvol::detail {

/// The sky as some thousand vectors of irradiance: one for each patch of the sky and channel, along
/// the direction that the patch's light comes from on average. A plane that sees a patch as a whole
/// gets its part exactly; those of which the horizon cuts off some make an error of about 2e-4
/// under a smooth sky, and of up to some percent with a bright sun in the picture within 1.5
/// degrees of it.
class OpenSky {
 public:
  explicit OpenSky(const SkyLight& sky);

  /// Of a plane whose unit normal is this.
  [[nodiscard]] Rgb irradiance(Vec3d normal) const;

 private:
  std::vector<std::array<Vec3d, 3>> patches_;  ///< by channel
};

}  // namespace pvol::detail
