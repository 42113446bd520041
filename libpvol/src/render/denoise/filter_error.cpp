#include "render/denoise/filter_error.h"

#include <algorithm>
#include <cmath>

#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

/// With e_a and e_b the errors of the filtered halves a and b, ((e_a + e_b)/2)^2 =
/// (e_a^2 + e_b^2)/2 - ((e_a - e_b)/2)^2, of which the last term is seen. With u and v the halves
/// as they were, e_a^2 + e_b^2 is on average (a - v)^2 + (b - u)^2 - (u - v)^2.
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
      const double a = double(filtered[0][c].row(y)[x]), b = double(filtered[1][c].row(y)[x]);
      const double u = double(halves.colour[0].values[c].row(y)[x]);
      const double v = double(halves.colour[1].values[c].row(y)[x]);
      const double twice = (a - v) * (a - v) + (b - u) * (b - u) - (u - v) * (u - v);
      raw.halves.row(y)[x] = float(twice / 2);
      raw.difference.row(y)[x] = float((a - b) * (a - b) / 4);
      raw.uncertainty.row(y)[x] =
          halves.colour[0].variances[c].row(y)[x] * halves.colour[1].variances[c].row(y)[x];
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
  double sum = 0, least = 0, uncertain = 0, count = 0;
  for (int y = 0; y < halves.filtered.height(); ++y) {
    for (int x = 0; x < halves.filtered.width(); ++x) {
      if (!(halves.filtered.row(y)[x] > 0)) continue;
      const double difference = double(raw.difference.row(y)[x]);
      sum += double(raw.halves.row(y)[x]) - difference, least += difference, ++count;
      uncertain += double(raw.uncertainty.row(y)[x]);
      const double variance = double(errors.variance.row(y)[x]);
      const double common = double(errors.mse.row(y)[x]) - 2 * variance;
      errors.mse.row(y)[x] =
          float(variance + believed(common, double(uncertainty.row(y)[x]) / kArea));
    }
  }
  errors.mean_mse = std::max(sum, least) / count;
  errors.deviation = std::sqrt(uncertain) / count;
  return errors;
}

}  // namespace pvol::detail
