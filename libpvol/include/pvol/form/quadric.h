// Quadrics: polynomials of degree two in three variables, their exact range over a box, and the
// bodies {Q >= 0} that they bound.
#pragma once

#include <array>

#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/math/interval.h"

namespace pvol {

/// Q(p) = square . (x^2, y^2, z^2) + mixed . (yz, zx, xy) + linear . (x, y, z) + constant.
/// Inside is Q >= 0. Coefficients are finite, and so are the values they are used for.
struct Quadric {
  Vec3d square, mixed, linear;
  double constant = 0;
  friend bool operator==(const Quadric&, const Quadric&) = default;
};

[[nodiscard]] inline Quadric operator*(double k, const Quadric& q) {
  return {k * q.square, k * q.mixed, k * q.linear, k * q.constant};
}
[[nodiscard]] inline Quadric operator-(const Quadric& q) { return -1.0 * q; }

/// The ten coefficients, those of x^2, y^2, z^2, yz, zx, xy, x, y, z and 1, and back.
using QuadricTerms = std::array<double, 10>;
[[nodiscard]] inline QuadricTerms terms(const Quadric& q) {
  return {q.square.x, q.square.y, q.square.z, q.mixed.x,  q.mixed.y,
          q.mixed.z,  q.linear.x, q.linear.y, q.linear.z, q.constant};
}
[[nodiscard]] inline Quadric quadric(const QuadricTerms& c) {
  return {{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]};
}

/// Q(p) in double.
[[nodiscard]] inline double value(const Quadric& q, Vec3d p) {
  return p.x * (q.square.x * p.x + q.mixed.z * p.y + q.mixed.y * p.z + q.linear.x) +
         p.y * (q.square.y * p.y + q.mixed.x * p.z + q.linear.y) +
         p.z * (q.square.z * p.z + q.linear.z) + q.constant;
}

/// (dQ/dx, dQ/dy, dQ/dz).
[[nodiscard]] inline Vec3d gradient(const Quadric& q, Vec3d p) {
  return {2 * q.square.x * p.x + q.mixed.z * p.y + q.mixed.y * p.z + q.linear.x,
          2 * q.square.y * p.y + q.mixed.z * p.x + q.mixed.x * p.z + q.linear.y,
          2 * q.square.z * p.z + q.mixed.y * p.x + q.mixed.x * p.y + q.linear.z};
}

/// Bound on |computed - exact| of value(q, p) for p in the box: each of the ten terms is rounded at
/// most eight times.
[[nodiscard]] double rounding_error(const Quadric& q, const Box& box);

/// Holds Q(p), exact and as value() computes it, for every p of the finite box that is not empty.
///
/// Closed form: the extremes of a quadratic over a box lie at one of 27 places, the eight corners
/// or the critical points inside the twelve edges, the six faces and the box. Beyond rounding_error
/// the bounds are attained but for a few ulp of the largest term.
[[nodiscard]] Interval range(const Quadric& q, const Box& box);

/// A box that holds {Q >= level}: tight where the set is an ellipsoid, cylinder, slab or
/// half-space; infinite on the axes along which the set is not bounded (or not seen to be).
[[nodiscard]] Box bounds(const Quadric& q, double level = 0);

/// 1 - |p|^2.
[[nodiscard]] inline Quadric unit_ball() { return {Vec3d(-1), {}, {}, 1}; }

/// 1 at the centre, 0 on the ellipsoid with half-axes radii (> 0) along the columns of the
/// rotation.
[[nodiscard]] Quadric ellipsoid(Vec3d centre, Vec3d radii, const Affine& rotation = {});

/// Distance from the plane through `point`, positive where `inward` (not zero) points.
[[nodiscard]] Quadric half_space(Vec3d point, Vec3d inward);

/// The quadric of the moved body: transform(a, q)(a(p)) = q(p). The map must be invertible.
[[nodiscard]] Quadric transform(const Affine& map, const Quadric& q);

}  // namespace pvol
