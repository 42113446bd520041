#include "pvol/shell/free_form.h"

namespace pvol {
namespace {

// A term a_i max(0, Q_i)^2 inherits twice the relative error of Q_i and is rounded twice more; the
// sum rounds once for each term. rounding_error() counts eight for a quadric.
constexpr double kSquareErrors = 3;
constexpr double kSumError = 0x1p-52;

double largest(Interval a) { return std::max(std::abs(a.lo), std::abs(a.hi)); }

Interval positive_part(Interval a) { return {std::max(0.0, a.lo), std::max(0.0, a.hi)}; }

GradientRange operator+(const GradientRange& a, const GradientRange& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

GradientRange operator*(Interval k, const GradientRange& g) { return {k * g.x, k * g.y, k * g.z}; }

}  // namespace

double value(const FreeForm& form, Vec3d p) {
  double sum = value(form.base, p);
  for (const Perturbation& r : form.perturbations) {
    const double inside = std::max(0.0, value(r.quadric, p));
    sum += r.strength * (inside * inside);
  }
  return sum;
}

Vec3d gradient(const FreeForm& form, Vec3d p) {
  Vec3d sum = gradient(form.base, p);
  for (const Perturbation& r : form.perturbations) {
    const double inside = std::max(0.0, value(r.quadric, p));
    if (inside > 0) sum += gradient(r.quadric, p) * (2 * r.strength * inside);
  }
  return sum;
}

Interval range(const FreeForm& form, const Box& box) {
  Interval natural = range(form.base, box);
  if (form.perturbations.empty()) return natural;
  // Interval arithmetic follows the operations of value(), so it also holds what they round to.
  GradientRange slope = gradient_range(form.base, box);
  double error = rounding_error(form.base, box), magnitude = largest(natural);
  for (const Perturbation& r : form.perturbations) {
    const Interval q = range(r.quadric, box);
    const Interval inside = positive_part(q);
    if (inside.hi == 0) continue;
    natural = natural + Interval(r.strength) * square(inside);
    slope = slope + Interval(2 * r.strength) * inside * gradient_range(r.quadric, box);
    const double steep = std::abs(r.strength) * largest(q);
    error += kSquareErrors * steep * rounding_error(r.quadric, box);
    magnitude += steep * largest(q);
  }
  error += kSumError * double(form.perturbations.size() + 2) * magnitude;
  const Vec3d middle = box.centre();
  const auto offset = [&](int axis) {
    return Interval(box.lo[axis], box.hi[axis]) - Interval(middle[axis]);
  };
  const Interval mean_value = Interval(value(form, middle)) + slope.x * offset(0) +
                              slope.y * offset(1) + slope.z * offset(2);
  // The error once for the value in the middle, once for those that are compared with the result.
  return {std::max(natural.lo, round_down(mean_value.lo - 2 * error)),
          std::min(natural.hi, round_up(mean_value.hi + 2 * error))};
}

Box bounds(const FreeForm& form, double level) {
  Box box = bounds(form.base, level);
  for (const Perturbation& r : form.perturbations) {
    if (!(r.strength > 0)) continue;
    const Box bulge = bounds(r.quadric);
    if (!bulge.empty()) box = {min(box.lo, bulge.lo), max(box.hi, bulge.hi)};
  }
  return box;
}

FreeForm operator*(double k, const FreeForm& form) {
  FreeForm scaled = form;
  scaled.base = k * form.base;
  for (Perturbation& r : scaled.perturbations) r.strength *= k;
  return scaled;
}

FreeForm transform(const Affine& map, const FreeForm& form) {
  FreeForm moved = form;
  moved.base = transform(map, form.base);
  for (Perturbation& r : moved.perturbations) r.quadric = transform(map, r.quadric);
  return moved;
}

}  // namespace pvol
