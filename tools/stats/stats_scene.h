// A scene and its clouds in memory, for the verbs of pvol-stats that render.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/interrupt.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_file.h"
#include "pvol/measure/sweep.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"

namespace pvol::cli {

/// What the user says of the scene to measure.
struct SceneOptions {
  std::filesystem::path input;  ///< a scene (.toml) or a cloud
  formats::GridOptions grid;
  std::vector<std::string> sets;
  std::optional<std::array<int, 2>> size;
  std::optional<double> extinction;  ///< per world unit and unit of density
  std::optional<double>
      thickness;       ///< mean optical thickness along the first cloud's thickest axis
  bool force = false;  ///< measure what would hardly end, too
};

struct LoadedScene {
  formats::SceneFile file;
  std::vector<formats::Cloud> clouds;
  std::vector<VolumeFacts> facts;             ///< of each cloud, without its octree
  bool chose_extinction = false;              ///< neither the user nor the scene gave one
  bool framed = false;                        ///< nor a camera
  bool force = false;                         ///< as asked for
  int picture_width = 0, picture_height = 0;  ///< of the scene, which is measured at another size
  std::vector<std::string> warnings{};        ///< RenderPlan's, for whoever tells them
};

/// Reads everything and completes it as pvol-render does: an extinction that makes the thickest
/// axis 40 mean free paths thick, a camera that frames the clouds. Pictures get the size asked for,
/// or else one of about `pixels` pixels in the scene's proportions, without a crop. Prints
/// warnings.
[[nodiscard]] LoadedScene load_scene(const SceneOptions& o, int pixels, bool quiet);

/// The cloud of a scene's volume, with what the volume leaves open chosen.
using LoadCloud = std::function<formats::Cloud(formats::SceneVolume&)>;

/// The same for a scene that was read, without the files that it names, and clouds from anywhere;
/// prints nothing.
[[nodiscard]] LoadedScene load_scene(formats::SceneFile file, const SceneOptions& o, int pixels,
                                     const LoadCloud& load);

/// A way to change a scene and its clouds before they are rendered.
using ChangeScene = std::function<void(Scene&)>;
using ChangeCloud = std::function<void(formats::Cloud&)>;

/// Makes the volumes of the changed scene, timed, and renders them on this many threads, until
/// `stopped` says so.
[[nodiscard]] measure::Run render_changed(const LoadedScene& loaded,
                                          const ChangeScene& change_scene,
                                          const ChangeCloud& change_cloud,
                                          const measure::RunRequest& request, int threads,
                                          const std::function<bool()>& stopped = interrupted);

/// Seconds of a clock that never goes back.
[[nodiscard]] double clock_seconds();

/// The scene in one line: size of the cloud, extinction, optical thickness, picture, albedo, g.
[[nodiscard]] std::string describe(const LoadedScene& loaded);

}  // namespace pvol::cli
