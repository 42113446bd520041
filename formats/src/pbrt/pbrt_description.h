// A scene as pbrt's directives describe it, before anything is made of it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pbrt/pbrt_params.h"
#include "pvol/math/affine.h"

namespace pvol::formats::detail {

/// A thing that has a place: from its own space to pbrt's world.
struct PbrtPlaced : PbrtThing {
  Affine place{};
};

struct PbrtShape : PbrtPlaced {
  PbrtThing material{};  ///< of type "interface" or "" where it is no surface
  /// By NamedMaterial; after parsing, `material` is the one of that name.
  std::optional<std::string> material_name{};
  std::string inside{}, outside{};  ///< names of media; "": none
  std::optional<PbrtThing> area_light{};
  bool reversed = false;  ///< whether its front is its back
};

struct PbrtDescription {
  std::optional<PbrtPlaced> camera;  ///< its place takes the camera's space to the world
  std::string camera_medium;
  PbrtThing film, sampler, filter, integrator;
  std::vector<PbrtPlaced> lights;
  std::vector<std::pair<std::string, PbrtPlaced>> media;  ///< by name, in the order of the file
  std::vector<PbrtShape> shapes;
  std::map<std::string, PbrtThing> textures;
  std::filesystem::path folder;              ///< that file names are relative to
  std::vector<std::filesystem::path> files;  ///< the scene's own, and those that it refers to
};

/// Reads a scene with what it includes. Directives that are of no use here are named in `notes`.
/// Throws Error, which names file and line, for what is not as the format has it.
[[nodiscard]] PbrtDescription parse_pbrt(const std::filesystem::path& file, ImportNotes& notes);

}  // namespace pvol::formats::detail
