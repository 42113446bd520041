// pbrt's lights: suns, point lights and the sky. What is infinite and even makes a constant sky,
// pictures a picture.
#include <fmt/format.h>

#include <array>
#include <numbers>

#include "file/mesh_read.h"
#include "pbrt/pbrt_color.h"
#include "pbrt/pbrt_world.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"

namespace pvol::formats::detail {
namespace {

/// What the sky is made of.
struct Sky {
  Rgb radiance{0.0f};
  std::vector<PbrtSkyPicture> pictures;
};

void make_distant(const PbrtPlaced& light, const PbrtMaking& making, Sky&) {
  const Vec3d from = light.parameters.point("from", {0, 0, 0});
  const Vec3d to = light.parameters.point("to", {0, 0, 1});
  Sun sun;
  sun.irradiance = strength(light, "L", "illuminance", 1, making);
  sun.direction = making.world.vector(light.place.vector(from - to));
  if (!(length(sun.direction) > 0))
    fail_at(light.where, "a light with from equal to to", "two different points from and to");
  sun.direction = normalize(sun.direction);
  making.scene->file.scene.lights.emplace_back(sun);
}

void make_point(const PbrtPlaced& light, const PbrtMaking& making, Sky&) {
  PointLight point;
  point.intensity = strength(light, "I", "power", 4 * std::numbers::pi, making);
  const Vec3d from = light.parameters.point("from", {0, 0, 0});
  point.position = making.world.point(light.place.point(from));
  making.scene->file.scene.lights.emplace_back(point);
}

/// Both fade over the same angles by the same polynomial of the cosine.
void make_spot(const PbrtPlaced& light, const PbrtMaking& making, Sky&) {
  const PbrtParameters& p = light.parameters;
  const double cone = p.number("coneangle", 30), fade = p.number("conedeltaangle", 5);
  if (!(cone > 0 && cone <= 180 && fade >= 0 && fade <= cone)) {
    fail_at(light.where, fmt::format("a cone of {} degrees that fades over {}", cone, fade),
            "coneangle in (0, 180], and conedeltaangle from 0 to coneangle");
  }
  constexpr double kDegree = std::numbers::pi / 180;
  const double rim = std::cos(cone * kDegree), full = std::cos((cone - fade) * kDegree);
  const Vec3d from = p.point("from", {0, 0, 0}), to = p.point("to", {0, 0, 1});
  SpotLight spot;
  spot.position = making.world.point(light.place.point(from));
  spot.direction = making.world.vector(light.place.vector(to - from));
  if (!(length(spot.direction) > 0))
    fail_at(light.where, "a spot with from equal to to", "from and to");
  spot.direction = normalize(spot.direction);
  spot.angle = 2 * cone, spot.blend = fade / cone;
  const double own = 2 * std::numbers::pi * (1 - full + (full - rim) / 2);
  spot.intensity = strength(light, "I", "power", own, making);
  making.scene->file.scene.lights.emplace_back(spot);
}

void make_infinite(const PbrtPlaced& light, const PbrtMaking& making, Sky& sky) {
  const std::string name = light.parameters.word("filename", "");
  if (light.parameters.find("portal")) {
    making.note(light.where,
                "the portal of an infinite light is left out: the light comes from all directions");
  }
  if (name.empty()) {
    sky.radiance += strength(light, "L", "illuminance", std::numbers::pi, making);
    return;
  }
  const std::filesystem::path file = making.folder / name;
  if (ending(file) != ".exr") {
    making.note(light.where,
                fmt::format("the infinite light {} is left out: expected an .exr (pbrt: "
                            "imgtool convert)",
                            shown(name)));
    return;
  }
  if (light.parameters.find("illuminance")) {
    making.note(light.where,
                "illuminance of a light with a picture is left out: set --exposure instead");
  }
  PbrtSkyPicture picture{read_sky(file), making.world * light.place,
                         strength(light, "L", "", 1, making)};
  if (picture.picture.width != picture.picture.height) {
    fail_at(light.where,
            fmt::format("{} of {} x {} pixels", shown(name), picture.picture.width,
                        picture.picture.height),
            "a square, as pbrt's equal-area pictures are (pbrt: imgtool makeequiarea)");
  }
  sky.pictures.push_back(std::move(picture));
}

/// To add a kind of light: its row.
struct LightKind {
  const char* type;
  void (*make)(const PbrtPlaced&, const PbrtMaking&, Sky&);
};
constexpr std::array<LightKind, 4> kLightKinds{{{"distant", make_distant},
                                                {"point", make_point},
                                                {"spot", make_spot},
                                                {"infinite", make_infinite}}};

void set_sky(const Sky& sky, const PbrtMaking& making) {
  Scene& scene = making.scene->file.scene;
  scene.environment = ConstantSky{sky.radiance};
  if (sky.pictures.empty()) return;
  making.scene->sky = to_latlong(sky.pictures, sky.radiance);
  ImageSky picture;
  picture.file = making.stem + "_sky.exr";
  scene.environment = picture;
}

}  // namespace

Rgb strength(const PbrtThing& light, const char* color, const char* amount, double own,
             const PbrtMaking& making) {
  const Rgb c = color_of(light, color, PbrtSpectrum::light, *making.notes).value_or(Rgb(1.0f));
  const double given = light.parameters.number(amount, 0);
  const double factor = light.parameters.number("scale", 1) * (given > 0 ? given / own : 1);
  const Vec3d all = Vec3d(c) * factor;
  if (!(min_component(all) >= 0) || !is_finite(Rgb(all))) {
    fail_at(light.where, fmt::format("a light of {}, {}, {}", all.x, all.y, all.z),
            "numbers of at least 0");
  }
  return Rgb(all);
}

void make_lights(const PbrtDescription& from, const PbrtMaking& making) {
  Sky sky;
  for (const PbrtPlaced& light : from.lights) {
    const auto* kind = std::ranges::find(
        kLightKinds, light.type, [](const LightKind& k) { return std::string_view(k.type); });
    if (kind == kLightKinds.end()) {
      making.note(light.where,
                  fmt::format("lights of type \"{}\" are left out", shown(light.type)));
      continue;
    }
    kind->make(light, making, sky);
    light.parameters.note_unused(*making.notes, light.type + " light");
  }
  set_sky(sky, making);
}

}  // namespace pvol::formats::detail
