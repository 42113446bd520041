// Scenes of pbrt-v4 as scenes of pvol.
#pragma once

#include <filesystem>
#include <string>

#include "pvol/formats/imported_scene.h"

namespace pvol::formats {

using PbrtScene = ImportedScene;

/// Reads a scene of pbrt-v4, with what it includes, and makes of it what pvol renders: cameras
/// (perspective, orthographic, spherical), film, suns, point lights, skies, media (homogeneous,
/// uniformgrid, nanovdb) and surfaces, all as if diffuse. Whatever else there is, is named in
/// `notes`. pbrt's world is left-handed: where its picture would be mirrored, the world is, which a
/// note says. `stem` begins the names of files beside the scene. Throws Error, which names file and
/// line, for what is not as pbrt has it, and for a scene without a medium that pvol renders.
[[nodiscard]] PbrtScene read_pbrt(const std::filesystem::path& file, const std::string& stem);

}  // namespace pvol::formats
