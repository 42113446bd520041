// The camera that shows all of a box.
#include <cmath>
#include <numbers>

#include "pvol/render/render.h"

namespace pvol {

namespace {

/// Where a level camera looks, in the plane across `up`.
Vec3d level_view(Vec3d up) {
  const auto across = [&](Vec3d v) { return v - up * dot(v, up); };
  const Vec3d away = across({0, 0, -1});
  return normalize(length(away) > 0.1 ? away : across({0, 1, 0}));
}

}  // namespace

Camera frame(const Box& world_box, double aspect, const Camera& like) {
  Camera c;
  c.up = like.up;
  c.fov = like.fov;
  c.shutter = like.shutter;
  c.fps = like.fps;
  if (world_box.empty()) return c;
  constexpr double kElevation = 0.12;  // of the camera above the cloud, over its distance
  constexpr double kMargin = 1.08;
  const Vec3d above = normalize(c.up);
  const Vec3d forward = normalize(level_view(above) - above * kElevation);
  const Vec3d right = normalize(cross(forward, above)), up = cross(right, forward);
  const double half_height = std::tan(c.fov / 360 * std::numbers::pi) / kMargin;
  double distance = 0;
  const Vec3d half = world_box.extent() * 0.5;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = half * Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const double needed = std::max(std::abs(dot(p, up)), std::abs(dot(p, right)) / aspect);
    distance = std::max(distance, needed / half_height - dot(p, forward));
  }
  c.target = world_box.centre();
  c.position = c.target - forward * distance;
  return c;
}

}  // namespace pvol
