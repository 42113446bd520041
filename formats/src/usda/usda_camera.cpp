// UsdGeomCamera. It looks along its -z with y up. Focal length and apertures are in tenths of a
// unit of the scene, which is millimetres where the unit is a centimetre; the distance of what is
// sharp is in units.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pvol/render/options.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr double kUnitsOfAperture = 0.1, kMillimetresOfAperture = 1000 * kUnitsOfAperture;

/// A part of the world that a picture shows, in tenths of a unit.
struct Aperture {
  double width = 20.955, height = 15.2908, x = 0, y = 0;
};

Aperture aperture_of(const UsdView& camera) {
  const Aperture usual;
  const Aperture a{camera.number("horizontalAperture", usual.width),
                   camera.number("verticalAperture", usual.height),
                   camera.number("horizontalApertureOffset", 0),
                   camera.number("verticalApertureOffset", 0)};
  if (!(a.width > 0 && a.height > 0)) {
    fail_at(camera.where(), fmt::format("an aperture of {} x {}", a.width, a.height),
            "numbers above 0");
  }
  return a;
}

/// As usdrecord chooses it: the width is given, the height by the aperture.
std::array<int, 2> size_of_picture(const Aperture& a) {
  const int width = RenderOptions{}.width;
  return {width,
          int(std::clamp(std::round(width * a.height / a.width), 1.0, double(kLargestEdge)))};
}

/// Which side of the aperture stays as it is in a picture of another aspect.
SensorFit fit_of(const std::string& policy, bool is_wider) {
  if (policy == "adjustApertureWidth") return SensorFit::vertical;
  if (policy == "adjustApertureHeight") return SensorFit::horizontal;
  if (policy == "cropAperture") return is_wider ? SensorFit::horizontal : SensorFit::vertical;
  return is_wider ? SensorFit::vertical : SensorFit::horizontal;  // all of the aperture is seen
}

Vec3d column_of(const Affine& map, int i) { return {map.m[0][i], map.m[1][i], map.m[2][i]}; }

CameraPlace camera_at(const Affine& place) {
  CameraPlace at;
  at.position = place.t;
  at.target = at.position - normalize(column_of(place, 2));
  at.up = normalize(column_of(place, 1));
  return at;
}

bool is_plain(const Affine& place) {
  const std::optional<double> scale = uniform_scale(place);
  return scale && std::abs(*scale - 1) < 1e-6 && determinant(place) > 0;
}

void set_places(const UsdItem& item, const UsdMaking& making) {
  Camera& c = making.scene->file.scene.camera;
  const CameraPlace at = camera_at(item.place.now);
  c.position = at.position, c.target = at.target, c.up = at.up;
  if (!is_plain(item.place.now)) {
    making.note(item.prim->where,
                "the scale, mirroring or shear of the camera's transform is left out");
  }
  if (!item.place.moves()) return;
  c.to = camera_at(item.place.later);
  if (const auto fault = misfit_of_way(c)) {
    making.note(item.prim->where, "the camera's motion is left out: a half turn within a frame");
    c.to.reset();
  }
}

/// Sharpness by distance. A lens without f-stop or distance has none.
void set_lens(const UsdView& camera, const UsdMaking& making) {
  Camera& c = making.scene->file.scene.camera;
  const double f_stop = camera.number("fStop", 0), focus = camera.number("focusDistance", 0);
  if (!(f_stop > 0)) return;
  if (c.kind != CameraKind::perspective || !(focus > 0)) {
    making.note(camera.where(),
                "fStop is left out: it needs a perspective camera and a "
                "focusDistance above 0");
    return;
  }
  c.f_stop = f_stop, c.focus_distance = focus;
  if (*c.focal_length > 1000) {  // what somebody meant in millimetres, more likely
    making.note(camera.where(),
                fmt::format("the lens has a focal length of {:.6g} mm, since focalLength is in "
                            "tenths of metersPerUnit, {} m; where it is meant in mm, set "
                            "camera.f_stop={:.6g}",
                            *c.focal_length, making.stage.metres,
                            f_stop * kMillimetresOfAperture * making.stage.metres));
  }
}

void set_shutter(const UsdView& camera, const UsdMaking& making) {
  Camera& c = making.scene->file.scene.camera;
  c.fps = making.stage.fps;
  c.shutter = {camera.number("shutter:open", 0), camera.number("shutter:close", 0)};
  if (c.shutter.close < c.shutter.open) {
    fail_at(camera.where(), fmt::format("a shutter from {} to {}", c.shutter.open, c.shutter.close),
            "shutter:close after shutter:open");
  }
}

/// Field of view, or size, and shift.
void set_view(const UsdView& camera, const UsdPicture& picture, const UsdMaking& making) {
  Scene& scene = making.scene->file.scene;
  Camera& c = scene.camera;
  const Aperture a = aperture_of(camera);
  const auto [width, height] = picture.size.value_or(size_of_picture(a));
  scene.options.width = width, scene.options.height = height;
  c.fit = fit_of(picture.policy, double(width) / height > a.width / a.height);
  const double side = c.fit == SensorFit::horizontal ? a.width : a.height;
  const double millimetres = kMillimetresOfAperture * making.stage.metres;
  c.sensor = side * millimetres;
  c.shift = {a.x / side, a.y / side};
  const double focal = camera.number("focalLength", 50);
  const std::string projection = camera.word("projection", "perspective");
  if (projection == "orthographic") {
    c.kind = CameraKind::orthographic;
    c.ortho_scale = side * kUnitsOfAperture;
    return;
  }
  if (projection != "perspective") {
    making.note(camera.where(), fmt::format("the projection \"{}\" is taken as perspective",
                                            usd_shown(projection)));
  }
  if (!(focal > 0)) {
    fail_at(camera.where(), fmt::format("a focalLength of {}", focal), "a number above 0");
  }
  c.focal_length = focal * millimetres;
}

const UsdItem* chosen_camera(const UsdPicture& picture, const UsdMaking& making) {
  const std::vector<UsdItem>& all = making.stage.cameras;
  if (all.empty()) return nullptr;
  const auto found = std::ranges::find(all, picture.camera, &UsdItem::path);
  const UsdItem& camera = found == all.end() ? all.front() : *found;
  if (found == all.end() && all.size() > 1) {
    making.note(camera.prim->where, fmt::format("of {} cameras {} is taken: no RenderSettings "
                                                "choose one",
                                                all.size(), usd_shown(camera.path)));
  }
  return &camera;
}

}  // namespace

void make_camera(const UsdPicture& picture, const UsdMaking& making) {
  SceneFile& file = making.scene->file;
  Camera& c = file.scene.camera;
  c.metres = making.stage.metres;
  if (making.stage.z_up) c.up = {0, 0, 1};
  const UsdItem* item = chosen_camera(picture, making);
  if (item == nullptr) {  // pvol frames the clouds
    if (picture.size) file.scene.options.width = (*picture.size)[0];
    if (picture.size) file.scene.options.height = (*picture.size)[1];
    return;
  }
  file.has_camera = true;
  const UsdView camera = making.stage.view(*item->prim);
  set_view(camera, picture, making);
  set_places(*item, making);
  set_lens(camera, making);
  set_shutter(camera, making);
  // pvol cuts nothing off, and has one eye.
  for (const char* name : {"clippingRange", "clippingPlanes", "stereoRole"}) camera.ignore(name);
  camera.note_unused(*making.notes);
  check_made(item->prim->where, c);
}

}  // namespace pvol::formats::detail
