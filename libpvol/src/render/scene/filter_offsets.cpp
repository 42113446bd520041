#include "render/scene/filter_offsets.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace pvol::detail {
namespace {

/// At x in [-1, 1], its ends.
double weight(PixelFilter filter, double x) {
  if (filter == PixelFilter::gaussian) return std::exp(-4.5 * x * x);  // the ends are 3 deviations
  const double c = std::cos(std::numbers::pi * (x + 1));  // and of twice and three times the angle
  return 0.35875 - 0.48829 * c + 0.14128 * (2 * c * c - 1) - 0.01168 * (4 * c * c - 3) * c;
}

}  // namespace

FilterOffsets::FilterOffsets(PixelFilter filter, std::optional<double> width)
    : is_box_(filter == PixelFilter::box), width_(float(width.value_or(is_box_ ? 1.0 : 3.0))) {
  if (is_box_) return;
  constexpr int kParts = 1 << 16;
  std::vector<double> up_to(kParts + 1);  // first the weight of each part, the same in both halves
  for (int i = 0; i < kParts / 2; ++i) {
    const double w = weight(filter, (2 * i + 1.0) / kParts - 1);
    up_to[std::size_t(i + 1)] = up_to[std::size_t(kParts - i)] = w;
  }
  std::partial_sum(up_to.begin(), up_to.end(), up_to.begin());
  int part = 0;
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const double share = up_to.back() * double(i) / kSteps;
    while (part + 1 < kParts && up_to[std::size_t(part + 1)] <= share) ++part;
    const double lo = up_to[std::size_t(part)], hi = up_to[std::size_t(part + 1)];
    const double x = (part + (share - lo) / (hi - lo)) / kParts;
    at_[i] = float((std::min(x, 1.0) - 0.5) * double(width_));
  }
}

}  // namespace pvol::detail
