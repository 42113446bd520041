// pbrt's cameras.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "file/mesh_read.h"
#include "pbrt/pbrt_world.h"

namespace pvol::formats::detail {
namespace {

Vec3d column(const Affine& map, int i) { return {map.m[0][i], map.m[1][i], map.m[2][i]}; }

/// Directions of a camera in a world: forward, right and up in the picture, whose lengths are those
/// of a unit of the camera's space.
struct View {
  Vec3d forward, right, up;
};

View view_of(const Affine& to_world, CameraKind kind) {
  const Vec3d x = column(to_world, 0), y = column(to_world, 1), z = column(to_world, 2);
  // Longitude of pbrt's pictures begins at +x and turns to +z: in their middle is -x, right of it
  // -z.
  if (kind == CameraKind::latlong) return {-x, -z, y};
  return {z, x, y};
}

/// pvol's pictures have on their right what cross(forward, up) points to. Where pbrt's do not, the
/// world is mirrored along the axis that is farthest from up, +z first.
Affine unmirrored(const View& view) {
  if (dot(cross(view.forward, view.up), view.right) > 0) return {};
  const Vec3d up = normalize(view.up);
  return scaling(std::abs(up.z) > 0.9 ? Vec3d{1, -1, 1} : Vec3d{1, 1, -1});
}

/// The picture on a plane at distance 1, or of an orthographic camera in the world: its middle and
/// its size.
struct Window {
  double x = 0, y = 0, width = 0, height = 0;
};

Window window_of(const PbrtThing& camera, const PbrtMaking& making, double aspect) {
  const double frame = camera.parameters.number("frameaspectratio", aspect);
  if (!(frame > 0)) fail_at(camera.where, fmt::format("frameaspectratio {}", frame), "above 0");
  std::array<double, 4> w{-1, 1, -1, 1};
  if (frame > 1)
    w = {-frame, frame, -1, 1};
  else
    w = {-1, 1, -1 / frame, 1 / frame};
  const std::vector<double> given = camera.parameters.numbers("screenwindow");
  if (!given.empty()) {
    if (given.size() != 4 || !(given[0] < given[1] && given[2] < given[3])) {
      fail_at(camera.where, "a screenwindow", "four numbers: left, right, bottom and top");
    }
    std::ranges::copy(given, w.begin());
  }
  const Window window{(w[0] + w[1]) / 2, (w[2] + w[3]) / 2, w[1] - w[0], w[3] - w[2]};
  if (std::abs(window.width / window.height / aspect - 1) > 1e-3 && camera.type == "spherical") {
    making.note(camera.where, "screenwindow of a spherical camera is left out");
  }
  return window;
}

double degrees_of(double height) { return 2 * std::atan(height / 2) * (180 / std::numbers::pi); }

void set_lens(const PbrtThing& camera, const PbrtMaking& making, double unit, double aspect) {
  Camera& c = making.scene->file.scene.camera;
  const double radius = camera.parameters.number("lensradius", 0) * unit;
  const double focus = camera.parameters.number("focaldistance", 1e6) * unit;
  if (!(radius > 0)) return;
  if (c.kind != CameraKind::perspective) {
    making.note(camera.where, "lensradius is left out: the camera is not perspective");
    return;
  }
  c.f_stop = 1;
  c.f_stop = lens_radius(c, aspect) / radius;
  c.focus_distance = focus;
}

CameraKind kind_of(const PbrtThing& camera, const PbrtMaking& making) {
  if (camera.type == "perspective") return CameraKind::perspective;
  if (camera.type == "orthographic") return CameraKind::orthographic;
  if (camera.type == "spherical") {
    if (camera.parameters.word("mapping", "equalarea") != "equirectangular") {
      making.note(camera.where,
                  "the camera's equal-area mapping becomes longitude and latitude: the same "
                  "surroundings, projected differently");
    }
    return CameraKind::latlong;
  }
  making.note(camera.where,
              fmt::format("the camera \"{}\" becomes a perspective camera of 90 degrees",
                          shown(camera.type)));
  return CameraKind::perspective;
}

/// Field of view, or size, and shift of a camera with a flat picture.
void set_window(const PbrtThing& camera, const PbrtMaking& making, const View& view,
                double aspect) {
  Camera& c = making.scene->file.scene.camera;
  Window w = window_of(camera, making, aspect);
  if (c.kind == CameraKind::latlong) return;
  const double x = length(view.right), y = length(view.up), z = length(view.forward);
  double scale = 1;
  if (c.kind == CameraKind::perspective) {
    const double fov = camera.parameters.number("fov", 90);
    if (!(fov > 0 && fov < 180)) fail_at(camera.where, fmt::format("fov {}", fov), "0 to 180");
    scale = std::tan(fov / 360 * std::numbers::pi) / z;
  }
  w = {w.x * scale * x, w.y * scale * y, w.width * scale * x, w.height * scale * y};
  if (std::abs(w.width / w.height / aspect - 1) > 1e-6) {
    making.note(camera.where, "pixels become square: the picture's height is kept");
  }
  const double longer = w.height * std::max(aspect, 1.0);
  c.fov = degrees_of(w.height);
  if (c.kind == CameraKind::orthographic) c.ortho_scale = longer;
  c.shift = {w.x / longer, w.y / longer};
  set_lens(camera, making, z, aspect);
}

}  // namespace

void make_camera(const PbrtDescription& from, PbrtMaking& making) {
  static const PbrtPlaced usual{{"perspective", {}, {}}, {}};
  const PbrtPlaced& camera = from.camera ? *from.camera : usual;
  SceneFile& file = making.scene->file;
  Camera& c = file.scene.camera;
  file.has_camera = true;
  c.kind = kind_of(camera, making);
  View view = view_of(camera.place, c.kind);
  making.world = unmirrored(view);
  if (!(making.world == Affine{})) {
    making.note(camera.where,
                fmt::format("pbrt's coordinates are left-handed: its ({}) is the "
                            "scene's ({})",
                            "x, y, z", making.world.m[1].y < 0 ? "x, -y, z" : "x, y, -z"));
  }
  for (Vec3d* v : {&view.forward, &view.right, &view.up}) *v = making.world.vector(*v);
  const Vec3d f = normalize(view.forward), u = normalize(view.up), r = normalize(view.right);
  if (std::abs(dot(f, u)) + std::abs(dot(f, r)) + std::abs(dot(u, r)) > 1e-6) {
    making.note(camera.where, "the shear of the camera's transform is left out");
  }
  c.position = making.world.point(camera.place.t);
  c.target = c.position + f;
  c.up = u;
  set_window(camera, making, view, double(file.scene.options.width) / file.scene.options.height);
  const PbrtParameters& p = camera.parameters;
  (void)p.number("shutteropen", 0), (void)p.number("shutterclose", 1);  // nothing moves
  p.note_unused(*making.notes, "camera");
  if (!from.camera_medium.empty()) {
    making.note(camera.where, fmt::format("the camera's unbounded medium \"{}\" is left out",
                                          shown(from.camera_medium)));
  }
}

}  // namespace pvol::formats::detail
