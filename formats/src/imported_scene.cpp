#include "pvol/formats/imported_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <set>
#include <string_view>
#include <system_error>

#include "pvol/error.h"
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

/// The name of the picture of the sky that is to stand beside the scene, if any.
std::string sky_beside(const ImportedScene& scene) {
  const auto* sky = std::get_if<ImageSky>(&scene.file.scene.environment);
  return sky == nullptr || std::filesystem::path(sky->file).is_absolute() ? "" : sky->file;
}

/// The names of all files that are to stand beside the scene.
std::vector<std::string> names_beside(const ImportedScene& scene) {
  std::vector<std::string> names;
  for (const ImportedScene::Grids& g : scene.volumes) names.push_back(g.name);
  for (const ImportedScene::Mesh& m : scene.meshes) names.push_back(m.name);
  if (const std::string sky = sky_beside(scene); !sky.empty()) names.push_back(sky);
  return names;
}

constexpr std::string_view kBeside = "# Written beside it: ";

/// The comment by which a later conversion knows that a file is its own to replace.
std::string line_of(const std::string& name) {
  std::string line = std::string(kBeside) + name;
  std::ranges::replace_if(
      line, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)); }, '?');
  return line;
}

/// Such comments of an earlier conversion, as far as the files are still there.
std::set<std::string> earlier_lines(const std::filesystem::path& toml,
                                    const std::filesystem::path& folder) {
  std::set<std::string> lines;
  std::ifstream in(toml);
  std::error_code failed;
  for (std::string line; std::getline(in, line) && line.starts_with('#');) {
    if (!line.starts_with(kBeside)) continue;
    if (std::filesystem::exists(folder / line.substr(kBeside.size()), failed)) lines.insert(line);
  }
  return lines;
}

/// One name for each file, however it was reached.
std::filesystem::path real_name(const std::filesystem::path& file) {
  std::error_code failed;
  const std::filesystem::path given = std::filesystem::absolute(file, failed);  // "" of ""
  const std::filesystem::path real = std::filesystem::weakly_canonical(given, failed);
  return failed ? given.lexically_normal() : real;
}

/// Throws Error where writing the scene would replace what is not its own.
void check_names(const std::filesystem::path& toml, const std::filesystem::path& folder,
                 const std::set<std::string>& earlier, const ImportedScene& scene) {
  std::set<std::filesystem::path> taken;
  for (const std::filesystem::path& file : scene.sources) taken.insert(real_name(file));
  for (const std::filesystem::path& file : files_of(scene.file)) {
    if (file.is_absolute()) taken.insert(real_name(file));
  }
  const auto require_free = [&](const std::filesystem::path& file) {
    if (!taken.contains(real_name(file))) return;
    throw Error(file.string() +
                ": would be replaced, but the input refers to this file; choose another name for "
                "the output");
  };
  for (const std::string& name : names_beside(scene)) {
    const std::filesystem::path file = folder / name;
    require_free(file);
    std::error_code failed;
    if (!std::filesystem::exists(file, failed) || earlier.contains(line_of(name))) continue;
    throw Error(fmt::format(
        "{}: would be replaced, but no earlier conversion to {} wrote this file; move it away, or "
        "choose another name for the output",
        file.string(), toml.filename().string()));
  }
  require_free(toml);
}

/// What was written beside it, now or earlier, and what was left out, as comments.
std::string text_of(const std::filesystem::path& folder, std::set<std::string> beside,
                    const ImportedScene& scene) {
  std::string text = "# From " + scene.origin + ", by pvol-convert.\n";
  for (const std::string& name : names_beside(scene)) beside.insert(line_of(name));
  for (const std::string& line : beside) text += line + '\n';
  for (const std::string& note : scene.notes) text += "# " + note + '\n';
  std::ranges::replace_if(
      text, [](char c) { return c != '\n' && std::iscntrl(static_cast<unsigned char>(c)); }, '?');
  return text + '\n' + to_toml(seen_from(folder, scene.file));
}

}  // namespace

void write_imported(const std::filesystem::path& toml, const ImportedScene& scene) {
  const std::filesystem::path folder =
      std::filesystem::absolute(toml).lexically_normal().parent_path();
  const std::set<std::string> earlier = earlier_lines(toml, folder);
  check_names(toml, folder, earlier, scene);
  const std::string text = text_of(folder, earlier, scene);
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
    if (const std::string sky = sky_beside(scene); !sky.empty()) {
      write(sky, [&](const auto& to) { (void)write_exr(to, film_of(scene.sky), {}); });
    }
    write_text_atomically(toml, text);
  } catch (...) {
    std::error_code ignored;
    for (const std::filesystem::path& file : written) std::filesystem::remove(file, ignored);
    throw;
  }
}

}  // namespace pvol::formats
