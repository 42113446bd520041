// Numbers by pixel, for pictures and histograms of films: how far two of them differ, and the work
// that they took. Rows from the top, as in films.
#pragma once

#include <vector>

#include "pvol/render/film.h"

namespace pvol::measure {

/// Every pixel's difference a - b in luminance, and the same in standard deviations of its own; 0
/// for pixels without variance.
struct Differences {
  std::vector<double> values, sigmas;
};
[[nodiscard]] Differences differences(const Film& a, const Film& b);

/// Luminance of a - b averaged over blocks of edge x edge pixels, which shows a bias that the noise
/// of pixels hides.
[[nodiscard]] std::vector<double> block_differences(const Film& a, const Film& b, int edge);

/// The first film less the second, with the variance of the difference and all samples.
[[nodiscard]] Film difference_film(const Film& a, const Film& b);

/// Look-ups for each sample, and for each real collision; 0 where there are none of those.
[[nodiscard]] std::vector<double> lookups_per_sample(const Film& film);
[[nodiscard]] std::vector<double> lookups_per_collision(const Film& film);

/// The value below which a share in [0, 1] of all finite values lies; 0 where there is none.
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// The value that a share of all values does not exceed in size, for the ends of a scale: above 0.
[[nodiscard]] double range_of(std::vector<double> values, double share);

/// Stops within +-60 with which a film of this mean luminance looks neither dark nor burnt out.
[[nodiscard]] double exposure_for_mean(const Film& film);
/// Stops within +-60 that bring the brightest pixels of both films, but for 1 - share of all, just
/// below white.
[[nodiscard]] double exposure_below_white(const Film& a, const Film& b, double share);

/// How standard deviations are spread: shares of pixels with variance in bins of equal width from
/// -end to end, the outer ones with what lies beyond, and what the normal law puts into a bin
/// around x.
struct SigmaHistogram {
  double end = 6, width = 0.25;
  double pixels = 0;
  std::vector<double> shares;
  [[nodiscard]] double lower_edge(std::size_t bin) const { return -end + width * double(bin); }
  [[nodiscard]] double expected(double x) const;
};
[[nodiscard]] SigmaHistogram sigma_histogram(const std::vector<double>& sigmas);

}  // namespace pvol::measure
