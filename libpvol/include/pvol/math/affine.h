// Affine maps between frames: index space to world, instance to world.
#pragma once

#include <array>

#include "pvol/math/vec.h"

namespace pvol {

/// x -> m x + t, in double. Rows of `m` first.
struct Affine {
  std::array<Vec3d, 3> m{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  Vec3d t;

  [[nodiscard]] Vec3d vector(Vec3d v) const { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }
  [[nodiscard]] Vec3d point(Vec3d p) const { return vector(p) + t; }
  friend bool operator==(const Affine&, const Affine&) = default;
};

[[nodiscard]] inline Affine translation(Vec3d t) {
  Affine a;
  a.t = t;
  return a;
}

[[nodiscard]] inline Affine scaling(Vec3d s) {
  Affine a;
  a.m = {Vec3d{s.x, 0, 0}, Vec3d{0, s.y, 0}, Vec3d{0, 0, s.z}};
  return a;
}

/// The map that applies `b` first, then `a`.
[[nodiscard]] inline Affine operator*(const Affine& a, const Affine& b) {
  Affine c;
  const Vec3d col[3] = {{b.m[0].x, b.m[1].x, b.m[2].x},
                        {b.m[0].y, b.m[1].y, b.m[2].y},
                        {b.m[0].z, b.m[1].z, b.m[2].z}};
  for (int r = 0; r < 3; ++r) {
    const Vec3d row = a.m[std::size_t(r)];
    c.m[std::size_t(r)] = {dot(row, col[0]), dot(row, col[1]), dot(row, col[2])};
  }
  c.t = a.point(b.t);
  return c;
}

/// Determinant of the linear part: the factor on volumes, negative for a mirrored frame.
[[nodiscard]] inline double determinant(const Affine& a) {
  return dot(a.m[0], cross(a.m[1], a.m[2]));
}

/// The inverse map. Its entries are not finite where the linear part is singular: callers that take
/// maps from files check `is_finite(inverse.m[i])` and refuse.
[[nodiscard]] inline Affine inverse(const Affine& a) {
  // Scale each row to unit size first, so that voxels of 1e-9 or 1e9 neither under- nor overflow.
  Vec3d size;
  std::array<Vec3d, 3> u;
  for (int r = 0; r < 3; ++r) {
    const Vec3d row = a.m[std::size_t(r)];
    size[r] = std::max({std::abs(row.x), std::abs(row.y), std::abs(row.z)});
    u[std::size_t(r)] = row / size[r];
  }
  const Vec3d c0 = cross(u[1], u[2]), c1 = cross(u[2], u[0]), c2 = cross(u[0], u[1]);
  const double inv_det = 1.0 / dot(u[0], c0);
  Affine r;
  r.m[0] = Vec3d{c0.x / size.x, c1.x / size.y, c2.x / size.z} * inv_det;
  r.m[1] = Vec3d{c0.y / size.x, c1.y / size.y, c2.y / size.z} * inv_det;
  r.m[2] = Vec3d{c0.z / size.x, c1.z / size.y, c2.z / size.z} * inv_det;
  r.t = -r.vector(a.t);
  return r;
}

}  // namespace pvol
