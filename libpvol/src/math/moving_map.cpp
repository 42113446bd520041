#include "pvol/math/moving_map.h"

#include <algorithm>
#include <cmath>

namespace pvol {
namespace {

[[nodiscard]] Affine linear_at(const MovingMap& m, double t) {
  Affine a = m.linear;
  for (std::size_t r = 0; r < 3; ++r) a.m[r] += m.linear_rate[r] * t;
  return a;
}

}  // namespace

Affine rotation_about(Vec3d a, double radians) {
  const double c = std::cos(radians), s = std::sin(radians);
  Affine r;
  r.m[0] = Vec3d{c, -s * a.z, s * a.y} + a * (a.x * (1 - c));
  r.m[1] = Vec3d{s * a.z, c, -s * a.x} + a * (a.y * (1 - c));
  r.m[2] = Vec3d{-s * a.y, s * a.x, c} + a * (a.z * (1 - c));
  return r;
}

Affine MovingMap::at(double t) const {
  Affine a = linear_at(*this, t);
  for (const MovingTurn& turn : turns) {
    a = rotation_about(turn.axis, turn.angle + t * turn.rate) * a;
  }
  a.t = shift + shift_rate * t;
  return a;
}

Vec3d MovingMap::velocity(Vec3d p, double t) const {
  constexpr double kStep = 1.0 / 1024;
  return (at(t + kStep).point(p) - at(t - kStep).point(p)) / (2 * kStep);
}

bool MovingMap::moves() const {
  return shift_rate != Vec3d{} || linear_rate != std::array<Vec3d, 3>{} ||
         std::ranges::any_of(turns, [](const MovingTurn& turn) { return turn.rate != 0; });
}

bool stays_regular(const MovingMap& map, double t0, double t1) {
  constexpr double kLeast = 1e-9;  // of the largest
  // The determinant is a cubic of time, u = 0..1: by its values at four of them.
  double d[4];
  for (int i = 0; i < 4; ++i) d[i] = determinant(linear_at(map, t0 + (t1 - t0) * i / 3));
  const double c0 = d[0], c1 = (-11 * d[0] + 18 * d[1] - 9 * d[2] + 2 * d[3]) / 2,
               c2 = 9 * (2 * d[0] - 5 * d[1] + 4 * d[2] - d[3]) / 2,
               c3 = 9 * (-d[0] + 3 * d[1] - 3 * d[2] + d[3]) / 2;
  const auto value = [&](double u) { return ((c3 * u + c2) * u + c1) * u + c0; };
  double least = std::min(d[0], d[3]), most = std::max(d[0], d[3]);
  const auto visit = [&](double u) {
    if (!(u > 0 && u < 1)) return;
    least = std::min(least, value(u)), most = std::max(most, value(u));
  };
  // Its slope is 0 at the roots of 3 c3 u^2 + 2 c2 u + c1, without cancellation.
  const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * c1));
  const double q = -(c2 + std::copysign(root, c2));
  visit(q / (3 * c3));
  visit(c1 / q);
  const double far = std::max(std::abs(least), std::abs(most));
  return std::isfinite(far) && least * most > 0 &&
         std::min(std::abs(least), std::abs(most)) > kLeast * far;
}

}  // namespace pvol
