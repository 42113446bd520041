// Films as pictures for pages: as they are, their differences, and the work that they took.
#pragma once

#include <string>

#include "pvol/render/film.h"

namespace pvol::cli {

/// Stops with which a film of this mean luminance looks neither dark nor burnt out.
[[nodiscard]] double choose_exposure(const Film& film);

/// An <img> of the film at an exposure in stops.
[[nodiscard]] std::string film_image(const Film& film, double exposure,
                                     const std::string& description);

/// An <img> of luminance a - b over blocks of 4 x 4 pixels: blue where a is darker, orange where it
/// is brighter, full at +-`full`, above 0.
[[nodiscard]] std::string difference_image(const Film& a, const Film& b, double full,
                                           const std::string& description);

/// An <img> of look-ups per sample by pixel, from dark to light by their logarithm; the brightest
/// is `most` or more.
[[nodiscard]] std::string lookup_image(const Film& film, double most,
                                       const std::string& description);

/// Most look-ups per sample of a pixel.
[[nodiscard]] double most_lookups(const Film& film);

}  // namespace pvol::cli
