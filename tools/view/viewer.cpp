#include "view/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "view/controls.h"

namespace pvol::viewer {

using cli::Json;
namespace fs = std::filesystem;

namespace {

/// Throws Error for what would not be a plain file of a folder.
void check_name(const std::string& name) {
  const fs::path path = name;
  const bool plain = path.filename() == path && !name.starts_with('.') && name.size() <= 200 &&
                     std::ranges::none_of(name, [](char c) { return c >= 0 && c < ' '; });
  if (plain && path.extension() == ".toml") return;
  throw Error(fmt::format("'{}': expected a name like cloud.toml, without folders", name));
}

/// Edits with names of files as scenes in the folder have them: relative to it.
Json with_files_in(const fs::path& folder, Json edits) {
  if (!edits.is_array()) return edits;
  for (Json& edit : edits) {
    if (!edit.is_object() || edit.value("key", Json()) != "file") continue;
    if (!edit.contains("value") || !edit["value"].is_string()) continue;
    const std::string name = edit["value"];
    if (!name.empty()) edit["value"] = (folder / name).string();
  }
  return edits;
}

/// A configuration that cannot be read is no reason not to look at pictures.
std::vector<std::string> tone_maps_there_are() {
  try {
    return formats::tone_maps();
  } catch (const Error& e) {
    cli::print_warnings("pvol-view", {std::string(e.what()) + ": its views are left out"});
    const auto own = all_names<formats::ToneMap>();
    return {own.begin(), own.end()};
  }
}

}  // namespace

Viewer::Viewer(EditedScene scene, cli::LiveScene live, fs::path folder, std::string file)
    : scene_(std::move(scene)),
      folder_(std::move(folder)),
      file_(std::move(file)),
      tone_maps_(tone_maps_there_are()),
      picture_(std::move(live)) {
  render();
}

void Viewer::render() {
  formats::SceneFile scene = scene_.scene_of_frame();
  AovSet& aovs = scene.scene.options.aovs;
  aovs.add(Aov::depth);  // for the focus of a click
  aovs.add(needs_of_layer(layer_));
  change_ = picture_.change(std::move(scene), {.filter = filter_});
}

Json Viewer::describe_locked() {
  formats::SceneFile scene = scene_.scene();
  return {{"sections", describe_controls(scene)},
          {"kinds", kinds_to_add()},
          {"layers", layers_to_view()},
          {"tone_maps", tone_maps_},
          {"layer", layer_},
          {"filter", filter_},
          {"change", change_},
          {"frames", scene_.frames()},
          {"frame", scene_.frame()},
          {"undo", scene_.can_undo()},
          {"redo", scene_.can_redo()},
          {"folder", folder_.string()},
          {"file", file_}};
}

Json Viewer::describe() {
  const std::lock_guard lock(mutex_);
  return describe_locked();
}

void Viewer::apply(const Json& request) {
  if (request.contains("edits")) {
    scene_.edit(with_files_in(folder_, request["edits"]),
                request.value("gesture", std::uint64_t(0)));
  } else if (request.contains("undo")) {
    scene_.undo();
  } else if (request.contains("redo")) {
    scene_.redo();
  } else if (request.contains("frame")) {
    const Json& frame = request["frame"];
    if (!frame.is_number_integer()) {
      throw Error("found frame " + frame.dump() + ", expected a whole number");
    }
    scene_.choose_frame(int(std::clamp(frame.get<double>(), -1e9, 1e9)));
  } else if (request.contains("show")) {
    const Json& show = request["show"];
    const std::string layer = show.value("layer", layer_);
    check_layer(layer);
    filter_ = show.value("filter", filter_);
    layer_ = layer;
  } else {
    throw Error("found nothing to change; expected edits, undo, redo, frame or show");
  }
}

Json Viewer::change(const Json& request) {
  const std::lock_guard lock(mutex_);
  apply(request);
  render();
  return describe_locked();
}

Json Viewer::state(std::uint64_t after, double seconds) const {
  const cli::LiveState s = picture_.wait(after, seconds);
  Json j = {{"number", s.number},     {"change", s.change},   {"coarse", s.coarse},
            {"finished", s.finished}, {"samples", s.samples}, {"wanted", s.samples_wanted},
            {"seconds", s.seconds},   {"error", s.error},     {"filtered", s.filtered != nullptr}};
  if (!s.film) return j;
  j["width"] = s.film->crop_width, j["height"] = s.film->crop_height;
  j["per_pixel"] = double(s.samples) / double(std::max<std::size_t>(1, s.film->pixels.size()));
  if (const auto noise = pixel_noise(*s.film)) j["noise"] = *noise;
  if (s.filtered) j["filter_error"] = s.filtered->relative_error;
  return j;
}

View Viewer::picture(const ViewChoice& choice, bool filtered) const {
  check_layer(choice.layer);
  const cli::LiveState s = picture_.state();
  if (!s.film) return {};
  const Film& film = filtered && s.filtered ? s.filtered->film : *s.film;
  return view_of(film, choice, screen_for(choice.display, film.color_space));
}

formats::Screen Viewer::screen_for(const formats::Display& display, ColorSpace space) const {
  const std::lock_guard lock(screen_mutex_);
  if (!last_screen_ || last_screen_->tone_map != display.tone_map || last_screen_->space != space) {
    last_screen_ = LastScreen{display.tone_map, space, formats::Screen(display, space)};
  }
  formats::Screen screen = last_screen_->screen;
  screen.expose(display.exposure);
  return screen;
}

Json Viewer::pixel(double across, double down) const {
  const cli::LiveState s = picture_.state();
  if (!s.film) throw Error("there is no picture yet");
  if (!(across >= 0 && across < 1 && down >= 0 && down < 1)) {
    throw Error("the place is not in the picture; expected numbers in [0, 1)");
  }
  return describe_pixel(*s.film, int(across * s.film->crop_width), int(down * s.film->crop_height));
}

Json Viewer::save(const Json& request) {
  const std::string name = request.at("name");
  check_name(name);
  const std::lock_guard lock(mutex_);
  const fs::path file = folder_ / name;
  std::error_code unknown;
  if (scene_.reads(file)) {
    throw Error(fmt::format("the scene reads {} itself; choose another name", file.string()));
  }
  if (fs::is_symlink(file, unknown)) {
    throw Error(fmt::format("{} is a link to another place; choose another name", file.string()));
  }
  if (fs::exists(file, unknown) && !request.value("replace", false)) {
    throw Error(
        fmt::format("{} is there already; choose another name, or replace it", file.string()));
  }
  formats::write_text_atomically(file, scene_.text_in(folder_));
  file_ = name;
  return {{"path", file.string()}};
}

}  // namespace pvol::viewer
