// The values of a scene as controls of a page: what the tables of keys say of them, as JSON.
#pragma once

#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/formats/scene_file.h"

namespace pvol::viewer {

/// A part of a scene whose values are set one by one.
struct Section {
  std::string id;     ///< "camera", "sun[2]", "volume[1].medium"
  std::string title;  ///< "Sun 2"
  Entries entries;    ///< bound to the scene
  bool removable = false;
};

/// The sections of a scene, in the order in which people look for them. The entries refer to the
/// scene, and to lists of it that must not change their length.
[[nodiscard]] std::vector<Section> sections_of(formats::SceneFile& scene);

/// All of them with their keys: of each its value, help, unit, what it may be and, of a number, a
/// range that suits a slider.
[[nodiscard]] cli::Json describe_controls(formats::SceneFile& scene);

/// What can be added to a scene: kinds of lights and of surfaces that need no file.
[[nodiscard]] std::vector<std::string> kinds_to_add();

/// Changes a scene: {"section": "camera", "key": "fov", "value": 20}, {"add": "sun"} or {"remove":
/// "sun[2]"}. Throws Error that says what was found and expected; the scene may then be changed in
/// part.
void edit(formats::SceneFile& scene, const cli::Json& change);

}  // namespace pvol::viewer
