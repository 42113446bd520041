// Whether pieces of a picture make a whole: each sample of each pixel once.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pvol/formats/film_record.h"

namespace pvol::cli {

/// Two pieces that have a sample of one seed in common.
struct Doubled {
  std::size_t a = 0, b = 0;  ///< indices
  formats::FilmPiece both;   ///< what they have in common
};

/// The first ones, if there are any. Adaptive pieces have all samples of their pixels.
[[nodiscard]] std::optional<Doubled> find_doubled(const std::vector<formats::FilmPiece>& pieces);

/// Pixels without some samples of a seed.
struct Missing {
  std::size_t pixels = 0;    ///< of the whole
  formats::FilmPiece first;  ///< a pixel and its samples; adaptive: 0:0
};

/// What pieces, none of them doubled, lack of a whole: the same window, samples and seed.
[[nodiscard]] std::optional<Missing> find_missing(const std::vector<formats::FilmPiece>& pieces,
                                                  const formats::FilmPiece& whole);

/// "samples 16:32 of pixels 0,0 to 63,47 of seed 1".
[[nodiscard]] std::string describe(const formats::FilmPiece& piece);

}  // namespace pvol::cli
