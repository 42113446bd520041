// From a scene as Python says it to a picture in memory.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "pvol/render/film.h"
#include "python/cancellable.h"
#include "python/cloud_volume.h"

namespace pvol::python {

using Volumes = std::vector<std::shared_ptr<const CloudVolume>>;

/// What to render.
struct SceneRequest {
  std::filesystem::path file;  ///< of a scene or a cloud; empty: `text`
  std::string text{};          ///< a scene, in which volumes in memory have a name for a file
  Volumes in_memory{};         ///< of each volume of the text, null where it is read from its file
  Words settings{};            ///< "render.spp", "camera.azimuth", ...
  bool count = false;          ///< the work
  bool force = false;          ///< render what would hardly end
};

/// The scene with the settings, before volumes are loaded. Throws Error.
[[nodiscard]] formats::SceneFile read_request(const SceneRequest& request);

/// A film with what was decided for it and what files say of it.
struct Picture {
  Film film;
  Counts counts{};
  bool counted = false;
  std::string plan;                               ///< a line for each choice, with its reason
  std::vector<std::string> warnings;              ///< what is likely to be a mistake
  std::map<std::string, std::string> attributes;  ///< of an EXR
  formats::ExrOptions layout{};
};

/// Loads, plans and renders. Throws Error as the library does.
[[nodiscard]] Picture render_request(const SceneRequest& request, const Stop& stop);

/// Writes an .exr, with what `compare` needs beside the layers that were asked for, or a .png.
void save(const Picture& picture, const std::filesystem::path& file, double exposure,
          formats::ToneMap map);

/// Reads an .exr.
[[nodiscard]] Picture read_picture(const std::filesystem::path& file);

/// An image of a film's crop, rows from the top.
struct Plane {
  int components = 1;
  std::vector<float> values;
};
/// A layer, or a figure that each pixel has, by the name of its AOV. Throws Error that lists them.
[[nodiscard]] Plane layer_of(const Picture& picture, const std::string& name);
[[nodiscard]] std::vector<std::string> layer_names(const Picture& picture);

}  // namespace pvol::python
