// What the parts of a scene are made with.
#pragma once

#include <optional>
#include <string>

#include "pvol/formats/usda_scene.h"
#include "usda/usda_stage.h"

namespace pvol::formats::detail {

struct UsdMaking {
  const UsdStage& stage;
  ImportNotes* notes = nullptr;
  ImportedScene* scene = nullptr;  ///< what was made so far
  std::string stem{};              ///< that names of files beside the scene begin with

  void note(const UsdWhere& where, const std::string& text) const { notes->add(where, text); }
  /// Of colours.
  [[nodiscard]] ColorSpace space() const { return scene->file.scene.options.color_space; }
};

/// What RenderSettings say of the picture.
struct UsdPicture {
  std::string camera{};  ///< path; "": the first
  std::optional<std::array<int, 2>> size{};
  std::string policy = "expandAperture";  ///< aspectRatioConformPolicy
  ColorSpace space = ColorSpace::rec709;  ///< in which colours are taken as they are
};
[[nodiscard]] UsdPicture picture_of(const UsdMaking& making);

/// The camera and the size of its picture.
void make_camera(const UsdPicture& picture, const UsdMaking& making);

/// Lights and sky; without any, the usual ones.
void make_lights(const UsdMaking& making);

/// Colour, temperature, intensity and exposure of a light together. Per unit of its size where it
/// is normalised and `size` is not 0.
[[nodiscard]] Rgb emission_of(const UsdView& light, double size, ColorSpace space);

/// Skies of all DomeLights.
void make_domes(const std::vector<UsdItem>& domes, const UsdMaking& making);

void make_volumes(const UsdMaking& making);

/// Sets what a material's volume shader says, as far as pvol has it.
void set_shading(const UsdItem& volume, SceneVolume& to, const UsdMaking& making);

void make_surfaces(const UsdMaking& making);

/// The colour of a surface: of its material, else of itself or of what it is within, else 0.5.
[[nodiscard]] Rgb albedo_of(const UsdItem& surface, const UsdMaking& making);

/// The shader that an output or input is connected to, or null.
[[nodiscard]] const UsdPrim* source_of(const UsdStage& stage, const UsdView& shader,
                                       const std::string& name);

/// An attribute of a prim, as "inputs:density".
struct UsdInput {
  const UsdPrim* prim = nullptr;
  std::string name{};
};
/// Where the value of a shader's input is: in itself or, where it is connected, in its material or
/// in a node graph. Nothing where another shader makes it, or no connection leads to a value.
[[nodiscard]] std::optional<UsdInput> valued_input(const UsdStage& stage, const UsdView& shader,
                                                   const std::string& name);

/// Where it is at the frame and one frame later; nothing, and named, where no way leads between.
[[nodiscard]] std::optional<MovingPlacement> motion_of(const UsdPlace& place, const UsdItem& of,
                                                       const UsdMaking& making);

/// Throws Error that names the place of the prim where pvol refuses what was made of it.
template <class Thing>
void check_made(const UsdWhere& where, const Thing& thing) {
  try {
    validate(thing);
  } catch (const std::exception& e) {
    fail_at(where, e.what(), "what pvol can render");
  }
}

}  // namespace pvol::formats::detail
