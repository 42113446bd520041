#include "cli/render_sequence.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <variant>

#include "cli/cli.h"
#include "cli/load_scene.h"
#include "cli/render_outputs.h"
#include "cli/resume_state.h"
#include "cli/scene_files.h"
#include "pvol/error.h"
#include "pvol/math/rng.h"

namespace pvol::cli {
namespace {

/// The names of all outputs that options have.
template <class Options>
auto outputs_of(Options& o) {
  std::vector files{&o.output, &o.png, &o.deep};
  if (o.stats != "-") files.push_back(&o.stats);
  return files;
}

}  // namespace

formats::SceneFile scene_of(const RenderOptionsGiven& o) {
  const StageLine stage("reading " + o.input.filename().string(), o.common.quiet);
  formats::SceneFile file = read_scene(o.input, o.sets);
  if (!o.grid.grid.empty()) file.volumes.front().grid = o.grid.grid;
  cli::apply(o.options, formats::render_keys(file));
  file.scene.options.count = !o.stats.empty();
  file.scene.options.deep = !o.deep.empty();
  return file;
}

std::uint64_t seed_of_frame(std::uint64_t seed, int frame) {
  // Mixed twice, so that frame 2 of seed 1 is not frame 1 of seed 2.
  return mix64(seed + mix64(std::uint64_t(frame))) >> 1;
}

RenderOptionsGiven options_of_frame(const RenderOptionsGiven& o, int frame) {
  RenderOptionsGiven one = o;
  one.input = file_of_frame(o.input, frame);
  for (std::filesystem::path* file : outputs_of(one)) *file = file_of_frame(*file, frame);
  return one;
}

formats::SceneFile scene_of_frame(const RenderOptionsGiven& o, int frame) {
  formats::SceneFile scene = scene_of(options_of_frame(o, frame));
  for (formats::SceneVolume& v : scene.volumes) v.file = file_of_frame(v.file, frame);
  auto* sky = std::get_if<ImageSky>(&scene.scene.environment);
  if (sky) sky->file = file_of_frame(sky->file, frame).string();
  scene.scene.options.seed = seed_of_frame(scene.scene.options.seed, frame);
  return scene;
}

void check_sequence(const RenderOptionsGiven& o) {
  if (!has_pattern(o.input)) require_pattern(files_of(scene_of(o)));
  if (o.print_scene && o.frames.now().size() > 1) {
    throw UsageError("--print-scene prints one scene; choose its frame with --frame N");
  }
  for (const std::filesystem::path* file : outputs_of(o)) require_output_pattern(o.frames, *file);
}

bool is_rendered(const RenderOptionsGiven& of_frame) {
  if (of_frame.print_scene) return false;
  const Outputs out = choose_outputs(of_frame);
  return all_there(of_frame, out) && (out.exr.empty() || !is_unfinished(of_frame, out.exr));
}

bool check_scenes(const RenderOptionsGiven& o, const std::vector<int>& frames, int reference) {
  bool open = false;
  std::vector<FrameFile> needed;
  const auto check = [&](int frame) {
    const RenderOptionsGiven one = options_of_frame(o, frame);
    needed.push_back({frame, one.input});
    if (!std::filesystem::exists(one.input)) return;
    const formats::SceneFile scene = scene_of_frame(o, frame);
    for (const auto& file : files_of(scene)) needed.push_back({frame, file});
    if (!choose_outputs(one).exr.empty()) check_layout(one, scene.scene);
    open = open || !open_choices(scene).empty();
  };
  for (const int frame : frames) check(frame);
  const bool among = std::find(frames.begin(), frames.end(), reference) != frames.end();
  if (open && !among) check(reference);
  require_files(needed);
  return open;
}

std::string open_choices(const formats::SceneFile& scene) {
  std::vector<std::string> open;
  if (std::ranges::any_of(scene.volumes, [](const auto& v) { return !v.has_extinction; })) {
    open.emplace_back("extinction");
  }
  if (std::ranges::any_of(scene.volumes,
                          [](const auto& v) { return v.fire && !v.has_intensity; })) {
    open.emplace_back("the fire's intensity");
  }
  if (!scene.has_camera) open.emplace_back("camera");
  return fmt::format("{}", fmt::join(open, " and "));
}

namespace {

/// A fire's intensity, or all of one that nobody described.
void lock_fire(formats::SceneVolume& v, const formats::SceneVolume& chosen) {
  if (!chosen.fire || v.has_intensity) return;
  if (v.fire) {
    v.fire->intensity = chosen.fire->intensity;
  } else {
    v.fire = chosen.fire;
    v.grid = chosen.grid;
  }
  v.has_intensity = true;
}

}  // namespace

void lock(formats::SceneFile& scene, const formats::SceneFile& chosen) {
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    formats::SceneVolume& v = scene.volumes[i];
    if (i < chosen.volumes.size()) lock_fire(v, chosen.volumes[i]);
    if (v.has_extinction) continue;
    if (i >= chosen.volumes.size()) {
      throw Error(
          fmt::format("{}: volume {} has no extinction, and the frame that supplies it has "
                      "{} volumes; set its extinction",
                      v.file.string(), i + 1, chosen.volumes.size()));
    }
    v.medium.extinction = chosen.volumes[i].medium.extinction;
    v.has_extinction = true;
  }
  if (scene.has_camera) return;
  scene.scene.camera = chosen.scene.camera;
  scene.has_camera = true;
}

}  // namespace pvol::cli
