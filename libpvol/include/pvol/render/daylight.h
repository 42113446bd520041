// What a clear sky comes to.
#pragma once

#include "pvol/math/color_space.h"
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

/// Computes a sky of valid values (`validate`) in 0.1 to 0.3 s of two cores, the longer the lower
/// the sun and the thicker the haze; the same on any number of threads. Neglected are polarisation,
/// clouds, water vapour, the height of the observer, the bending of rays, moon and stars. Radiances
/// are finite and not negative whatever the values (THEORY.md, T5.16).
[[nodiscard]] Daylight make_daylight(const ClearSky& sky, ColorSpace space = ColorSpace::rec709);

}  // namespace pvol
