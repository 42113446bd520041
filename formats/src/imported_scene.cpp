#include "pvol/formats/imported_scene.h"

#include <algorithm>
#include <cctype>
#include <functional>

#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"
#include "pvol/formats/mesh_file.h"
#include "pvol/formats/scene_files.h"
#include "pvol/formats/vdb.h"

namespace pvol::formats {
namespace {

/// A film of a picture, which write_exr takes.
Film film_of(const ImageSky& sky) {
  Film film;
  film.width = film.crop_width = sky.width;
  film.height = film.crop_height = sky.height;
  film.pixels.resize(sky.pixels.size());
  for (std::size_t i = 0; i < sky.pixels.size(); ++i) {
    film.pixels[i].sum = Vec3d(sky.pixels[i]);
    film.pixels[i].alpha = 1;
    film.pixels[i].samples = 1;
  }
  return film;
}

/// The scene with names of files as seen from a folder.
SceneFile seen_from(const std::filesystem::path& folder, SceneFile file) {
  const auto relative = [&](const std::filesystem::path& name) {
    if (!name.is_absolute()) return name;
    const std::filesystem::path near = name.lexically_relative(folder);
    return near.empty() ? name : near;
  };
  visit_files(file, [&](auto& name) { name = relative(name).string(); });
  return file;
}

/// What was left out, as comments.
std::string text_of(const std::filesystem::path& folder, const ImportedScene& scene) {
  std::string text = "# From " + scene.origin + ", by pvol-convert.\n";
  for (const std::string& note : scene.notes) text += "# " + note + '\n';
  std::ranges::replace_if(
      text, [](char c) { return c != '\n' && std::iscntrl(static_cast<unsigned char>(c)); }, '?');
  return text + '\n' + to_toml(seen_from(folder, scene.file));
}

}  // namespace

void write_imported(const std::filesystem::path& toml, const ImportedScene& scene) {
  const std::filesystem::path folder =
      std::filesystem::absolute(toml).lexically_normal().parent_path();
  const std::string text = text_of(folder, scene);
  std::vector<std::filesystem::path> written;
  const auto write = [&](const std::string& name,
                         const std::function<void(const std::filesystem::path&)>& how) {
    const std::filesystem::path file = folder / name;
    const bool is_new = !std::filesystem::exists(file);
    how(file);
    if (is_new) written.push_back(file);
  };
  try {
    for (const ImportedScene::Grids& g : scene.volumes) {
      std::vector<const VoxelGrid*> grids;
      for (const VoxelGrid& grid : g.grids) grids.push_back(&grid);
      write(g.name, [&](const auto& to) { write_vdb(to, grids); });
    }
    for (const ImportedScene::Mesh& m : scene.meshes) {
      write(m.name, [&](const auto& to) { write_mesh(to, m.mesh, {}); });
    }
    const auto* sky = std::get_if<ImageSky>(&scene.file.scene.environment);
    if (sky != nullptr && !std::filesystem::path(sky->file).is_absolute()) {
      write(sky->file, [&](const auto& to) { (void)write_exr(to, film_of(scene.sky), {}); });
    }
    write_text_atomically(toml, text);
  } catch (...) {
    std::error_code ignored;
    for (const std::filesystem::path& file : written) std::filesystem::remove(file, ignored);
    throw;
  }
}

}  // namespace pvol::formats
