// Samples of a film's pixels.
#pragma once

#include <algorithm>
#include <cstdint>

#include "pvol/render/film.h"

namespace pvol::cli {

/// Of all pixels together.
[[nodiscard]] inline std::uint64_t count_samples(const Film& film) {
  std::uint64_t n = 0;
  for (const PixelSums& p : film.pixels) n += p.samples;
  return n;
}

/// Of the pixel that has fewest; 0 without pixels.
[[nodiscard]] inline std::uint32_t least_samples(const Film& film) {
  const auto fewest = std::ranges::min_element(film.pixels, {}, &PixelSums::samples);
  return fewest == film.pixels.end() ? 0 : fewest->samples;
}

/// The film without what only further samples need, half of its size.
[[nodiscard]] inline Film without_sums(const Film& film) {
  Film seen = window_of(film);
  seen.pixels = film.pixels;
  seen.counts = film.counts;
  seen.layers = film.layers;
  seen.first_sample = film.first_sample;
  return seen;
}

}  // namespace pvol::cli
