#include "pvol/volume/phase_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "pvol/error.h"

namespace pvol {
namespace {

using std::numbers::pi;
using Point = PhaseTable::Point;
using Knot = PhaseTable::Knot;

/// Above it a peak is narrower than directions in float resolve.
constexpr double kLargestDensity = 1e8;
/// What zeros count as: who weights by densities may divide 0 by 0 no more than elsewhere.
constexpr double kLeastDensity = 1e-30;

float density(double pdf) { return float(std::max(pdf, kLeastDensity)); }

double one_minus_cos_of(double degrees) {
  const double half = std::sin(degrees * (pi / 360));
  return 2 * half * half;
}

/// With densities of integral 1.
std::vector<Knot> make_knots(const std::vector<Point>& points) {
  double largest = 0;
  for (const Point& p : points) largest = std::max(largest, p.value);
  std::vector<Knot> knots;
  double sum = 0;
  for (const Point& p : points) {
    const Knot k{one_minus_cos_of(p.angle), p.value / largest, 0};
    if (!knots.empty()) {
      const Knot& before = knots.back();
      sum += pi * (k.one_minus_cos - before.one_minus_cos) * (before.pdf + k.pdf);
    }
    knots.push_back({k.one_minus_cos, k.pdf, sum});
  }
  for (Knot& k : knots) k.pdf /= sum, k.share /= sum;
  return knots;
}

double mean_cosine_of(const std::vector<Knot>& knots) {
  double sum = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const Knot &a = knots[i - 1], &b = knots[i];
    const double width = b.one_minus_cos - a.one_minus_cos;
    sum += width * (a.one_minus_cos * (a.pdf + b.pdf) / 2 + width * (a.pdf + 2 * b.pdf) / 6);
  }
  return 1 - 2 * pi * sum;
}

}  // namespace

const char* expect_phase_table(const std::vector<Point>& points) {
  if (points.size() < 2) return "at least two points [angle, value]";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [angle, value] = points[i];
    if (!(value >= 0) || !std::isfinite(value)) return "values that are finite and at least 0";
    if (i > 0 && !(angle > points[i - 1].angle)) return "ascending angles";
  }
  if (points.front().angle != 0 || points.back().angle != 180) {
    return "angles from 0 to 180 degrees, both included";
  }
  const std::vector<Knot> knots = make_knots(points);
  double largest = 0;
  for (const Knot& k : knots) largest = std::max(largest, k.pdf);
  // Where all are zero, or the peak is too narrow, nothing or little is left to divide by.
  if (!(largest > 0)) return "values that are not all 0";
  return largest <= kLargestDensity ? nullptr : "a peak that is wider than 0.003 degrees";
}

PhaseTable::PhaseTable(std::vector<Point> points) {
  if (const char* wanted = expect_phase_table(points)) {
    throw Error(std::string("the table is not a phase function; expected ") + wanted);
  }
  Data made{std::move(points), {}, 0};
  made.knots = make_knots(made.points);
  made.mean_cosine = mean_cosine_of(made.knots);
  data = std::make_shared<const Data>(std::move(made));
}

PhaseTable::PhaseTable() {
  static const PhaseTable isotropic({{0, 1}, {180, 1}});
  data = isotropic.data;
}

double mean_cosine(const PhaseTable& p) { return p.data->mean_cosine; }

float pdf_phase(const PhaseTable& p, Vec3f from, Vec3f to) {
  const std::vector<Knot>& knots = p.data->knots;
  const double c = double(one_minus_cos(from, to));
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, c,
                                      [](double v, const Knot& k) { return v < k.one_minus_cos; });
  const Knot &a = *(above - 1), &b = *above;
  const double t = std::min(1.0, (c - a.one_minus_cos) / (b.one_minus_cos - a.one_minus_cos));
  return density(a.pdf + t * (b.pdf - a.pdf));
}

// The share within a piece is quadratic in 1 - cos; the root is written without a difference.
PhaseSample sample_phase(const PhaseTable& p, Vec3f from, float u, float azimuth) {
  const std::vector<Knot>& knots = p.data->knots;
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, double(u),
                                      [](double v, const Knot& k) { return v < k.share; });
  const Knot &a = *(above - 1), &b = *above;
  const double width = b.one_minus_cos - a.one_minus_cos;
  const double rest = (double(u) - a.share) / (2 * pi);
  const double slope = (b.pdf - a.pdf) / width;
  const double pdf = std::sqrt(std::max(0.0, a.pdf * a.pdf + 2 * slope * rest));
  const double step = rest > 0 ? std::min(width, 2 * rest / (a.pdf + pdf)) : 0;
  const auto c = float(std::min(2.0, a.one_minus_cos + step));
  return {turn(from, c, azimuth), density(pdf)};
}

}  // namespace pvol
