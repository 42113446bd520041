#include "cli/load_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "cli/cli.h"
#include "cli/filter_picture.h"
#include "cli/load_scene.h"
#include "cli/missing_file.h"
#include "cli/picture_key.h"
#include "cli/scene_clouds.h"
#include "cli/stage_files.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/memory.h"
#include "pvol/render/film.h"
#include "pvol/shell/certificate.h"
#include "pvol/volume/facts.h"

namespace pvol::cli {
namespace {

/// Loads a volume, choosing an extinction for its medium where there is none. `key` is what to set
/// for another.
std::shared_ptr<const formats::Cloud> load_volume(const RenderOptionsGiven& o, SceneClouds& clouds,
                                                  const std::string& key,
                                                  formats::SceneVolume& volume) {
  auto cloud = clouds.load(volume);
  if (!volume.has_extinction && !cloud->pyramid.empty()) {
    volume.medium.extinction = choose_extinction(*cloud, volume.first_place(),
                                                 chosen_thickness(volume), volume.density_map);
    volume.has_extinction = true;
    if (!o.common.quiet) {
      std::cerr << kRenderTool << ": no extinction is set; chose "
                << readable(volume.medium.extinction) << " per world unit (change it with --set "
                << key << "=X)\n";
    }
  }
  return cloud;
}

/// Names bounds that do not hold, where trackers with weights make up for them.
void warn_of_bounds(const std::filesystem::path& file, const Volume& volume) {
  const BoundsExcess& e = volume.density.excess;
  if (e.nodes == 0) return;
  print_warnings(
      kRenderTool,
      {fmt::format("{}: the bounds of {} cubes do not hold; the worst majorant is {} times "
                   "too low, at ({:.0f}, {:.0f}, {:.0f}). The tracker's weights compensate "
                   "for it with more noise; fit the cloud again",
                   file.string(), e.nodes, readable(e.factor), e.worst.lo.x, e.worst.lo.y,
                   e.worst.lo.z)});
}

/// Makes the clouds of a job's scene ready, and chooses the extinctions and the camera that it
/// leaves open.
void load_scene(const RenderOptionsGiven& o, RenderJob& job) {
  load_sky(kRenderTool, job.file);
  load_surfaces(job.file);
  Scene& scene = job.file.scene;
  SceneClouds clouds({kRenderTool, o.common.quiet}, o.grid.strict, job.file);
  for (formats::SceneVolume& v : job.file.volumes) {
    const std::size_t number = job.volumes.size() + 1;
    const std::string key =
        number == 1 ? "medium.extinction" : fmt::format("volume[{}].medium.extinction", number);
    FileState state = state_of(v.file);
    const auto loaded = load_volume(o, clouds, key, v);
    const formats::Cloud& cloud = *loaded;
    job.volumes.push_back(naming(v.file, [&] {
      const StageLine stage("preparing " + v.file.filename().string(), o.common.quiet);
      return make_volume(cloud, v, scene);
    }));
    warn_of_bounds(v.file, job.volumes.back());
    job.reports.push_back({v.file, cloud.metadata.quantisation, cloud.metadata.quantisation_error});
    job.facts.push_back(describe(job.volumes.back(), describe(cloud, v)));
    if (scene.options.shells != ShellUse::off) require_proof(v.file, cloud);
    if (!cloud.forget_pages) continue;
    cloud.forget_pages();  // what was read once to be checked
    job.mapped.push_back(std::move(state));
  }
  if (!job.file.has_camera) {
    scene.camera = frame_all(job.volumes, scene);
    job.file.has_camera = true;
  }
}

/// Refuses a picture that cannot fit, before its clouds are read: 40 000 million pixels are a slip.
void require_film_memory(const RenderOptions& o) {
  const auto width = std::uint64_t(o.crop_width ? o.crop_width : o.width - o.crop_x);
  const auto height = std::uint64_t(o.crop_height ? o.crop_height : o.height - o.crop_y);
  formats::require_memory(
      width * height *
          (sizeof(PixelSums) +
           (o.samples > kMostPacked ? sizeof(ExactSums) : sizeof(PixelRemainders))),
      fmt::format("a picture of {} x {} pixels (--crop renders a part)", width, height));
}

}  // namespace

RenderJob load(const FrameJob& frame) {
  const RenderOptionsGiven& o = frame.options;
  RenderJob job;
  job.input = o.input;
  job.sets = o.sets;
  job.frame = frame.in_sequence;
  job.file = frame.scene;
  job.denoise = o.denoise;
  if (!o.print_scene && !o.split.parts) require_film_memory(job.file.scene.options);
  const StagedFiles staged = use_local_copies(kRenderTool, local_folder(o.local_copies), job.file);
  try {
    load_scene(o, job);
  } catch (const Error& e) {
    rethrow_with_place(e, o.input, job.file);
  }
  if (!o.print_scene && !o.split.parts) job.key = picture_key(job.file);
  restore_names(staged, job.file);
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    job.reports[i].file = job.file.volumes[i].file;
    job.volumes[i].name = job.reports[i].file.string();
  }
  return job;
}

void make_plan(const FrameJob& frame, RenderJob& job) {
  const RenderOptionsGiven& o = frame.options;
  Scene& scene = job.file.scene;
  StageLine stage("planning", o.common.quiet);
  job.chose_transmittance = scene.options.transmittance == Transmittance::automatic;
  job.plan =
      plan(job.volumes, o.denoise ? with_needs_of_filter(scene) : scene,
           {.facts = job.facts, .force = o.force || o.print_scene, .forecast = !o.print_scene});
  stage.erase();
  print_warnings(kRenderTool, job.plan.warnings);
  const bool any_shell = std::any_of(job.volumes.begin(), job.volumes.end(),
                                     [](const Volume& v) { return v.shell != nullptr; });
  if (scene.options.shells == ShellUse::on && !any_shell) {
    print_warnings(kRenderTool, {"--shells on: no volume has a shell; fit one with pvol-fit CLOUD "
                                 "--shells auto"});
  }
  if (!o.print_scene) scene.options.transmittance = job.plan.scene.options.transmittance;
}

}  // namespace pvol::cli
