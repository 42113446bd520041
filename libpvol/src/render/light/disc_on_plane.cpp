#include "render/light/disc_on_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pvol::detail {

double disc_on_plane(double angle, double radius) {
  using std::numbers::pi;
  if (angle + radius <= pi / 2) return std::cos(angle);
  if (angle - radius >= pi / 2) return 0;
  // Of a disc that sets, arcs at equal angles from the normal are summed.
  constexpr int kArcs = 512;
  const double from = std::max(angle - radius, 0.0), step = (pi / 2 - from) / kArcs;
  double sum = 0;
  for (int i = 0; i < kArcs; ++i) {
    const double a = from + (i + 0.5) * step;
    const double cosine =
        (std::cos(radius) - std::cos(a) * std::cos(angle)) / (std::sin(a) * std::sin(angle));
    sum += std::cos(a) * std::sin(a) * 2 * std::acos(std::clamp(cosine, -1.0, 1.0)) * step;
  }
  return sum / (pi * std::sin(radius) * std::sin(radius));
}

}  // namespace pvol::detail
