// What the verb `image` says in words, tables and maps.
#pragma once

#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "report/html.h"

namespace pvol::cli {

struct ImagePair {
  std::string name_a, name_b;
  formats::StoredFilm a, b;
};

/// A line of the table: one figure of each channel.
struct ImageFigure {
  std::string name;
  std::string (*text)(const measure::ChannelComparison&);
  bool needs_variances = true;
};
[[nodiscard]] std::vector<ImageFigure> image_figures(const measure::FilmComparison& r);

/// About the largest difference, and how many pixels differ by much.
[[nodiscard]] std::vector<std::string> describe_pixels(const measure::FilmComparison& r);

/// Whether a bias was found, how sure that is, and where.
[[nodiscard]] std::string describe_verdict(const measure::FilmComparison& r);

/// The first film less the second, with the variance of the difference and all samples.
[[nodiscard]] Film difference_film(const Film& a, const Film& b);

/// Differences of luminance as colours, up to the limit to either side.
struct DifferenceMap {
  formats::Picture picture;
  double limit = 1;
};
[[nodiscard]] DifferenceMap difference_map(const ImagePair& pair);

/// The page: both pictures, where they differ, and the figures.
[[nodiscard]] html::Page image_page(const ImagePair& pair, const measure::FilmComparison& r);

}  // namespace pvol::cli
