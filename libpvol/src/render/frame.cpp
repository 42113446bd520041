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

/// Where the camera looks that frames clouds.
Vec3d view_of(const Camera& c, Vec3d above) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kRise = 0.12;  // of the camera above the cloud, over its distance
  Vec3d level = level_view(above);
  if (c.azimuth != 0) {
    const double turn = c.azimuth * kDegree;
    level = level * std::cos(turn) + cross(above, level) * std::sin(turn);
  }
  if (!c.elevation) return normalize(level - above * kRise);
  const double rise = *c.elevation * kDegree;
  return level * std::cos(rise) - above * std::sin(rise);
}

/// Makes clouds larger in the picture, and the picture of what lies around them smaller.
void zoom(Camera& c) {
  if (c.zoom == 1) return;
  c.ortho_scale /= c.zoom;
  if (c.focal_length) *c.focal_length *= c.zoom;
  const double half = std::tan(c.fov / 360 * std::numbers::pi) / c.zoom;
  c.fov = std::atan(half) * 360 / std::numbers::pi;
}

/// Largest extent of a box along the image's axes, in heights of the image.
double extent_in_view(Vec3d half, Vec3d right, Vec3d up, double aspect) {
  const auto extent = [&](Vec3d axis) {
    return std::abs(axis.x) * half.x + std::abs(axis.y) * half.y + std::abs(axis.z) * half.z;
  };
  return std::max(extent(up), extent(right) / aspect);
}

}  // namespace

Camera frame(const Box& world_box, double aspect, const Camera& like) {
  Camera c = like;
  c.position = Camera{}.position, c.target = Camera{}.target;
  if (world_box.empty()) return c;
  constexpr double kMargin = 1.08;
  constexpr double kLeastSine = 1e-3;  // of the angle between up and the view
  const Vec3d above = normalize(c.up), forward = view_of(c, above);
  if (length(cross(forward, above)) < kLeastSine) {  // up is away, or for a view from below towards
    Camera level = c;
    level.elevation = 0;
    c.up = view_of(level, above) * (dot(forward, above) < 0 ? 1.0 : -1.0);
  }
  const Vec3d right = normalize(cross(forward, normalize(c.up))), up = cross(right, forward);
  const Vec3d half = world_box.extent() * 0.5;
  double distance = 0;
  if (c.kind == CameraKind::orthographic) {
    c.ortho_scale *= kMargin * extent_in_view(half, right, up, aspect) / half_height(c, aspect);
    distance = kMargin * length(half);
  } else {
    const double half_image = half_height(c, aspect) / kMargin;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p = half * Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const double needed = std::max(std::abs(dot(p, up)), std::abs(dot(p, right)) / aspect);
      distance = std::max(distance, needed / half_image - dot(p, forward));
    }
  }
  c.target = world_box.centre();
  c.position = c.target - forward * distance;
  zoom(c);
  c.azimuth = 0, c.elevation.reset(), c.zoom = 1;  // done
  return c;
}

}  // namespace pvol
