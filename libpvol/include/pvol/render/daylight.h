// What a clear sky comes to.
#pragma once

#include "pvol/render/sky.h"
#include "pvol/render/sun.h"
#include "pvol/render/sun_position.h"

namespace pvol {

/// Where the sun of a sky is seen.
[[nodiscard]] SunPosition sun_of(const ClearSky& sky);

struct Daylight {
  ImageSky picture;  ///< without the sun; for SkyPixels::smooth, the lower half is the ground
  Sun sun;           ///< as it shines at the ground; black where it has set
};

/// Computes a sky of valid values (`validate`): 0.1 to 0.4 s on two cores. What it neglects:
/// polarisation, clouds, water vapour, the height of the observer, bending of rays, light of moon
/// and stars. Radiances are finite and not negative whatever the values (THEORY.md, T5.16).
[[nodiscard]] Daylight make_daylight(const ClearSky& sky);

}  // namespace pvol
