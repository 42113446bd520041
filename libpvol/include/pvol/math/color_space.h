// What the three channels of linear colours stand for.
#pragma once

#include <optional>

#include "pvol/math/affine.h"
#include "pvol/math/names.h"
#include "pvol/math/vec.h"

namespace pvol {

/// Spaces of linear colours in which scenes can be described and rendered. The first is that of
/// every function and file where nothing else is written.
enum class ColorSpace {
  rec709,   ///< of sRGB: ITU-R BT.709 with D65
  rec2020,  ///< ITU-R BT.2020 with D65
  p3,       ///< SMPTE EG 432-1: P3 with D65
  acescg,   ///< AP1 with the white of ACES, S-2014-004
  aces,     ///< AP0 with the white of ACES: ACES2065-1, SMPTE ST 2065-1
};
[[nodiscard]] constexpr auto names(ColorSpace) {
  return std::to_array<Named<ColorSpace>>({{ColorSpace::rec709, "rec709"},
                                           {ColorSpace::rec2020, "rec2020"},
                                           {ColorSpace::p3, "p3-d65"},
                                           {ColorSpace::acescg, "acescg"},
                                           {ColorSpace::aces, "aces2065-1"}});
}

/// CIE 1931.
struct Chromaticity {
  double x = 0, y = 0;
};

struct Primaries {
  Chromaticity red, green, blue, white;
};

[[nodiscard]] Primaries primaries_of(ColorSpace space);

/// The space with these primaries to within 0.002, as they are published with two to four digits.
[[nodiscard]] std::optional<ColorSpace> find_space(const Primaries& primaries);

/// Linear map of colours by one set of primaries to those by another, where white stays white: by
/// the chromatic adaptation of Bradford (ICC.1:2022, annex E; THEORY.md, T5.24). The same primaries
/// give the identity to the last bit. None for primaries on one line and for a white that is not
/// between them.
[[nodiscard]] std::optional<Affine> conversion(const Primaries& from, const Primaries& to);
[[nodiscard]] Affine conversion(ColorSpace from, ColorSpace to);

/// The shares of red, green and blue in luminance, whose sum is 1.
[[nodiscard]] Vec3d luminance_weights(ColorSpace space);

/// The colour with channels of at least 0 and the same luminance by these weights, which a screen
/// or a light of the space can have; black where that is negative.
[[nodiscard]] Vec3d into_gamut(Vec3d color, Vec3d weights);

}  // namespace pvol
