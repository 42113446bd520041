#include "cli/shared_choices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>

#include "cli/cli.h"
#include "cli/frame_job.h"
#include "cli/load_job.h"
#include "cli/load_scene.h"
#include "pvol/error.h"
#include "pvol/formats/field_names.h"

namespace pvol::cli {

namespace {

/// With the fields of its file where the scene names none and something may be open by them; a file
/// that cannot be read fails later, with its frame.
formats::SceneVolume with_fields(formats::SceneVolume v) {
  if (!v.grid.empty() || (v.fire && v.has_extinction)) return v;
  try {
    (void)formats::bind_fields(v, formats::grids_of(v.file));
  } catch (const Error&) {
  }
  return v;
}

}  // namespace

std::string open_choices(const formats::SceneFile& scene) {
  bool extinction = false, color = false, intensity = false;
  for (const formats::SceneVolume& v : scene.volumes) {
    const formats::SceneVolume bound = with_fields(v);
    extinction = extinction || (!v.has_extinction && bound.grid != formats::kNoGrid);
    color = color || (bound.fire && !describes_fire_color(v));
    intensity = intensity || (bound.fire && !v.has_intensity);
  }
  std::vector<std::string> open;
  if (extinction) open.emplace_back("extinction");
  if (color) open.emplace_back("the fire's colour");
  if (intensity) open.emplace_back("the fire's intensity");
  if (!scene.has_camera) open.emplace_back("camera");
  return fmt::format("{}", fmt::join(open, " and "));
}

namespace {

/// Throws Error where there is nothing that extinction or camera could be chosen for. A fire alone
/// needs no density.
void require_density(const FrameJob& reference, const RenderJob& loaded) {
  std::size_t empty = 0;
  bool chosen_for_nothing = false;
  for (std::size_t i = 0; i < loaded.volumes.size(); ++i) {
    if (loaded.file.volumes[i].grid == formats::kNoGrid) continue;
    if (!loaded.volumes[i].density.world_box.empty()) continue;
    ++empty;
    chosen_for_nothing = chosen_for_nothing || !reference.scene.volumes[i].has_extinction;
  }
  if (!chosen_for_nothing && empty < loaded.volumes.size()) return;
  throw Error(
      fmt::format("frame {}: the density is 0 everywhere, so extinction and camera "
                  "cannot be chosen; name another frame with --lock-frame N",
                  reference.in_sequence->number));
}

}  // namespace

std::optional<formats::SceneFile> choose_for_all(const FrameJobs& work) {
  if (!work.reference) {
    const FrameJob& first = work.jobs.front();
    if (!first.open.empty()) {
      print_warnings(
          kRenderTool,
          {fmt::format(
              "no value is set for {}; chosen for frame {} alone. For pictures that match, "
              "give all frames as well, --frames A-B, or the same --lock-frame N to each",
              first.open, first.in_sequence->number)});
    }
    return std::nullopt;
  }
  const FrameJob& reference = *work.reference;
  RenderJob loaded = load(reference);
  require_density(reference, loaded);
  if (!reference.options.common.quiet) {
    std::cerr << kRenderTool << ": no value is set for " << reference.open << "; chosen for frame "
              << reference.in_sequence->number << ", and used for all frames\n";
  }
  return std::move(loaded.file);
}

namespace {

/// What a fire lacks, or all of one that nobody described.
void lock_fire(formats::SceneVolume& v, const formats::SceneVolume& chosen) {
  if (!chosen.fire) return;
  if (!v.fire) {
    v.fire = chosen.fire;
    v.grid = chosen.grid;
    v.has_intensity = true;
    return;
  }
  if (!describes_fire_color(v)) v.fire->kelvin = chosen.fire->kelvin;
  if (!v.has_intensity) v.fire->intensity = chosen.fire->intensity;
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
