// Scenes of USD, as text, as scenes of pvol.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pvol/formats/imported_scene.h"

namespace pvol::formats {

/// Reads a scene of USD from its text (.usda, or .usd that is text), with the layers that it refers
/// to, and makes of it what pvol renders at a frame: camera, render settings, lights, volumes of
/// OpenVDB files, and surfaces, all as if diffuse. Without a frame it is the first: startTimeCode,
/// else the first sample; and files of volumes that have a number of a frame in their names become
/// a pattern. What moves has a place one frame later. Whatever else there is, is named in `notes`.
/// `stem` begins the names of files beside the scene. Throws Error, which names file, line and
/// column, for what is not as USD has it, and for a scene without a volume that pvol renders.
[[nodiscard]] ImportedScene read_usda(const std::filesystem::path& file, const std::string& stem,
                                      std::optional<int> frame = {});

}  // namespace pvol::formats
