// What a viewer's page asks for, without the network: requests and answers as JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cli/json.h"
#include "cli/live_picture.h"
#include "view/edited_scene.h"
#include "view/views.h"

namespace pvol::viewer {

/// A scene, its picture, and what a page may do with them. All calls may come from any thread.
class Viewer {
 public:
  /// `scene` has nothing left to choose, and was prepared by `live`. Scenes are saved in `folder`,
  /// at first under the name `file`.
  Viewer(EditedScene scene, cli::LiveScene live, std::filesystem::path folder, std::string file);

  /// All that a page shows beside the picture: controls, layers, frames, what can be undone.
  [[nodiscard]] cli::Json describe();

  /// Takes {"edits": [...], "gesture": N}, {"undo": true}, {"redo": true}, {"frame": N}, or
  /// {"show": {"filter": true, "layer": "depth"}}; answers as `describe`. Throws Error for what
  /// cannot be, which changes nothing.
  [[nodiscard]] cli::Json change(const cli::Json& request);

  /// How far the picture is, as soon as its state has a number above `after`, or after so many
  /// seconds.
  [[nodiscard]] cli::Json state(std::uint64_t after, double seconds) const;

  /// The picture so far; empty before the first. Throws Error for a layer that there is not.
  [[nodiscard]] View picture(const ViewChoice& choice, bool filtered) const;

  /// What the picture has at this place, in [0, 1) across and down. Throws Error for other places.
  [[nodiscard]] cli::Json pixel(double across, double down) const;

  /// Writes the scene into the folder: {"name": "cloud.toml", "replace": true}. Throws Error for a
  /// name that is not one of a file in the folder, for a file that is there and is not to be
  /// replaced, and for one that the scene reads. Answers with the path.
  [[nodiscard]] cli::Json save(const cli::Json& request);

 private:
  void apply(const cli::Json& request);
  void render();
  [[nodiscard]] cli::Json describe_locked();
  [[nodiscard]] formats::Screen screen_for(const formats::Display& display, ColorSpace space) const;

  mutable std::mutex mutex_;  ///< of all but the picture
  EditedScene scene_;
  std::filesystem::path folder_;
  std::string file_;
  bool filter_ = false;
  std::uint64_t change_ = 0;  ///< of the picture, the last one
  std::string layer_ = "colour";
  std::vector<std::string> tone_maps_;
  /// The screen that was asked for last: those of configurations take long to make.
  struct LastScreen {
    std::string tone_map;
    ColorSpace space;
    formats::Screen screen;
  };
  mutable std::mutex screen_mutex_;
  mutable std::optional<LastScreen> last_screen_;
  cli::LivePicture picture_;
};

}  // namespace pvol::viewer
