// The layers of a film by the names of their AOVs, as arrays of numbers.
#pragma once

#include <string>
#include <vector>

#include "pvol/render/aov.h"
#include "pvol/render/film.h"

namespace pvol::cli {

/// An image of a film's crop, rows from the top.
struct Plane {
  int components = 1;
  std::vector<float> values{};
};

/// The figures that each pixel of a rendered film has (film_channels.h), counts only where it is
/// `counted`.
[[nodiscard]] AovSet figures_of_renders(bool counted);

/// What `layer_of` takes: these figures of each pixel, and the film's own layers.
[[nodiscard]] std::vector<std::string> layer_names(const Film& film, AovSet figures);

/// A layer, or one of these figures of each pixel, by the name of its AOV. Throws Error that lists
/// those that there are.
[[nodiscard]] Plane layer_of(const Film& film, AovSet figures, const std::string& name);

}  // namespace pvol::cli
