// The sections of a scene, for its reader, its writer and its manual.
#pragma once

#include <string_view>
#include <vector>

#include "pvol/formats/scene_file.h"

namespace pvol::formats {

/// "volume", "camera", and so on, with one for each kind of light and surface.
[[nodiscard]] std::vector<std::string_view> section_names();

}  // namespace pvol::formats
