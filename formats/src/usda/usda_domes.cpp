// UsdLux's domes. Their pictures are those of OpenEXR's latitude-longitude maps: +y is up, +z in
// the middle, +x at a quarter from the left. pvol's have +x at the left edge and +z at a quarter.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "pvol/formats/cloud.h"
#include "usda/usda_light.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

/// The shortest turn that takes +y to a direction.
Affine turn_of_up(Vec3d up) {
  const Vec3d y{0, 1, 0};
  const double cosine = dot(y, up);
  if (cosine < -1 + 1e-9) return turn_of({0, 1, 0, 0});  // about x
  const Vec3d axis = cross(y, up);
  return turn_of({1 + cosine, axis.x, axis.y, axis.z});
}

/// A DomeLight_1 may stand on another pole: it is turned there before its transform.
Affine pole_of(const UsdView& dome, const UsdMaking& making) {
  const std::string pole = dome.word("poleAxis", "scene");
  if (dome.prim().type != "DomeLight_1") return {};
  const bool z = pole == "Z" || (pole == "scene" && making.stage.z_up);
  return z ? turn_of({std::sqrt(0.5), std::sqrt(0.5), 0, 0}) : Affine{};
}

/// Up and rotation of a picture by what it turns to.
void set_turn(ImageSky& sky, const Affine& place) {
  sky.up = normalize(place.vector({0, 1, 0}));
  const Vec3d x = inverse(turn_of_up(sky.up)).vector(place.vector({1, 0, 0}));
  const double turned = std::atan2(x.z, x.x) * (180 / std::numbers::pi);
  sky.rotation = std::remainder(turned - 90, 360);
}

/// Why a picture cannot be the sky; "" where it can.
std::string fault_of_picture(const UsdView& dome, const std::string& file) {
  const std::string format = dome.word(input_of(dome, "texture:format"), "automatic");
  if (format != "automatic" && format != "latlong") {
    return fmt::format("its format is \"{}\", and not latlong", usd_shown(format));
  }
  const std::string kind = ending(file);
  if (kind != ".exr" && kind != ".hdr") return "expected an .exr or .hdr";
  std::error_code ignored;
  return std::filesystem::exists(file, ignored) ? "" : "there is no such file";
}

std::optional<ImageSky> picture_of_dome(const UsdItem& item, const UsdView& dome, Rgb scale,
                                        const UsdMaking& making) {
  const std::string name = input_of(dome, "texture:file"), file = dome.file(name);
  if (file.empty()) return std::nullopt;
  const std::string fault = fault_of_picture(dome, file);
  if (!fault.empty()) {
    making.note(dome.find(name)->where,
                fmt::format("the picture {} is left out: {}", usd_shown(file), fault));
    return std::nullopt;
  }
  ImageSky sky;
  sky.file = file, sky.scale = scale;
  const Affine place = item.place.now * pole_of(dome, making);
  if (determinant(place) < 0) making.note(dome.where(), "the mirroring of a DomeLight is left out");
  set_turn(sky, place);
  return sky;
}

}  // namespace

void make_domes(const std::vector<UsdItem>& domes, const UsdMaking& making) {
  std::optional<ImageSky> picture;
  Vec3d even{0, 0, 0};
  for (const UsdItem& item : domes) {
    const UsdView dome = making.stage.view(*item.prim);
    const Rgb radiance = emission_of(dome, 0, making.space());
    const std::optional<ImageSky> own = picture_of_dome(item, dome, radiance, making);
    if (own && picture) {
      making.note(dome.where(), "only the first DomeLight with a picture is taken");
    } else if (own) {
      picture = own;
    } else if (!dome.says(input_of(dome, "texture:file"))) {
      even += Vec3d(radiance);
    }
    ignore_usual(dome);
    for (const char* name : {"guideRadius", "poleAxis"}) dome.ignore(name);
    dome.ignore(input_of(dome, "texture:format"));
    dome.note_unused(*making.notes);
  }
  Environment& sky = making.scene->file.scene.environment;
  sky = ConstantSky{Rgb(even)};
  if (!picture) return;
  sky = *picture;
  if (max_component(even) > 0) {
    making.note(domes.front().prim->where,
                "DomeLights without a picture are left out beside one that has one");
  }
}

}  // namespace pvol::formats::detail
