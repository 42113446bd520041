// Layers that are parts of a film's colour, such as the light of each source, filtered so that they
// still sum up to it (THEORY.md, T5.22).
#pragma once

#include <vector>

#include "pvol/render/denoise.h"
#include "render/denoise/denoise_inputs.h"

namespace pvol::detail {

/// Numbers of a film's layers that together sum up to its colour.
using ColourParts = std::vector<std::size_t>;

/// Those of its lights, and those by number of scatterings, as far as it has them.
[[nodiscard]] std::vector<ColourParts> find_colour_parts(const Film& film);

/// Their planes, three of each layer, in units of `halves.scale`; where the picture has fireflies
/// what a layer has above the mean around it is spread.
[[nodiscard]] Planes planes_of_parts(const Film& film, const std::vector<ColourParts>& sets,
                                     const Halves& halves, int margin);

/// The values of the layers in their order from filtered planes, of which the mean is taken: scaled
/// in each pixel so that those of a set sum up to `colour`. Pixels that were left stay.
[[nodiscard]] std::vector<FilteredLayer> fit_parts(const Film& film,
                                                   const std::vector<ColourParts>& sets,
                                                   const Halves& halves,
                                                   const std::array<const Plane*, 2>& filtered,
                                                   const std::vector<Vec3d>& colour);

}  // namespace pvol::detail
