// The volumes of a scene: their files, media and placements.
#pragma once

#include "pvol/formats/scene_file.h"
#include "toml/toml_table.h"

namespace pvol::formats {

/// Where what has a placement is a frame later. Throws Error as read_keys does, and for misfits.
[[nodiscard]] MovingPlacement read_to(const TomlTable& table, const Placement& from);

/// All of a scene: the first has the scene's [medium], the others one of their own. Throws Error as
/// read_keys does.
void read_volumes(const TomlTable& root, SceneFile& file);

}  // namespace pvol::formats
