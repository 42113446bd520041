// UsdLux's lights but the domes. They shine along their -z.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "usda/usda_light.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadians = kPi / 180;

/// A light while it is made.
struct UsdLamp {
  const UsdItem& item;
  const UsdView view;
  const UsdMaking& making;

  void note(const std::string& text) const { making.note(view.where(), text); }
  [[nodiscard]] Vec3d axis(Vec3d v) const { return item.place.now.vector(v); }
  void add(const Light& light) const {
    check_made(view.where(), light);
    making.scene->file.scene.lights.push_back(light);
  }
};

/// Its irradiance is its radiance times its disc's projected solid angle, pi sin^2 of half its
/// angle; that of a parallel light, which has no disc, is its intensity.
void add_distant(const UsdLamp& lamp) {
  constexpr double kSmallest = 0.01, kLargest = 179.99;  // of discs that pvol has
  const double given = input(lamp.view, "angle", 0.53);
  const double angle = std::clamp(given, 0.0, kLargest);
  if (angle != given) {
    lamp.note(fmt::format("an angle of {} degrees is taken as {}", given, angle));
  }
  const double sine = std::sin(angle / 2 * kRadians);
  const double size = angle > 0 ? kPi * sine * sine : 1;
  Sun sun;
  sun.direction = normalize(lamp.axis({0, 0, 1}));
  sun.irradiance = Rgb(Vec3d(emission_of(lamp.view, size, lamp.making.space())) * size);
  sun.angle = angle < kSmallest ? 0 : angle;
  lamp.add(sun);
}

bool has_schema(const UsdPrim& prim, const std::string& name) {
  const std::vector<std::string> names = items_of(prim.schemas);
  return std::ranges::find(names, name) != names.end();
}

/// Half the angle of a cone of light; nothing of a light that shines as far as it can.
std::optional<double> cone_of(const UsdLamp& lamp, double farthest) {
  const bool shaped = lamp.view.says(input_of(lamp.view, "shaping:cone:angle")) ||
                      has_schema(lamp.view.prim(), "ShapingAPI");
  const double angle = input(lamp.view, "shaping:cone:angle", 90);
  if (!shaped || angle >= farthest) return std::nullopt;
  if (angle > 0) return angle;
  fail_at(lamp.view.where(), fmt::format("a cone of {} degrees", angle), "an angle above 0");
}

/// `intensity` along its axis.
void add_spot(const UsdLamp& lamp, double cone, Rgb intensity) {
  SpotLight spot;
  spot.position = lamp.item.place.now.t;
  spot.direction = normalize(lamp.axis({0, 0, -1}));
  spot.angle = std::max(2 * cone, 0.01);
  spot.blend = std::clamp(input(lamp.view, "shaping:cone:softness", 0), 0.0, 1.0);
  spot.intensity = intensity;
  lamp.note(fmt::format("the cone of a {} becomes a spot without size", lamp.view.prim().type));
  lamp.add(spot);
}

/// A ball of radius r and radiance L is an irradiance of pi r^2 L at distance 1 from its middle.
void add_sphere(const UsdLamp& lamp) {
  const double own = input(lamp.view, "radius", 0.5);
  const std::optional<double> scale = uniform_scale(lamp.item.place.now);
  const double mean = std::cbrt(std::abs(determinant(lamp.item.place.now)));
  if (!scale) lamp.note("a stretched SphereLight becomes a ball of the same volume");
  const double r = own * scale.value_or(mean);
  if (!(own >= 0)) fail_at(lamp.view.where(), fmt::format("a radius of {}", own), "0 or more");
  const bool normalised = input(lamp.view, "normalize", 0) != 0;
  const Vec3d radiance(emission_of(lamp.view, 4 * kPi * r * r, lamp.making.space()));
  // Of a point of a given power, which is pi L times the area of a ball, whatever its size.
  const Rgb intensity(r > 0 ? radiance * (kPi * r * r) : radiance * (normalised ? 0.25 : 0));
  if (r == 0 && !normalised) {
    lamp.note("a SphereLight of radius 0 shines only with inputs:normalize, and is left out");
    return;
  }
  const bool is_point = lamp.view.flag("treatAsPoint", false);
  if (const auto cone = cone_of(lamp, 180)) return add_spot(lamp, *cone, intensity);
  PointLight light;
  light.position = lamp.item.place.now.t;
  light.intensity = intensity;
  light.radius = is_point ? 0 : r;
  lamp.add(light);
}

/// A rectangle in the plane of x and y, of a width and height in the light's space.
void add_flat(const UsdLamp& lamp, double width, double height) {
  const Vec3d x = lamp.axis({1, 0, 0}), y = lamp.axis({0, 1, 0}), back = lamp.axis({0, 0, 1});
  const Vec3d normal = cross(x, y);
  if (std::abs(dot(x, y)) > 1e-6 * length(x) * length(y)) {
    lamp.note("a sheared light becomes a rectangle of the same sides");
  }
  AreaLight area;
  area.position = lamp.item.place.now.t;
  area.direction = normalize(dot(normal, back) > 0 ? -normal : normal);
  area.up = normalize(y);
  area.size = {width * length(x), height * length(y)};
  const double surface = area.size[0] * area.size[1];
  area.radiance = emission_of(lamp.view, surface, lamp.making.space());
  if (const auto cone = cone_of(lamp, 90)) {
    return add_spot(lamp, *cone, Rgb(Vec3d(area.radiance) * surface));
  }
  lamp.add(area);
}

void add_rect(const UsdLamp& lamp) {
  add_flat(lamp, input(lamp.view, "width", 1), input(lamp.view, "height", 1));
}

void add_disk(const UsdLamp& lamp) {
  const double side = input(lamp.view, "radius", 0.5) * std::sqrt(kPi);
  lamp.note("a DiskLight becomes a square of the same area");
  add_flat(lamp, side, side);
}

/// To add a kind of light: its row.
struct UsdLightKind {
  std::string_view type;
  void (*add)(const UsdLamp&);
};
constexpr std::array<UsdLightKind, 4> kUsdLights{{{"DistantLight", add_distant},
                                                  {"SphereLight", add_sphere},
                                                  {"RectLight", add_rect},
                                                  {"DiskLight", add_disk}}};

bool is_dome(const UsdItem& item) { return item.prim->type.starts_with("DomeLight"); }

void make_lamp(const UsdItem& item, const UsdMaking& making) {
  const auto* kind = std::ranges::find(kUsdLights, item.prim->type, &UsdLightKind::type);
  if (kind == kUsdLights.end()) {
    making.note(item.prim->where,
                fmt::format("lights of type {} are left out", usd_shown(item.prim->type)));
    return;
  }
  const UsdLamp lamp{item, making.stage.view(*item.prim), making};
  kind->add(lamp);
  if (item.place.moves()) lamp.note("the motion of lights is left out");
  ignore_usual(lamp.view);
  lamp.view.note_unused(*making.notes);
}

}  // namespace

void make_lights(const UsdMaking& making) {
  Scene& scene = making.scene->file.scene;
  const std::vector<UsdItem>& all = making.stage.lights;
  if (all.empty()) {
    const SceneFile usual =
        default_scene("none.vdb", {making.stage.z_up ? "world.up=\"z\"" : "world.up=\"y\""});
    scene.environment = usual.scene.environment, scene.lights = usual.scene.lights;
    making.note(making.stage.root.where, "has no lights: pvol's usual sun and sky are taken");
    return;
  }
  std::vector<UsdItem> domes;
  for (const UsdItem& item : all) {
    if (is_dome(item)) {
      domes.push_back(item);
    } else {
      make_lamp(item, making);
    }
  }
  make_domes(domes, making);
}

}  // namespace pvol::formats::detail
