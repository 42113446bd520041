#include "form/taylor.h"

namespace pvol {
namespace {

Vec3d magnitude(Vec3d v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
Vec3d mixed_products(Vec3d v) { return {v.y * v.z, v.z * v.x, v.x * v.y}; }

/// The range of the linear part is [-linear, linear], that of the rest of the polynomial but for
/// the constant is within [lo, hi].
struct Spread {
  double linear, lo, hi;
};
Spread spread(const Quadric& q, Vec3d half) {
  const Vec3d squares = half * half;
  const double mixed = dot(magnitude(q.mixed), mixed_products(half));
  return {dot(magnitude(q.linear), half), dot(min(q.square, Vec3d(0)), squares) - mixed,
          dot(max(q.square, Vec3d(0)), squares) + mixed};
}

double largest(double lo, double hi) { return std::max(-lo, hi); }

/// Adds k times all of `q` but its constant.
void add_shape(Quadric& sum, double k, const Quadric& q) {
  sum.square += q.square * k;
  sum.mixed += q.mixed * k;
  sum.linear += q.linear * k;
}

/// strength * [lo, hi], the rounding left to the caller.
Interval scaled(double strength, double lo, double hi) {
  return strength > 0 ? Interval{strength * lo, strength * hi}
                      : Interval{strength * hi, strength * lo};
}

}  // namespace

TaylorForm expand(const Quadric& q, Vec3d centre, Vec3d half) {
  TaylorForm t;
  t.local = {q.square, q.mixed, gradient(q, centre), value(q, centre)};
  // For the value, for the slope and for sums of both: each term of slope . half is at most that of
  // the quadric, and rounded half as often.
  const Vec3d far = magnitude(centre) + half;
  const double error = 3 * rounding_error(q, {-far, far});
  t.rest = {-error, error};
  const Spread s = spread(t.local, half);
  const double centred = t.local.constant;
  t.values = {centred - s.linear + s.lo - error, centred + s.linear + s.hi + error};
  return t;
}

TaylorForm expand(const FreeForm& form, Vec3d centre, Vec3d half) {
  const TaylorForm base = expand(form.base, centre, half);
  if (form.perturbations.empty()) return base;
  TaylorSum sum(base, half);
  for (const Perturbation& r : form.perturbations)
    sum.add(r.strength, expand(r.form, centre, half));
  return sum.enclosure();
}

TaylorSum::TaylorSum(const TaylorForm& base, Vec3d half) : half_(half), sum_(base) {
  const Spread s = spread(base.local, half);
  magnitude_ = std::abs(base.local.constant) + s.linear + largest(s.lo, s.hi);
}

// With v = Q(c), delta = Q(c + d) - v = g . d + w, v+ = max(0, v), in all cases
//   max(0, Q)^2 = v+^2 + 2 v+ (g . d + w) + [0, max(0, delta + min(0, v))^2],
// and delta^2 = (g . d)^2 + w (2 g . d + w) where Q >= 0 in the whole box.
bool TaylorSum::add(double strength, const TaylorForm& form) {
  const double a = strength, v = form.local.constant;
  if (!(form.values.hi > 0) || a == 0) return false;
  const Spread s = spread(form.local, half_);
  const double w = largest(s.lo + form.rest.lo, s.hi + form.rest.hi);
  const double inside = std::max(0.0, v);
  Quadric& local = sum_.local;
  add_shape(local, 2 * a * inside, form.local);
  local.constant += a * (inside * inside);
  Interval rest = scaled(a, 2 * inside * form.rest.lo, 2 * inside * form.rest.hi);
  if (form.values.lo >= 0) {
    const Vec3d g = form.local.linear;
    local.square += g * g * a;
    local.mixed += mixed_products(g) * (2 * a);
    const double m = std::min(w, s.linear);
    const Interval square = scaled(a, -m * (2 * s.linear - m), w * (2 * s.linear + w));
    rest = {rest.lo + square.lo, rest.hi + square.hi};
  } else {
    // Below Q = 0 the remainder v+^2 - 2 v+ Q is the largest at the least Q.
    const double rise = std::max(0.0, form.values.hi - inside);
    const double below = inside * (inside - 2 * form.values.lo);
    const Interval square = scaled(a, 0, std::max(rise * rise, below));
    rest = {rest.lo + square.lo, rest.hi + square.hi};
  }
  sum_.rest = {sum_.rest.lo + rest.lo, sum_.rest.hi + rest.hi};
  const double low = std::max(0.0, form.values.lo), high = form.values.hi;
  const Interval natural = scaled(a, low * low, high * high);
  sum_.values = {sum_.values.lo + natural.lo, sum_.values.hi + natural.hi};
  const double reach = inside + s.linear + w;
  magnitude_ += std::abs(a) * (reach * reach);
  ++terms_;
  return true;
}

// Each term is rounded some ten times on its way, and the sum once for each term.
double TaylorSum::rounding() const { return 0x1p-48 * terms_ * magnitude_ + 0x1p-1000; }

TaylorForm TaylorSum::enclosure() const {
  const double error = rounding();
  TaylorForm t = sum_;
  t.rest = {t.rest.lo - error, t.rest.hi + error};
  t.values = {std::max(t.values.lo - error, pvol::least(t.local, half_).bound + t.rest.lo),
              std::min(t.values.hi + error, -pvol::least(-t.local, half_).bound + t.rest.hi)};
  return t;
}

Least TaylorSum::least() const {
  const Least l = pvol::least(sum_.local, half_);
  return {std::max(sum_.values.lo, l.bound + sum_.rest.lo) - rounding(), l.where};
}

Least least(const Quadric& q, Vec3d half) {
  Quadric left = q;  // in the axes that are not yet fixed
  Vec3d where;
  double bound = 0;
  // An axis along which q rises or falls in the whole box is put to its lower end, and the others
  // may follow then: two rounds find nearly all.
  bool fixed[3] = {};
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 3; ++i) {
      if (fixed[i]) continue;
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const double turn = 2 * std::abs(left.square[i]) * half[i] +
                          std::abs(left.mixed[k]) * half[j] + std::abs(left.mixed[j]) * half[k];
      if (std::abs(left.linear[i]) < turn) continue;
      fixed[i] = true;
      where[i] = left.linear[i] > 0 ? -half[i] : half[i];
      bound += where[i] * (left.linear[i] + left.square[i] * where[i]);
      left.linear[j] += left.mixed[k] * where[i];
      left.linear[k] += left.mixed[j] * where[i];
      left.mixed[j] = left.mixed[k] = 0;
    }
  }
  for (int i = 0; i < 3; ++i) {
    if (fixed[i]) continue;
    const double l = left.linear[i], s = left.square[i];
    where[i] = l > 0 ? -half[i] : half[i];
    if (2 * s * half[i] > std::abs(l)) where[i] = -l / (2 * s);
    bound += where[i] * (l + s * where[i]);
  }
  bound -= dot(magnitude(left.mixed), mixed_products(half));
  return {q.constant + bound, where};
}

}  // namespace pvol
