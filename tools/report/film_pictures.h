// Films as pictures for pages: as they are, their differences, and the work that they took.
#pragma once

#include <span>
#include <string>

#include "pvol/render/film.h"
#include "report/document.h"

namespace pvol::cli {

/// An <img> of the film at an exposure in stops.
[[nodiscard]] std::string film_image(const Film& film, double exposure,
                                     const std::string& description);

/// An <img> of luminance a - b over blocks of 4 x 4 pixels: blue where a is darker, orange where it
/// is brighter, full at +-`full`, above 0.
[[nodiscard]] std::string difference_image(const Film& a, const Film& b, double full,
                                           const std::string& description);

/// Look-ups per sample by pixel, each from dark to light by their logarithm on a scale that all the
/// films share.
struct NamedFilm {
  std::string name;
  const Film* film;
};
struct LookupMaps {
  double most = 0;  ///< at the end of the scale
  std::vector<report::Figure> figures;
};
[[nodiscard]] LookupMaps lookup_maps(std::span<const NamedFilm> films);

}  // namespace pvol::cli
