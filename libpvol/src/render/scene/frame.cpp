// The camera that shows all of a box, or of what volumes hold.
#include "pvol/render/frame_volumes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "pvol/render/camera.h"
#include "pvol/volume/facts.h"
#include "render/scene/outline.h"

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

/// The camera's axes.
struct View {
  Vec3d forward, right, up;
};

/// Turns `up` where the camera looks along it, and the view.
View aim(Camera& c) {
  constexpr double kLeastSine = 1e-3;  // of the angle between up and the view
  const Vec3d above = normalize(c.up), forward = view_of(c, above);
  if (length(cross(forward, above)) < kLeastSine) {  // up is away, or for a view from below towards
    Camera level = c;
    level.elevation = 0;
    c.up = view_of(level, above) * (dot(forward, above) < 0 ? 1.0 : -1.0);
  }
  const Vec3d right = normalize(cross(forward, normalize(c.up)));
  return {forward, right, cross(right, forward)};
}

/// Sets the camera on points that are given from `centre`, with all of them in the picture.
Camera fit(Camera c, const View& view, Vec3d centre, std::span<const Vec3d> points, double aspect) {
  constexpr double kMargin = 1.08;
  double distance = 0;
  if (c.kind == CameraKind::orthographic) {
    double extent = 0, farthest = 0;
    for (const Vec3d p : points) {
      extent = std::max({extent, std::abs(dot(p, view.up)), std::abs(dot(p, view.right)) / aspect});
      farthest = std::max(farthest, length(p));
    }
    c.ortho_scale *= kMargin * extent / half_height(c, aspect);
    distance = kMargin * farthest;
  } else {
    const double half_image = half_height(c, aspect) / kMargin;
    for (const Vec3d p : points) {
      const double needed =
          std::max(std::abs(dot(p, view.up)), std::abs(dot(p, view.right)) / aspect);
      distance = std::max(distance, needed / half_image - dot(p, view.forward));
    }
  }
  c.target = centre;
  c.position = centre - view.forward * distance;
  zoom(c);
  c.azimuth = 0, c.elevation.reset(), c.zoom = 1;  // done
  return c;
}

}  // namespace

Camera frame(const Box& world_box, double aspect, const Camera& like) {
  Camera c = like;
  c.position = Camera{}.position, c.target = Camera{}.target;
  if (world_box.empty()) return c;
  const View view = aim(c);
  const Vec3d half = world_box.extent() * 0.5;
  std::array<Vec3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[std::size_t(i)] = half * Vec3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  }
  return fit(std::move(c), view, world_box.centre(), corners, aspect);
}

Camera frame_volumes(std::span<const Volume> volumes, double aspect, const Camera& like) {
  const Box box = still_world_box(volumes);
  const bool from_the_front = like.azimuth == 0 && !like.elevation;
  if (from_the_front || box.empty()) return frame(box, aspect, like);
  Camera c = like;
  const View view = aim(c);
  const std::vector<Vec3d> points = detail::outline(volumes);
  std::vector<Vec3d> from_centre(points.size());
  const auto fit_at = [&](Vec3d centre) {
    for (std::size_t i = 0; i < points.size(); ++i) from_centre[i] = points[i] - centre;
    return fit(c, view, centre, from_centre, aspect);
  };
  // What is near the camera reaches farther in the picture: moved by half of what one side has more
  // than the other, a few times, it has as much room on either.
  Vec3d centre = box.centre();
  for (int step = 0; step < 8; ++step) {
    const Camera now = fit_at(centre);
    const double distance = length(now.position - centre);
    const bool flat = c.kind == CameraKind::orthographic;
    Box seen;
    for (const Vec3d p : from_centre) {
      const double scale = flat ? 1 : distance / (distance + dot(p, view.forward));
      seen = extend(seen, {dot(p, view.right) * scale, dot(p, view.up) * scale, 0});
    }
    centre = centre + view.right * seen.centre().x + view.up * seen.centre().y;
  }
  return fit_at(centre);
}

}  // namespace pvol
