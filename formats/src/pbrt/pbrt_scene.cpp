#include "pvol/formats/pbrt_scene.h"

#include <fmt/format.h>

#include "pbrt/pbrt_world.h"
#include "pvol/error.h"

namespace pvol::formats {

PbrtScene read_pbrt(const std::filesystem::path& file, const std::string& stem) {
  PbrtScene scene;
  scene.origin = "a scene of pbrt-v4";
  detail::ImportNotes notes;
  const detail::PbrtDescription from = detail::parse_pbrt(file, notes);
  detail::PbrtMaking making{
      .world = {}, .notes = &notes, .scene = &scene, .folder = from.folder, .stem = stem};
  make_options(from, making);
  make_camera(from, making);
  make_lights(from, making);
  make_volumes(from, making);
  make_surfaces(from, making);
  scene.sources = from.files;
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

}  // namespace pvol::formats
