// Unit vectors at an angle to others.
#pragma once

#include <cmath>

#include "pvol/math/circle.h"
#include "pvol/math/vec.h"

namespace pvol {

/// 1 - cos of the angle between unit vectors, precise for small angles.
[[nodiscard]] inline float one_minus_cos(Vec3f a, Vec3f b) {
  const Vec3f d = a - b;
  return 0.5f * dot(d, d);
}

/// The unit vector at an angle with this 1 - cos, in [0, 2], from the unit vector `axis`, at the
/// azimuth of a point on the circle.
[[nodiscard]] inline Vec3f turn(Vec3f axis, float one_minus_cos, CirclePoint azimuth) {
  Vec3f s, t;
  orthonormal_basis(axis, s, t);
  const auto [cosine, side] = azimuth;
  const float sine = std::sqrt(one_minus_cos * (2 - one_minus_cos));
  const Vec3f v = s * (sine * cosine) + t * (sine * side) + axis * (1 - one_minus_cos);
  return v * (1.5f - 0.5f * dot(v, v));  // one Newton step towards unit length stops the drift
}
/// At azimuth 2 pi u.
[[nodiscard]] inline Vec3f turn(Vec3f axis, float one_minus_cos, float u) {
  return turn(axis, one_minus_cos, point_at_turns(u));
}

/// The k-th of `count` points spread evenly on the unit sphere, along a spiral.
[[nodiscard]] inline Vec3d direction_on_spiral(int k, int count) {
  const double turn = 2.399963229728653 * k, z = 1 - (2 * k + 1.0) / count;
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

}  // namespace pvol
