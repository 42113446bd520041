#include "pvol/form/quadric.h"

#include <array>
#include <optional>

namespace pvol {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Eight roundings of half an ulp each on the way of a term to the sum, and as much again for the
// rounding of this estimate itself; among denormals the error is absolute.
constexpr double kValueError = 8 * 0x1p-52;
constexpr double kDenormalError = 0x1p-1060;

template <class T>
using Axes = std::array<T, 3>;

/// The divisor must not hold 0.
Interval operator/(Interval a, Interval b) {
  return a * Interval(round_down(1 / b.hi), round_up(1 / b.lo));
}

/// a b in interval arithmetic, exactly 0 where a is.
Interval times(double a, Interval b) { return a == 0 ? Interval(0) : Interval(a) * b; }
bool is_zero(Interval a) { return a.lo == 0 && a.hi == 0; }

/// Coefficient of x_i x_j, i != j.
double mixed(const Quadric& q, int i, int j) { return q.mixed[3 - i - j]; }

Interval slope(const Quadric& q, int axis, const Axes<Interval>& p) {
  Interval sum = q.linear[axis];
  for (int j = 0; j < 3; ++j) {
    const double c = j == axis ? 2 * q.square[axis] : mixed(q, axis, j);
    if (c != 0) sum = sum + times(c, p[std::size_t(j)]);
  }
  return sum;
}

Axes<Interval> exactly(Vec3d p) { return {p.x, p.y, p.z}; }

/// -Hessian over the free axes as L D L^T, in interval arithmetic.
struct Curvature {
  int count = 0;  ///< of free axes
  Axes<int> axis{};
  bool peak = false;  ///< certainly positive definite: an inner critical point is the maximum
  double slack = 0;   ///< else the maximum over a face exceeds that over its rim by this at most
  Axes<Interval> pivot;
  Axes<Axes<Interval>> lower;
};

/// Slack: where the pivot d_k may be zero, add eta sum_i m_i (x_i - c_i)^2 to Q, m_i = -square_i
/// and eta >= d_k / A_kk. That lowers the least eigenvalue of the scaled -Hessian, which d_k / A_kk
/// bounds from above, to zero or below, so the sum has its maximum on the rim; and it added at most
/// eta sum_i m_i w_i^2, w the half extents of the face.
Curvature curvature(const Quadric& q, Vec3d half_extent, unsigned free) {
  Curvature c;
  double bulge = 0;
  for (int i = 0; i < 3; ++i) {
    if (!(free >> i & 1)) continue;
    if (!(q.square[i] < 0)) return c;  // linear or convex along this axis
    c.axis[std::size_t(c.count++)] = i;
    bulge += -q.square[i] * half_extent[i] * half_extent[i];
  }
  double eta = 1;
  for (std::size_t k = 0; k < std::size_t(c.count); ++k) {
    const double diagonal = -2 * q.square[c.axis[k]];
    c.pivot[k] = diagonal;
    for (std::size_t j = 0; j < k; ++j) {
      Interval product = -mixed(q, c.axis[k], c.axis[j]);
      for (std::size_t i = 0; i < j; ++i) {
        product = product - c.lower[k][i] * c.lower[j][i] * c.pivot[i];
      }
      c.lower[k][j] = product / c.pivot[j];
      c.pivot[k] = c.pivot[k] - square(c.lower[k][j]) * c.pivot[j];
    }
    eta = std::min(eta, round_up(c.pivot[k].hi / diagonal));
    if (!(c.pivot[k].lo > 0)) {
      c.slack = eta > 0 ? round_up(eta * bulge * (1 + kValueError)) : 0;
      return c;
    }
  }
  c.peak = true;
  return c;
}

/// The solution x of L D L^T x = b.
Axes<Interval> solve(const Curvature& c, Axes<Interval> b) {
  const auto n = std::size_t(c.count);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j < k; ++j) b[k] = b[k] - c.lower[k][j] * b[j];
  }
  for (std::size_t k = n; k-- > 0;) {
    b[k] = b[k] / c.pivot[k];
    for (std::size_t j = k + 1; j < n; ++j) b[k] = b[k] - c.lower[j][k] * b[j];
  }
  return b;
}

/// Upper bound, but for the rounding of value(), on Q at the critical point of the face through `p`
/// whose free axes are those of the peak `c`; nothing where that point certainly lies outside the
/// face. For p in the face and r the critical point, Q(r) <= Q(p) + grad Q(p) . (r - p), as Q is
/// concave there.
std::optional<double> peak_value(const Quadric& q, const Box& box, const Curvature& c, Vec3d p) {
  const auto n = std::size_t(c.count);
  Axes<Interval> b;
  for (std::size_t k = 0; k < n; ++k) b[k] = slope(q, c.axis[k], exactly(p));
  const Axes<Interval> step = solve(c, b);
  Axes<Interval> place;
  for (std::size_t k = 0; k < n; ++k) {
    const int i = c.axis[k];
    const Interval at = Interval(p[i]) + step[k];
    if (at.hi < box.lo[i] || at.lo > box.hi[i]) return std::nullopt;
    // Written so that the whole edge is taken where the solution overflowed to NaN.
    place[k] = {at.lo > box.lo[i] ? at.lo : box.lo[i], at.hi < box.hi[i] ? at.hi : box.hi[i]};
    p[i] = 0.5 * place[k].lo + 0.5 * place[k].hi;
  }
  Interval bound = value(q, p);
  for (std::size_t k = 0; k < n; ++k) {
    bound = bound + slope(q, c.axis[k], exactly(p)) * (place[k] - Interval(p[c.axis[k]]));
  }
  return bound.hi;
}

/// Upper bound on the maximum over the box, but for the rounding of value().
double greatest(const Quadric& q, const Box& box) {
  const Vec3d centre = box.centre(), half = max(box.hi - centre, centre - box.lo);
  double best = -kInfinity, slack = 0;
  for (unsigned side = 0; side < 8; ++side) best = std::max(best, value(q, corner(box, side)));
  for (unsigned free = 1; free < 8; ++free) {
    const Curvature c = curvature(q, half, free);
    if (free == 7) {
      best += slack + c.slack;  // the faces' slack, then that of the inside
    } else {
      slack = std::max(slack, c.slack);
    }
    if (!c.peak) continue;
    for (unsigned side = 0; side < 8; ++side) {
      if (side & free) continue;
      Vec3d p = corner(box, side);
      for (int i = 0; i < 3; ++i) {
        if (free >> i & 1) p[i] = centre[i];
      }
      if (const auto peak = peak_value(q, box, c, p)) best = std::max(best, *peak);
    }
  }
  return best;
}

/// The same without mixed terms, where the maxima of the axes add up.
double greatest_separable(const Quadric& q, const Box& box) {
  double sum = q.constant;
  for (int i = 0; i < 3; ++i) {
    const double s = q.square[i], l = q.linear[i];
    double best = std::max((s * box.lo[i] + l) * box.lo[i], (s * box.hi[i] + l) * box.hi[i]);
    if (s < 0) {
      const double vertex = l / (-2 * s);
      const bool inside =
          round_up(round_up(vertex)) >= box.lo[i] && round_down(round_down(vertex)) <= box.hi[i];
      if (inside) best = std::max(best, 0.5 * l * vertex);
    }
    sum += best;
  }
  return sum;
}

/// A quadric whose coefficients are only known to lie in intervals.
struct IntervalQuadric {
  Axes<Interval> square, mixed, linear;
  Interval constant;
};

/// sup over x_j: Q - b^2 / (4 square_j), b the coefficient of x_j, where Q is concave in x_j or
/// does not depend on it; nothing where the supremum may be infinite.
std::optional<IntervalQuadric> maximize(IntervalQuadric q, std::size_t j) {
  const std::size_t i = (j + 1) % 3, k = (j + 2) % 3;
  const Interval s = q.square[j], bi = q.mixed[k], bk = q.mixed[i], b0 = q.linear[j];
  if (is_zero(s) && is_zero(bi) && is_zero(bk) && is_zero(b0)) return q;
  if (!(s.hi < 0)) return std::nullopt;
  const Interval f = Interval(-0.25) / s;  // > 0
  if (!is_zero(bi)) q.square[i] = q.square[i] + f * square(bi);
  if (!is_zero(bk)) q.square[k] = q.square[k] + f * square(bk);
  if (!is_zero(bi) && !is_zero(bk)) q.mixed[j] = q.mixed[j] + Interval(2) * f * bi * bk;
  if (!is_zero(bi) && !is_zero(b0)) q.linear[i] = q.linear[i] + Interval(2) * f * bi * b0;
  if (!is_zero(bk) && !is_zero(b0)) q.linear[k] = q.linear[k] + Interval(2) * f * bk * b0;
  if (!is_zero(b0)) q.constant = q.constant + f * square(b0);
  q.square[j] = q.mixed[i] = q.mixed[k] = q.linear[j] = 0;
  return q;
}

/// All x with a x^2 + b x + c >= 0 for some coefficients in the intervals; lo > hi if there is
/// none.
Interval solutions(Interval a, Interval b, Interval c) {
  constexpr Interval kNone{kInfinity, -kInfinity}, kWhole{-kInfinity, kInfinity};
  if (a.hi < 0) {
    const Interval discriminant = square(b) - Interval(4) * a * c;
    if (discriminant.hi < 0) return kNone;
    const Interval root = sqrt(discriminant), twice = Interval(-2) * a;
    return {((b - root) / twice).lo, ((b + root) / twice).hi};
  }
  if (!is_zero(a)) return kWhole;
  if (b.lo > 0) return {(-c / b).lo, kInfinity};
  if (b.hi < 0) return {-kInfinity, (-c / b).hi};
  return is_zero(b) && c.hi < 0 ? kNone : kWhole;
}

/// Adds k (a . x + alpha) (b . x + beta).
void add_product(Quadric& q, double k, Vec3d a, double alpha, Vec3d b, double beta) {
  q.square += a * b * k;
  q.mixed += Vec3d{a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x} * k;
  q.linear += (a * beta + b * alpha) * k;
  q.constant += alpha * beta * k;
}

}  // namespace

double rounding_error(const Quadric& q, const Box& box) {
  const auto magnitude = [](Vec3d v) { return max(v, -v); };
  const Quadric positive{magnitude(q.square), magnitude(q.mixed), magnitude(q.linear),
                         std::abs(q.constant)};
  return value(positive, max(magnitude(box.lo), magnitude(box.hi))) * kValueError + kDenormalError;
}

Interval range(const Quadric& q, const Box& box) {
  // Once for the candidates, once for the values that are compared with the result.
  const double error = 2 * rounding_error(q, box);
  const auto bound = q.mixed == Vec3d{} ? greatest_separable : greatest;
  return {round_down(-bound(-q, box) - error), round_up(bound(q, box) + error)};
}

Box bounds(const Quadric& q, double level) {
  const IntervalQuadric shifted{{q.square.x, q.square.y, q.square.z},
                                {q.mixed.x, q.mixed.y, q.mixed.z},
                                {q.linear.x, q.linear.y, q.linear.z},
                                Interval(q.constant) - Interval(level)};
  Box box{Vec3d(-kInfinity), Vec3d(kInfinity)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto profile = maximize(shifted, (axis + 1) % 3);
    if (profile) profile = maximize(*profile, (axis + 2) % 3);
    if (!profile) continue;
    const Interval x = solutions(profile->square[axis], profile->linear[axis], profile->constant);
    if (x.lo > x.hi) return {};
    box.lo[int(axis)] = x.lo;
    box.hi[int(axis)] = x.hi;
  }
  return box;
}

Quadric ellipsoid(Vec3d centre, Vec3d radii, const Affine& rotation) {
  return transform(translation(centre) * rotation * scaling(radii), unit_ball());
}

Quadric half_space(Vec3d point, Vec3d inward) {
  const Vec3d n = normalize(inward);
  Quadric q;
  q.linear = n;
  q.constant = -dot(n, point);
  return q;
}

Quadric transform(const Affine& map, const Quadric& q) {
  const Affine back = inverse(map);
  const auto& u = back.m;
  const Vec3d t = back.t;
  Quadric r;
  r.constant = q.constant;
  add_product(r, q.square.x, u[0], t.x, u[0], t.x);
  add_product(r, q.square.y, u[1], t.y, u[1], t.y);
  add_product(r, q.square.z, u[2], t.z, u[2], t.z);
  add_product(r, q.mixed.x, u[1], t.y, u[2], t.z);
  add_product(r, q.mixed.y, u[2], t.z, u[0], t.x);
  add_product(r, q.mixed.z, u[0], t.x, u[1], t.y);
  r.linear += u[0] * q.linear.x + u[1] * q.linear.y + u[2] * q.linear.z;
  r.constant += dot(q.linear, t);
  return r;
}

}  // namespace pvol
