#include "pvol/math/ramp.h"

#include <algorithm>
#include <cmath>

namespace pvol {
namespace {

/// The first point that is not before x.
std::size_t not_before(const std::vector<RampPoint>& p, float x) {
  const auto at = std::lower_bound(p.begin(), p.end(), x,
                                   [](const RampPoint& point, float v) { return point.x < v; });
  return std::size_t(at - p.begin());
}

/// Slope between point i and the next.
double slope(const std::vector<RampPoint>& p, std::size_t i) {
  return (double(p[i + 1].y) - double(p[i].y)) / (double(p[i + 1].x) - double(p[i].x));
}

/// Slope at a point: the weighted harmonic mean of those on its sides, which keeps the cubic
/// monotonic between points; 0 where they differ in sign and at both ends.
double tangent(const std::vector<RampPoint>& p, std::size_t i) {
  if (i == 0 || i + 1 == p.size()) return 0;
  const double before = slope(p, i - 1), after = slope(p, i);
  if (!(before * after > 0)) return 0;
  const double h0 = double(p[i].x) - double(p[i - 1].x), h1 = double(p[i + 1].x) - double(p[i].x);
  const double w = (h0 + 2 * h1) / (3 * (h0 + h1));
  return before * after / (w * after + (1 - w) * before);
}

}  // namespace

float value_at(const Ramp& ramp, float x) {
  const std::vector<RampPoint>& p = ramp.points;
  if (p.empty()) return 0;
  const std::size_t next = not_before(p, x);
  if (next == p.size()) return p.back().y;
  if (next == 0 || p[next].x == x) return p[next].y;
  const RampPoint a = p[next - 1], b = p[next];
  const double length = double(b.x) - double(a.x), u = (double(x) - double(a.x)) / length;
  double y = 0;
  if (ramp.smooth) {
    const double m0 = length * tangent(p, next - 1), m1 = length * tangent(p, next), v = 1 - u;
    y = v * v * ((1 + 2 * u) * double(a.y) + u * m0) + u * u * ((1 + 2 * v) * double(b.y) - v * m1);
  } else {
    y = double(a.y) + u * (double(b.y) - double(a.y));
  }
  return std::clamp(float(y), std::min(a.y, b.y), std::max(a.y, b.y));
}

ValueRange range_over(const Ramp& ramp, ValueRange from) {
  const float first = value_at(ramp, from.lo), last = value_at(ramp, from.hi);
  ValueRange r{std::min(first, last), std::max(first, last)};
  if (ramp.smooth) {
    r.lo -= kRangeSlack * std::abs(r.lo);
    r.hi += kRangeSlack * std::abs(r.hi);
  }
  // No extremes but at points: of the cubic by its tangents, of lines anyway.
  for (std::size_t i = not_before(ramp.points, from.lo);
       i < ramp.points.size() && ramp.points[i].x <= from.hi; ++i) {
    r.lo = std::min(r.lo, ramp.points[i].y);
    r.hi = std::max(r.hi, ramp.points[i].y);
  }
  return r;
}

}  // namespace pvol
