#include "view/edited_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <utility>

#include "cli/frames.h"
#include "pvol/error.h"
#include "pvol/formats/scene_files.h"
#include "view/controls.h"

namespace pvol::viewer {
namespace {

constexpr std::size_t kMostSteps = 1000;

/// The scene as a file would bring it back, which refuses what does not go together. Nobody sees
/// the text, so messages do without its lines.
formats::SceneFile read_back(const std::string& text) {
  try {
    return formats::parse_scene(text, "scene");
  } catch (const Error& e) {
    throw Error(std::regex_replace(e.what(), std::regex("^scene:[0-9]+:[0-9]+: "), ""));
  }
}

/// Gives a scene that was read back what no file has.
void keep_unwritten(const formats::SceneFile& from, formats::SceneFile& to) {
  to.scene.options.threads = from.scene.options.threads;
  for (std::size_t i = 0; i < to.volumes.size(); ++i) {
    to.volumes[i].shows_fire = from.volumes[i].shows_fire;
  }
}

}  // namespace

EditedScene::EditedScene(formats::SceneFile scene, std::vector<int> frames)
    : scene_(std::move(scene)), frames_(std::move(frames)) {
  if (!frames_.empty()) frame_ = frames_.front();
}

formats::SceneFile EditedScene::scene_of_frame() const {
  formats::SceneFile scene = scene_;
  if (!frames_.empty()) {
    formats::visit_files(scene,
                         [&](auto& name) { name = cli::file_of_frame(name, frame_).string(); });
  }
  return scene;
}

void EditedScene::edit(const cli::Json& changes, std::uint64_t gesture) {
  if (!changes.is_array() || changes.empty())
    throw Error("found no edits, expected a list of some");
  formats::SceneFile changed = scene_;
  for (const cli::Json& change : changes) viewer::edit(changed, change);
  changed = read_back(formats::to_toml(changed));
  keep_unwritten(scene_, changed);
  if (gesture == 0 || gesture != gesture_) {
    undone_to_.push_back(formats::to_toml(scene_));
    if (undone_to_.size() > kMostSteps) undone_to_.erase(undone_to_.begin());
  }
  redone_to_.clear();
  gesture_ = gesture;
  scene_ = std::move(changed);
}

void EditedScene::choose_frame(int frame) {
  if (std::ranges::find(frames_, frame) == frames_.end()) {
    throw Error(fmt::format("there is no frame {}; expected one of --frames", frame));
  }
  frame_ = frame;
}

void EditedScene::restore(std::vector<std::string>& from, std::vector<std::string>& to) {
  if (from.empty()) return;
  formats::SceneFile before = read_back(from.back());
  keep_unwritten(scene_, before);
  to.push_back(formats::to_toml(scene_));
  from.pop_back();
  scene_ = std::move(before);
  gesture_ = 0;
}

void EditedScene::undo() { restore(undone_to_, redone_to_); }

void EditedScene::redo() { restore(redone_to_, undone_to_); }

bool EditedScene::reads(const std::filesystem::path& file) const {
  bool found = false;
  const auto look = [&](const std::filesystem::path& name) {
    std::error_code unknown;
    found = found || std::filesystem::equivalent(name, file, unknown);
  };
  formats::SceneFile scene = scene_;
  formats::visit_files(scene, [&](auto& name) {
    if (frames_.empty()) look(name);
    for (const int frame : frames_) look(cli::file_of_frame(name, frame));
  });
  return found;
}

std::string EditedScene::text_in(const std::filesystem::path& folder) const {
  formats::SceneFile scene = scene_;
  const auto base = std::filesystem::absolute(folder);
  formats::visit_files(scene, [&](auto& name) {
    if (name.empty()) return;
    name = std::filesystem::absolute(name).lexically_normal().lexically_proximate(base).string();
  });
  return formats::to_toml(scene);
}

}  // namespace pvol::viewer
