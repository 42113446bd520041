// From a scene as Python says it to a picture in memory.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/film_layers.h"
#include "cli/live_picture.h"
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
  bool denoise = false;        ///< filter the noise of the picture
};

/// The scene with the settings, before volumes are loaded. Throws Error.
[[nodiscard]] formats::SceneFile read_request(const SceneRequest& request);

/// A film with what was decided for it and what files say of it.
struct Picture {
  Film film;
  Counts counts{};
  bool counted = false;
  AovSet figures{};                               ///< of its pixels
  std::string plan;                               ///< a line for each choice, with its reason
  std::vector<std::string> warnings;              ///< what is likely to be a mistake
  std::map<std::string, std::string> attributes;  ///< of an EXR
  formats::ExrOptions layout{};
};

/// Puts the volumes that are in memory into the places that the scene's text has for them.
[[nodiscard]] cli::GivenClouds place_volumes(const SceneRequest& request, formats::SceneFile& file);

/// Sees the picture between passes, with the share of its samples, where that is known; returning
/// false ends the render. Called without the interpreter's lock.
using OnPass = std::function<bool(Picture picture, std::optional<double> share)>;

/// Loads, plans and renders; what `on_pass` ends is returned as far as it came. Throws Error as the
/// library does.
[[nodiscard]] Picture render_request(const SceneRequest& request, const OnPass& on_pass,
                                     const Stop& stop);

/// What there is of a picture that refines by itself: nothing before the first.
[[nodiscard]] std::optional<Picture> picture_of(const cli::LiveState& state);

/// Writes an .exr, with what `compare` needs beside the layers that were asked for, or a .png.
void save(const Picture& picture, const std::filesystem::path& file,
          const formats::Display& display);

/// Reads an .exr.
[[nodiscard]] Picture read_picture(const std::filesystem::path& file);

/// As cli/film_layers.h has them.
[[nodiscard]] cli::Plane layer_of(const Picture& picture, const std::string& name);
[[nodiscard]] std::vector<std::string> layer_names(const Picture& picture);

}  // namespace pvol::python
