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
#include "pvol/volume/emitter.h"

namespace pvol::cli {

namespace {

/// With the fields of its file where the scene names none and something may be open by them; a file
/// that cannot be read fails later, with its frame.
formats::SceneVolume with_fields(formats::SceneVolume v) {
  if (v.names_density() || (v.fire && v.has_extinction)) return v;
  try {
    (void)formats::bind_fields(v, formats::grids_of(v.file));
  } catch (const Error&) {
  }
  return v;
}

}  // namespace

OpenChoices open_choices(const formats::SceneFile& scene) {
  OpenChoices open;
  open.camera = !scene.has_camera;
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    const formats::SceneVolume& v = scene.volumes[i];
    const formats::SceneVolume bound = with_fields(v);
    if (!v.has_extinction && bound.grid != formats::kNoGrid) open.extinctions.push_back(i);
    if (bound.fire && !describes_fire_color(v)) open.colors.push_back(i);
    if (bound.fire && !v.has_intensity) open.intensities.push_back(i);
  }
  return open;
}

namespace {

/// "extinction", "camera", "extinction and camera" and the like.
std::string in_words(const OpenChoices& open) {
  std::vector<std::string> all;
  if (!open.extinctions.empty()) all.emplace_back("extinction");
  if (!open.colors.empty()) all.emplace_back("the fire's colour");
  if (!open.intensities.empty()) all.emplace_back("the fire's intensity");
  if (open.camera) all.emplace_back("camera");
  if (all.size() < 2) return fmt::format("{}", fmt::join(all, ""));
  const std::string last = std::move(all.back());
  all.pop_back();
  return fmt::format("{} and {}", fmt::join(all, ", "), last);
}

/// Throws Error where there is nothing that extinction or camera could be chosen for. A fire alone
/// needs no density.
void require_density(const FrameJobs& work, const RenderJob& loaded) {
  const FrameJob& reference = *work.reference;
  const std::size_t volumes = loaded.volumes.size();
  const auto is_empty = [&](std::size_t i) {
    return i < volumes && loaded.volumes[i].density.world_box.empty();
  };
  std::size_t empty = 0;
  for (std::size_t i = 0; i < volumes; ++i) {
    if (is_empty(i) && loaded.file.volumes[i].grid != formats::kNoGrid) ++empty;
  }
  const auto lacks_it = [&](const FrameJob& job) {
    return std::ranges::any_of(job.open.extinctions, is_empty);
  };
  const bool chooses = empty < volumes && !lacks_it(reference);
  const auto lacking = std::ranges::find_if(work.jobs, lacks_it);
  if (chooses && lacking == work.jobs.end()) return;
  if (chooses) {
    const int frame = lacking->in_sequence->number;
    throw Error(fmt::format(
        "frame {} has no density, so the extinction cannot be chosen for frame {}, which "
        "has one; choose by that frame with --lock-frame {}",
        reference.in_sequence->number, frame, frame));
  }
  throw Error(
      fmt::format("frame {}: the density is 0 everywhere, so extinction and camera "
                  "cannot be chosen; name another frame with --lock-frame N",
                  reference.in_sequence->number));
}

/// Throws Error where a frame takes something of a fire from the reference, which does not burn.
void require_fires(const FrameJobs& work, const RenderJob& loaded) {
  const auto burns = [&](std::size_t volume) {
    if (volume >= loaded.volumes.size()) return false;
    const auto& fire = loaded.volumes[volume].fire;
    return fire != nullptr && !fire->field.world_box.empty();
  };
  const int reference = work.reference->in_sequence->number;
  for (const FrameJob& job : work.jobs) {
    for (const auto* const open : {&job.open.colors, &job.open.intensities}) {
      if (std::ranges::all_of(*open, burns)) continue;
      const int frame = job.in_sequence->number;
      throw Error(fmt::format(
          "frame {} does not burn, so the fire's colour and intensity cannot be chosen for it; "
          "name a frame that burns with --lock-frame N{}",
          reference,
          frame == reference ? "" : fmt::format(": frame {} has a fire's grids", frame)));
    }
  }
}

}  // namespace

std::optional<formats::SceneFile> choose_for_all(const FrameJobs& work) {
  if (!work.reference) {
    const FrameJob& first = work.jobs.front();
    if (first.open.any()) {
      print_warnings(
          kRenderTool,
          {fmt::format(
              "no value is set for {}; chosen for frame {} alone. For pictures that match, "
              "give all frames as well, --frames A-B, or the same --lock-frame N to each",
              in_words(first.open), first.in_sequence->number)});
    }
    return std::nullopt;
  }
  const FrameJob& reference = *work.reference;
  RenderJob loaded = load(reference);
  require_density(work, loaded);
  require_fires(work, loaded);
  if (!reference.options.common.quiet) {
    std::cerr << kRenderTool << ": no value is set for " << in_words(reference.open)
              << "; chosen for frame " << reference.in_sequence->number
              << ", and used for all frames\n";
  }
  return std::move(loaded.file);
}

namespace {

/// What a fire lacks, or all of one that nobody described.
void lock_fire(formats::SceneVolume& v, const formats::SceneVolume& chosen) {
  if (!chosen.fire) return;
  if (!v.fire) {
    const std::vector<formats::GridEntry> grids = formats::grids_of(v.file);
    if (formats::lacks_grid(*chosen.fire, grids)) return;
    v.fire = chosen.fire, v.has_intensity = true;
    // A file may have smoke where that of the reference has a fire alone.
    if (chosen.grid != formats::kNoGrid || formats::lacks_density(grids)) v.grid = chosen.grid;
    return;
  }
  if (!describes_fire_color(v)) v.fire->kelvin = chosen.fire->kelvin;
  if (!v.has_intensity) v.fire->intensity = chosen.fire->intensity;
  v.has_intensity = true;
}

/// A cloud by itself that burns in the reference frame is shown by night in all, whether it burns
/// in them or not.
void lock_night(formats::SceneFile& scene, const formats::SceneFile& chosen) {
  const formats::SceneVolume& burning = chosen.volumes.front();
  if (!burning.shows_fire) return;
  formats::SceneVolume& v = scene.volumes.front();
  v.shows_fire = true;
  v.medium.components = burning.medium.components;
  if (!std::holds_alternative<ConstantSky>(chosen.scene.environment)) return;
  scene.scene.environment = chosen.scene.environment;
  scene.scene.lights = chosen.scene.lights;
}

}  // namespace

void lock(formats::SceneFile& scene, const formats::SceneFile& chosen) {
  lock_night(scene, chosen);
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
