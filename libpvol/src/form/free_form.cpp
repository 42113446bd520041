#include "pvol/form/free_form.h"

#include "form/taylor.h"

namespace pvol {
namespace {

constexpr double kHalfUlp = 0x1p-53;

/// A bound on |F'| and on the error of value(), from the magnitudes of all terms.
struct Magnitude {
  double value, error;
};
Magnitude magnitude(const FreeForm& form, const Box& box) {
  const double base_error = rounding_error(form.base, box);
  Magnitude sum{base_error * 0x1p49, base_error};  // the error is 2^-49 of it
  for (const Perturbation& r : form.perturbations) {
    const Magnitude q = magnitude(r.form, box);
    const double strength = std::abs(r.strength), square = strength * (q.value * q.value);
    sum.value += square;
    // Twice that of Q, and two products.
    sum.error += strength * q.error * (2 * q.value + q.error) + 3 * kHalfUlp * square;
  }
  // The sum rounds once for each term; one ulp more for this estimate itself.
  sum.error += double(form.perturbations.size() + 2) * 2 * kHalfUlp * sum.value;
  return sum;
}

}  // namespace

double value(const FreeForm& form, Vec3d p) {
  double sum = value(form.base, p);
  for (const Perturbation& r : form.perturbations) {
    const double inside = std::max(0.0, value(r.form, p));
    sum += r.strength * (inside * inside);
  }
  return sum;
}

Vec3d gradient(const FreeForm& form, Vec3d p) {
  Vec3d sum = gradient(form.base, p);
  for (const Perturbation& r : form.perturbations) {
    const double inside = std::max(0.0, value(r.form, p));
    if (inside > 0) sum += gradient(r.form, p) * (2 * r.strength * inside);
  }
  return sum;
}

double rounding_error(const FreeForm& form, const Box& box) {
  return form.perturbations.empty() ? rounding_error(form.base, box) : magnitude(form, box).error;
}

Interval range(const FreeForm& form, const Box& box) {
  if (form.perturbations.empty()) return range(form.base, box);
  const Vec3d centre = box.centre(), half = max(box.hi - centre, centre - box.lo);
  const Interval exact =
      expand(form, centre, {round_up(half.x), round_up(half.y), round_up(half.z)}).values;
  const double error = rounding_error(form, box);
  return {round_down(exact.lo - error), round_up(exact.hi + error)};
}

Box bounds(const FreeForm& form, double level) {
  Box box = bounds(form.base, level);
  for (const Perturbation& r : form.perturbations) {
    if (!(r.strength > 0)) continue;
    const Box bulge = bounds(r.form);
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

std::size_t count_quadrics(const FreeForm& form) {
  std::size_t count = 1;
  for (const Perturbation& p : form.perturbations) count += count_quadrics(p.form);
  return count;
}

FreeForm transform(const Affine& map, const FreeForm& form) {
  FreeForm moved = form;
  moved.base = transform(map, form.base);
  for (Perturbation& r : moved.perturbations) r.form = transform(map, r.form);
  return moved;
}

}  // namespace pvol
