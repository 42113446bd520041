// From pbrt's world, which is left-handed, to pvol's.
#pragma once

#include <string>

#include "pbrt/pbrt_description.h"
#include "pvol/formats/pbrt_scene.h"

namespace pvol::formats::detail {

/// What the parts of a scene are made with.
struct PbrtMaking {
  Affine world{};  ///< from pbrt's world to pvol's: nothing, or a mirror
  ImportNotes* notes = nullptr;
  PbrtScene* scene = nullptr;    ///< what was made so far
  std::filesystem::path folder;  ///< that names in the scene of pbrt are relative to
  std::string stem;              ///< that names of files beside the scene begin with

  void note(const PbrtWhere& where, const std::string& text) const { notes->add(where, text); }
};

/// The camera with the size of the picture, and `making.world` by which the picture is not
/// mirrored.
void make_camera(const PbrtDescription& from, PbrtMaking& making);

/// Film, filter, sampler and integrator.
void make_options(const PbrtDescription& from, const PbrtMaking& making);

/// Lights and sky.
void make_lights(const PbrtDescription& from, const PbrtMaking& making);

/// Colour times scale, and times a quantity of light where the parameter `amount` gives one, over
/// `own`, which the light has of it at colour and scale 1.
[[nodiscard]] Rgb strength(const PbrtThing& light, const char* color, const char* amount,
                           double own, const PbrtMaking& making);

/// Sums pictures of infinite lights up, each in pbrt's equal-area mapping, with a radiance from all
/// around, as a latitude-longitude picture.
struct PbrtSkyPicture {
  ImageSky picture;  ///< square
  Affine place;      ///< from the light's space to pvol's world
  Rgb factor;
};
[[nodiscard]] ImageSky to_latlong(const std::vector<PbrtSkyPicture>& pictures, Rgb radiance);

/// Volumes of the media that shapes bound.
void make_volumes(const PbrtDescription& from, const PbrtMaking& making);

/// The light of a shape that is one; false, and named, where pvol has none of its kind.
bool make_area_light(const PbrtShape& shape, const Affine& place, const PbrtMaking& making);

/// Surfaces of the other shapes.
void make_surfaces(const PbrtDescription& from, const PbrtMaking& making);

/// Whether a shape bounds a medium and is no surface.
[[nodiscard]] inline bool is_interface(const PbrtShape& shape) {
  return shape.material.type == "interface" || shape.material.type.empty() ||
         shape.material.type == "none";
}

}  // namespace pvol::formats::detail
