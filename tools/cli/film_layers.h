// The layers of a film by the names of their AOVs, as arrays of numbers.
#pragma once

#include <string>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::cli {

/// An image of a film's crop, rows from the top.
struct Plane {
  int components = 1;
  std::vector<float> values{};
};

/// What `layer_of` takes: the figures that each pixel has, counts only where the film is `counted`,
/// and the film's own layers.
[[nodiscard]] std::vector<std::string> layer_names(const Film& film, bool counted);

/// A layer, or a figure that each pixel has, by the name of its AOV. Throws Error that lists those
/// that there are.
[[nodiscard]] Plane layer_of(const Film& film, bool counted, const std::string& name);

}  // namespace pvol::cli
