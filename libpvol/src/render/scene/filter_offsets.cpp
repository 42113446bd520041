#include "render/scene/filter_offsets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace pvol::detail {
namespace {

/// Places in [0, 1] below which equal steps of the filter's weight lie.
using FilterPlaces = std::array<double, FilterOffsets::kSteps + 1>;

/// At x in [-1, 1], its ends.
double weight(PixelFilter filter, double x) {
  if (filter == PixelFilter::gaussian) return std::exp(-4.5 * x * x);  // the ends are 3 deviations
  const double c = std::cos(std::numbers::pi * (x + 1));  // and of twice and three times the angle
  return 0.35875 - 0.48829 * c + 0.14128 * (2 * c * c - 1) - 0.01168 * (4 * c * c - 3) * c;
}

FilterPlaces find_places(PixelFilter filter) {
  constexpr int kParts = 1 << 16, kSteps = int(FilterOffsets::kSteps);
  std::vector<double> up_to(kParts + 1);  // first the weight of each part, the same in both halves
  for (int i = 0; i < kParts / 2; ++i) {
    const double w = weight(filter, (2 * i + 1.0) / kParts - 1);
    up_to[std::size_t(i + 1)] = up_to[std::size_t(kParts - i)] = w;
  }
  std::partial_sum(up_to.begin(), up_to.end(), up_to.begin());
  FilterPlaces places{};
  int part = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double share = up_to.back() * double(i) / kSteps;
    while (part + 1 < kParts && up_to[std::size_t(part + 1)] <= share) ++part;
    const double lo = up_to[std::size_t(part)], hi = up_to[std::size_t(part + 1)];
    places[std::size_t(i)] = std::min((part + (share - lo) / (hi - lo)) / kParts, 1.0);
  }
  return places;
}

/// The same, found once in a process: each render makes several tables.
const FilterPlaces& places_of(PixelFilter filter) {
  if (filter == PixelFilter::gaussian) {
    static const FilterPlaces gaussian = find_places(PixelFilter::gaussian);
    return gaussian;
  }
  static const FilterPlaces blackman_harris = find_places(PixelFilter::blackman_harris);
  return blackman_harris;
}

}  // namespace

FilterOffsets::FilterOffsets(PixelFilter filter, std::optional<double> width)
    : is_box_(filter == PixelFilter::box), width_(float(width.value_or(is_box_ ? 1.0 : 3.0))) {
  if (is_box_) return;
  const FilterPlaces& places = places_of(filter);
  for (std::size_t i = 0; i <= kSteps; ++i) at_[i] = float((places[i] - 0.5) * double(width_));
}

}  // namespace pvol::detail
