// Numbers as colours, for maps on pages and in files.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pvol/formats/image.h"

namespace pvol::cli {

enum class ColourMap {
  diverging,   ///< blue below 0, nearly white at 0, orange above: both ends alike in lightness
  sequential,  ///< dark blue, grey, yellow: rises in lightness throughout
};

using Srgb = std::array<std::uint8_t, 3>;

/// The colour at t in [0, 1] (beyond it that of the end); magenta for what is not a number.
[[nodiscard]] Srgb colour_at(ColourMap map, double t);

/// A map of width * height values, rows from the top: colours from `lo` to `hi`, lo < hi.
[[nodiscard]] formats::Picture map_colours(std::span<const double> values, int width, ColourMap map,
                                           double lo, double hi);

/// An <svg> of the colours with their values and what they stand for.
[[nodiscard]] std::string colour_bar(ColourMap map, double lo, double hi, const std::string& label);

}  // namespace pvol::cli
