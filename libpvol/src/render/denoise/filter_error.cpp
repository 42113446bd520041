#include "render/denoise/filter_error.h"

#include <algorithm>

#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

/// With e_a and e_b the errors of the filtered halves, ((e_a + e_b)/2)^2 =
/// (e_a^2 + e_b^2)/2 - ((e_a - e_b)/2)^2, of which the last term is seen, and e_a^2 is on average
/// (a - v)^2 less the variance of v, the other half as it was.
struct RawErrors {
  Plane halves;       ///< (e_a^2 + e_b^2)/2, on average
  Plane difference;   ///< ((e_a - e_b)/2)^2
  Plane uncertainty;  ///< variance of `halves`, were noise normal and the filter without error
};

RawErrors find_raw_errors(const Halves& halves, const std::array<Planes, 2>& filtered,
                          std::size_t c) {
  const int width = halves.filtered.width(), height = halves.filtered.height();
  RawErrors raw{{width, height, 0}, {width, height, 0}, {width, height, 0}};
  parallel_for(0, std::size_t(height), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      double sum = 0, uncertain = 0;
      for (const std::size_t half : {0u, 1u}) {
        const Guide& other = halves.colour[1 - half];
        const double d = double(filtered[half][c].row(y)[x]) - double(other.values[c].row(y)[x]);
        const double noise = double(other.variances[c].row(y)[x]);
        sum += (d * d - noise) / 2, uncertain += noise * noise / 2;
      }
      const double d = double(filtered[0][c].row(y)[x]) - double(filtered[1][c].row(y)[x]);
      raw.halves.row(y)[x] = float(sum);
      raw.difference.row(y)[x] = float(d * d / 4);
      raw.uncertainty.row(y)[x] = float(uncertain);
    }
  });
  return raw;
}

/// What the halves' common error adds to the variance. Where that is less than its own uncertainty
/// little of it is believed: the positive part of noise would else look like an error everywhere.
double believed(double common, double uncertainty) {
  constexpr double kDeviations = 3;
  if (!(common > 0)) return 0;
  return common * (common * common / (common * common + kDeviations * kDeviations * uncertainty));
}

}  // namespace

Errors find_errors(const Halves& halves, const std::array<Planes, 2>& filtered, std::size_t c) {
  constexpr int kSmooth = 9;
  constexpr double kArea = (2 * kSmooth + 1) * (2 * kSmooth + 1);
  const RawErrors raw = find_raw_errors(halves, filtered, c);
  Errors errors{box_mean(raw.difference, halves.filtered, kSmooth),
                box_mean(raw.halves, halves.filtered, kSmooth)};
  const Plane uncertainty = box_mean(raw.uncertainty, halves.filtered, kSmooth);
  double sum = 0, least = 0, count = 0;
  for (int y = 0; y < halves.filtered.height(); ++y) {
    for (int x = 0; x < halves.filtered.width(); ++x) {
      if (!(halves.filtered.row(y)[x] > 0)) continue;
      const double difference = double(raw.difference.row(y)[x]);
      sum += double(raw.halves.row(y)[x]) - difference, least += difference, ++count;
      const double variance = double(errors.variance.row(y)[x]);
      const double common = double(errors.mse.row(y)[x]) - 2 * variance;
      errors.mse.row(y)[x] =
          float(variance + believed(common, double(uncertainty.row(y)[x]) / kArea));
    }
  }
  errors.mean_mse = std::max(sum, least) / count;
  return errors;
}

}  // namespace pvol::detail
