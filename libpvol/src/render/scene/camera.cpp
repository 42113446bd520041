#include "pvol/render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/error.h"
#include "pvol/render/placement.h"

namespace pvol {
namespace {

/// Half the sensor's side that `fit` says over half the picture's height.
double half_side_over_height(const Camera& c, double aspect) {
  if (c.fit == SensorFit::automatic) return std::max(aspect, 1.0);
  return c.fit == SensorFit::horizontal ? aspect : 1;
}

/// In mm: that of the field of view where none is given.
double focal_length(const Camera& c, double aspect) {
  if (c.focal_length) return *c.focal_length;
  return c.sensor / 2 / (half_height(c, aspect) * half_side_over_height(c, aspect));
}

struct Axes {
  Vec3d x, y, z, place;
};

/// Of a matrix with the place in its last column, or in its last row.
std::optional<Axes> axes_of(const std::array<double, 16>& m) {
  const auto at = [&](std::size_t row, std::size_t column) { return m[4 * row + column]; };
  const auto ends = [&](bool in_row) {
    for (std::size_t i = 0; i < 3; ++i) {
      if ((in_row ? at(i, 3) : at(3, i)) != 0) return false;
    }
    return at(3, 3) == 1;
  };
  const bool in_column = ends(false), in_row = !in_column && ends(true);
  if (!in_column && !in_row) return std::nullopt;
  const auto axis = [&](std::size_t i) {
    return in_column ? Vec3d(at(0, i), at(1, i), at(2, i)) : Vec3d(at(i, 0), at(i, 1), at(i, 2));
  };
  const Axes a{axis(0), axis(1), axis(2), axis(3)};
  for (const Vec3d& v : {a.x, a.y, a.z}) {
    if (!(length(v) > 0) || !is_finite(v / length(v))) return std::nullopt;
  }
  const double volume = dot(cross(normalize(a.x), normalize(a.y)), normalize(a.z));
  constexpr double kLeast = 0.99;  // printed with a few digits they are hardly orthogonal
  if (!(volume > kLeast)) return std::nullopt;
  return a;
}

CameraPlace place_of(const Camera& c) { return {c.position, c.target, c.up}; }

/// From the camera's space, with x to the right, y down and z along the view, to the world.
Affine frame_of(const CameraPlace& p) {
  const Vec3d z = normalize(p.target - p.position), x = normalize(cross(z, p.up)), y = cross(z, x);
  Affine a;
  for (int r = 0; r < 3; ++r) a.m[std::size_t(r)] = {x[r], y[r], z[r]};
  a.t = p.position;
  return a;
}

MovingPlacement way_of(const Camera& c) {
  MovingPlacement way;
  way.from.matrix = frame_of(place_of(c)), way.to.matrix = frame_of(*c.to);
  return way;
}

/// A target where the camera is, or `up` along the view.
std::optional<Misfit> misfit_of_place(const CameraPlace& p) {
  constexpr double kLeastSine = 1e-6;  // of the angle between up and the view; the cross product of
                                       // two unit vectors is accurate to about 1e-16
  const Vec3d view = p.target - p.position;
  if (view == Vec3d{}) return Misfit{{"target"}, "a point other than position"};
  const double sine = length(cross(normalize(view), normalize(p.up)));
  if (sine > kLeastSine) return std::nullopt;
  return Misfit{{"up", "target"},
                "up, by default [0, 1, 0], not along the line from position to target"};
}

}  // namespace

double half_height(const Camera& c, double aspect) {
  const double side = half_side_over_height(c, aspect);
  if (c.kind == CameraKind::orthographic) return c.ortho_scale / 2 / side;
  if (c.focal_length) return c.sensor / (2 * *c.focal_length) / side;
  return std::tan(c.fov / 360 * std::numbers::pi);
}

std::array<double, 2> shift_of(const Camera& c, double aspect) {
  const double side = 2 * half_height(c, aspect) * half_side_over_height(c, aspect);
  return {c.shift[0] * side, c.shift[1] * side};
}

double lens_radius(const Camera& c, double aspect) {
  if (!c.f_stop) return 0;
  return focal_length(c, aspect) / 1000 / c.metres / (2 * *c.f_stop);
}

std::optional<CameraPlace> camera_place(const std::array<double, 16>& matrix) {
  const std::optional<Axes> axes = axes_of(matrix);
  if (!axes) return std::nullopt;
  return CameraPlace{axes->place, axes->place - normalize(axes->z), normalize(axes->y)};
}

bool place(CameraPlace& camera, const std::array<double, 16>& matrix) {
  const auto found = camera_place(matrix);
  if (found) camera = *found;
  return found.has_value();
}

bool place(Camera& camera, const std::array<double, 16>& matrix) {
  CameraPlace p;
  if (!place(p, matrix)) return false;
  camera.position = p.position, camera.target = p.target, camera.up = p.up;
  return true;
}

std::optional<MovingMap> motion_of(const Camera& c) {
  if (!c.to || *c.to == place_of(c)) return std::nullopt;
  return way_of(c).map();
}

Camera camera_at(const Camera& c, double frames) {
  const auto motion = motion_of(c);
  Camera still = c;
  still.to.reset();
  if (!motion || frames == 0) return still;
  const Affine to_then = motion->at(frames) * inverse(frame_of(place_of(c)));
  still.position = to_then.point(c.position), still.target = to_then.point(c.target);
  still.up = to_then.vector(c.up);
  return still;
}

const char* expect_matrix(const Value& value) {
  std::array<double, 16> m{};
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = *(*value.list())[i].number();
  return camera_place(m) ? nullptr
                         : "a matrix of rotation, scale and translation that does not mirror, "
                           "with 0, 0, 0, 1 as its last row or last column";
}

const char* expect_shutter(const Value& value) {
  const Value::List& times = *value.list();
  return *times[0].number() <= *times[1].number() ? nullptr
                                                  : "an opening time before the closing time";
}

std::optional<Misfit> misfit(const Camera& c) {
  if (const auto wrong = misfit_of_place(place_of(c))) return wrong;
  if (c.kind != CameraKind::perspective && c.f_stop) {
    return Misfit{{"f_stop"}, "none, since only perspective cameras have a lens"};
  }
  if (c.kind == CameraKind::latlong && c.shift != std::array<double, 2>{0, 0}) {
    return Misfit{{"shift"}, "[0, 0], since the camera sees all directions"};
  }
  return std::nullopt;
}

std::optional<Misfit> misfit_of_way(const Camera& c) {
  if (!c.to) return std::nullopt;
  if (const auto wrong = misfit_of_place(*c.to)) return wrong;
  if (!misfit(way_of(c))) return std::nullopt;
  return Misfit{{"target", "up", "matrix"}, "a view less than half a turn from the first"};
}

void validate(const Camera& camera) {
  const auto refuse = [](const char* section, const std::optional<Misfit>& wrong) {
    if (!wrong) return;
    throw Error(std::string(section) + ": " + wrong->keys.front() + ": expected " +
                wrong->expected);
  };
  require_limits("camera", without(entries(camera), "matrix"));
  refuse("camera", misfit(camera));
  if (!camera.to) return;
  require_limits("camera.to", without(entries(*camera.to), "matrix"));
  refuse("camera.to", misfit_of_way(camera));
}

}  // namespace pvol
