// Scenes of other renderers as scenes of pvol.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/formats/scene_file.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::formats {

/// What pvol makes of a scene. Files that are to stand beside it have bare names; those that the
/// scene it was made from names, absolute ones.
struct ImportedScene {
  std::string origin{};  ///< "a scene of pbrt-v4"
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
  /// Of the scene's ImageSky, where it has a bare name: its pixels.
  ImageSky sky{};
  /// What is left out, approximated or worth knowing, each once: "scene.pbrt:12: the light ...".
  std::vector<std::string> notes{};
  /// The files that it was made from, and others that they refer to, whether it needs them or not.
  std::vector<std::filesystem::path> sources{};
};

/// Writes the scene as TOML, for `read_scene`, and the files that it has beside it; names of other
/// files are made relative to it. Each file is written atomically, the scene last; where one fails,
/// those before it are removed. Throws Error where writing fails, and before anything is written
/// where a file would be replaced that the scene refers to, or one beside it that no earlier call
/// for the same `toml` wrote: comments in that name what was.
void write_imported(const std::filesystem::path& toml, const ImportedScene& scene);

}  // namespace pvol::formats
