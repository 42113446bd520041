#include "pvol/formats/usda_scene.h"

#include "pvol/error.h"
#include "usda/usda_compose.h"
#include "usda/usda_world.h"

namespace pvol::formats {

ImportedScene read_usda(const std::filesystem::path& file, const std::string& stem,
                        std::optional<int> frame) {
  ImportedScene scene;
  scene.origin = "a scene of USD";
  detail::ImportNotes notes;
  const detail::UsdStage stage = stage_of(detail::compose_usda(file, notes), frame, notes);
  const detail::UsdMaking making{stage, &notes, &scene, stem};
  const detail::UsdPicture picture = picture_of(making);
  scene.file.scene.options.color_space = picture.space;
  make_camera(picture, making);
  make_lights(making);
  make_volumes(making);
  make_surfaces(making);
  scene.notes = notes.all();
  if (!scene.file.volumes.empty()) {
    (void)parse_scene(to_toml(scene.file), file.string() + ", as a scene of pvol");
    return scene;
  }
  std::string why = file.string() +
                    ": has no volume that pvol renders; expected a visible Volume with the fields "
                    "of an OpenVDBAsset";
  for (const std::string& note : scene.notes) {
    if (note.find("field \"") != note.npos || note.find(": volume ") != note.npos) {
      why += "\n  " + note;
    }
  }
  throw Error(why);
}

}  // namespace pvol::formats
