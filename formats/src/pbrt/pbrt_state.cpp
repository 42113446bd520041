#include "pbrt/pbrt_state.h"

#include <cmath>
#include <numbers>

namespace pvol::formats::detail {

Affine look_at(Vec3d eye, Vec3d target, Vec3d up) {
  const Vec3d z = normalize(target - eye);
  const Vec3d x = normalize(cross(normalize(up), z));
  Affine from_world;
  from_world.m = {x, cross(z, x), z};
  from_world.t = -from_world.vector(eye);
  return from_world;
}

Affine rotation(double degrees, Vec3d axis) {
  const Vec3d a = normalize(axis);
  const double angle = degrees * (std::numbers::pi / 180);
  const double c = std::cos(angle), s = std::sin(angle);
  Affine r;
  r.m = {Vec3d{c, -a.z * s, a.y * s} + a * (a.x * (1 - c)),
         Vec3d{a.z * s, c, -a.x * s} + a * (a.y * (1 - c)),
         Vec3d{-a.y * s, a.x * s, c} + a * (a.z * (1 - c))};
  return r;
}

std::optional<Affine> affine_of(const std::vector<double>& n) {
  const double w = n[15];
  if (n[3] != 0 || n[7] != 0 || n[11] != 0 || w == 0) return std::nullopt;
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    map.m[row] = Vec3d{n[row], n[4 + row], n[8 + row]} / w;
    map.t[int(row)] = n[12 + row] / w;
  }
  return map;
}

}  // namespace pvol::formats::detail
