// A scene that is edited step by step: with undo, for one frame or another, and as a file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/formats/scene_file.h"

namespace pvol::viewer {

class EditedScene {
 public:
  /// `frames` are those that there are; none where no file's name has a place for their number.
  EditedScene(formats::SceneFile scene, std::vector<int> frames);

  [[nodiscard]] const formats::SceneFile& scene() const { return scene_; }
  [[nodiscard]] const std::vector<int>& frames() const { return frames_; }
  [[nodiscard]] int frame() const { return frame_; }
  /// The scene with the files of the frame that is shown.
  [[nodiscard]] formats::SceneFile scene_of_frame() const;

  /// Changes the scene (controls.h), all of it or nothing. Steps of one gesture, which has a number
  /// above 0, are undone together. Throws Error that says why a change cannot be, also where it
  /// does not go together with other values of the scene.
  void edit(const cli::Json& changes, std::uint64_t gesture);
  /// Throws Error for a frame that there is not.
  void choose_frame(int frame);

  [[nodiscard]] bool can_undo() const { return !undone_to_.empty(); }
  [[nodiscard]] bool can_redo() const { return !redone_to_.empty(); }
  void undo();
  void redo();

  /// Whether this is one of the scene's files, of any frame.
  [[nodiscard]] bool reads(const std::filesystem::path& file) const;

  /// The text of a scene file in this folder.
  [[nodiscard]] std::string text_in(const std::filesystem::path& folder) const;

 private:
  void restore(std::vector<std::string>& from, std::vector<std::string>& to);

  formats::SceneFile scene_;
  std::vector<int> frames_;
  int frame_ = 0;
  std::vector<std::string> undone_to_, redone_to_;  ///< scenes as text, the next one last
  std::uint64_t gesture_ = 0;                       ///< of the last edit
};

}  // namespace pvol::viewer
