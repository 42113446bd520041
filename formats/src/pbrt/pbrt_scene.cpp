#include "pvol/formats/pbrt_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>

#include "pbrt/pbrt_world.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"
#include "pvol/formats/mesh_file.h"
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
  for (SceneVolume& v : file.volumes) v.file = relative(v.file);
  for (Surface& surface : file.scene.surfaces) {
    if (auto* mesh = std::get_if<MeshSurface>(&surface)) mesh->file = relative(mesh->file).string();
  }
  return file;
}

/// What was left out, as comments.
std::string text_of(const std::filesystem::path& folder, const PbrtScene& scene) {
  std::string text = "# From a scene of pbrt-v4, by pvol-convert.\n";
  for (const std::string& note : scene.notes) text += "# " + note + '\n';
  std::ranges::replace_if(
      text, [](char c) { return c != '\n' && std::iscntrl(static_cast<unsigned char>(c)); }, '?');
  return text + '\n' + to_toml(seen_from(folder, scene.file));
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream stream(aside, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream)
      throw Error(file.string() + ": cannot be written; check that there is space on the disk");
  });
}

}  // namespace

PbrtScene read_pbrt(const std::filesystem::path& file, const std::string& stem) {
  PbrtScene scene;
  detail::PbrtNotes notes;
  const detail::PbrtDescription from = detail::parse_pbrt(file, notes);
  detail::PbrtMaking making{
      .world = {}, .notes = &notes, .scene = &scene, .folder = from.folder, .stem = stem};
  make_options(from, making);
  make_camera(from, making);
  make_lights(from, making);
  make_volumes(from, making);
  make_surfaces(from, making);
  scene.notes = notes.all();
  if (!scene.file.volumes.empty()) return scene;
  std::string why = file.string() +
                    ": has no medium that pvol renders; expected one of type homogeneous, "
                    "uniformgrid or nanovdb inside a shape";
  for (const std::string& note : scene.notes) {
    if (note.find(": medium \"") != note.npos) why += "\n  " + note;
  }
  throw Error(why);
}

void write_pbrt(const std::filesystem::path& toml, const PbrtScene& scene) {
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
    for (const PbrtScene::Grids& g : scene.volumes) {
      std::vector<const VoxelGrid*> grids;
      for (const VoxelGrid& grid : g.grids) grids.push_back(&grid);
      write(g.name, [&](const auto& to) { write_vdb(to, grids); });
    }
    for (const PbrtScene::Mesh& m : scene.meshes) {
      write(m.name, [&](const auto& to) { write_mesh(to, m.mesh, {}); });
    }
    if (const auto* sky = std::get_if<ImageSky>(&scene.file.scene.environment)) {
      write(sky->file, [&](const auto& to) { (void)write_exr(to, film_of(scene.sky), {}); });
    }
    write_text(toml, text);
  } catch (...) {
    std::error_code ignored;
    for (const std::filesystem::path& file : written) std::filesystem::remove(file, ignored);
    throw;
  }
}

}  // namespace pvol::formats
