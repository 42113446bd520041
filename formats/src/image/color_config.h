// The OCIO configuration: the one that the environment variable OCIO names, as in other programs,
// or else a small one of our own with the views of ACES 1.0.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pvol/math/color_space.h"

namespace pvol::formats::detail {

/// Turns linear colours in place into what a screen's codes stand for, 0 to 1.
struct ScreenView {
  std::function<void(std::span<Vec3d>)> encode;
  bool is_srgb = true;  ///< whether the screen is, as far as its name tells
};

/// Views of the first display by their names, those of others as "display/view". Empty where pvol
/// was built without OCIO. Throws Error for a configuration that cannot be read.
[[nodiscard]] std::vector<std::string> views_of_config();

/// The view with this name, of colours in this space. Throws Error, which lists what there is, for
/// another one, and for a configuration whose linear spaces cannot be told.
[[nodiscard]] ScreenView find_view(const std::string& name, ColorSpace from);

/// Converts colours of a space of the configuration to linear ones of the space that is returned.
/// Throws Error as `find_view`.
[[nodiscard]] ColorSpace to_linear(std::span<Rgb> colors, const std::string& from);

}  // namespace pvol::formats::detail
