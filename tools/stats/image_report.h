// What the verb `image` says of two pictures.
#pragma once

#include <string>

#include "cli/json.h"
#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "report/document.h"

namespace pvol::cli {

struct ImageReport {
  std::string name_a, name_b;
  formats::StoredFilm a, b;
  measure::FilmComparison comparison;
};

/// Differences of luminance as colours, up to the limit to either side.
struct DifferenceMap {
  formats::Picture picture;
  double limit = 1;
};
[[nodiscard]] DifferenceMap difference_map(const Film& a, const Film& b);

/// With `pictures` what only pages show is drawn, too: both pictures and where they differ.
[[nodiscard]] report::Document image_document(const ImageReport& r, bool pictures);

[[nodiscard]] Json to_json(const ImageReport& r);

}  // namespace pvol::cli
