// The colour of glowing media.
#pragma once

#include "pvol/math/color_space.h"
#include "pvol/math/vec.h"

namespace pvol {

/// The linear colour of luminance 1 with the chromaticity of a black body of this temperature, for
/// the CIE 1931 observer; what falls outside the gamut is cut off at 0. Below 800 K, where next to
/// nothing is seen, that of 800 K, and above 40 000 K that of 40 000 K. Tabulated once; within
/// 1e-3 of the exact colour (THEORY.md, T5.13).
[[nodiscard]] Rgb blackbody_color(float kelvin, ColorSpace space = ColorSpace::rec709);

/// CIE 1931 chromaticity of a black body, by Planck's law and the colour matching functions in
/// steps of 10 nm: x and y, and 1 - x - y. For 500 K and more.
[[nodiscard]] Vec3d blackbody_chromaticity(double kelvin);

}  // namespace pvol
