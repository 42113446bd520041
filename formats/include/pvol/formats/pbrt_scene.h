// Scenes of pbrt-v4 as scenes of pvol.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/formats/scene_file.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::formats {

/// What pvol makes of a scene of pbrt-v4. Files that are to stand beside it have bare names;
/// those that pbrt's scene names, absolute ones.
struct PbrtScene {
  SceneFile file{};
  /// .vdb files of grids that the scene has as numbers.
  struct Grids {
    std::string name;
    std::vector<VoxelGrid> grids;
  };
  std::vector<Grids> volumes{};
  struct Mesh {
    std::string name;  ///< .ply
    TriangleMesh mesh;
  };
  std::vector<Mesh> meshes{};
  /// Of the scene's ImageSky, whose file it is for: its pixels.
  ImageSky sky{};
  /// What is left out, approximated or worth knowing, each once: "scene.pbrt:12: the light ...".
  std::vector<std::string> notes{};
};

/// Reads a scene of pbrt-v4, with what it includes, and makes of it what pvol renders: cameras
/// (perspective, orthographic, spherical), film, suns, point lights, skies, media (homogeneous,
/// uniformgrid, nanovdb) and surfaces, all as if diffuse. Whatever else there is, is named in
/// `notes`. pbrt's world is left-handed: where its picture would be mirrored, the world is, which a
/// note says. `stem` begins the names of files beside the scene. Throws Error, which names file and
/// line, for what is not as pbrt has it, and for a scene without a medium that pvol renders.
[[nodiscard]] PbrtScene read_pbrt(const std::filesystem::path& file, const std::string& stem);

/// Writes the scene as TOML, for `read_scene`, and the files that it has beside it; names of other
/// files are made relative to it. Each file is written atomically, the scene last; where one fails,
/// those before it are removed. Throws Error where writing fails.
void write_pbrt(const std::filesystem::path& toml, const PbrtScene& scene);

}  // namespace pvol::formats
