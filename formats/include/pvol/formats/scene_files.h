// The files that a scene is made of.
#pragma once

#include <filesystem>
#include <variant>
#include <vector>

#include "pvol/formats/scene_file.h"

namespace pvol::formats {

/// visit(name) for each file's name in a scene, a path or a string; some may be empty.
template <class File, class Visit>
void visit_files(File& file, const Visit& visit) {
  for (auto& v : file.volumes) {
    visit(v.file);
    if (v.velocity) visit(v.velocity->file);
  }
  if (auto* sky = std::get_if<ImageSky>(&file.scene.environment)) visit(sky->file);
  for (auto& surface : file.scene.surfaces) {
    if (auto* solid = std::get_if<SolidSurface>(&surface)) visit(solid->file);
    if (auto* mesh = std::get_if<MeshSurface>(&surface)) visit(mesh->file);
  }
}

/// Those that are not empty, perhaps patterns.
[[nodiscard]] inline std::vector<std::filesystem::path> files_of(const SceneFile& scene) {
  std::vector<std::filesystem::path> files;
  visit_files(scene, [&](const std::filesystem::path& name) {
    if (!name.empty()) files.push_back(name);
  });
  return files;
}

}  // namespace pvol::formats
