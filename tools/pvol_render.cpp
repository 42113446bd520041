// pvol-render: a scene, or a cloud alone, into a picture.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "cli/filter_picture.h"
#include "cli/interrupt.h"
#include "cli/load_scene.h"
#include "cli/picture_key.h"
#include "cli/render_facts.h"
#include "cli/render_options.h"
#include "cli/render_outputs.h"
#include "cli/render_report.h"
#include "cli/render_sequence.h"
#include "cli/resume_state.h"
#include "cli/scene_clouds.h"
#include "cli/scene_files.h"
#include "cli/sequence_summary.h"
#include "cli/split_render.h"
#include "cli/stage_files.h"
#include "cli/timed_render.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/scene_volume.h"
#include "pvol/shell/certificate.h"
#include "pvol/volume/facts.h"
#include "report/live_page.h"

namespace {

using namespace pvol;
using cli::RenderJob;
using Options = cli::RenderOptionsGiven;
using cli::TimedRender;

constexpr const char* kTool = "pvol-render";

// --- the scene ----------------------------------------------------------------------------------

/// Loads a volume, choosing an extinction for its medium where there is none. `key` is what to set
/// for another.
std::shared_ptr<const formats::Cloud> load_volume(const Options& o, cli::SceneClouds& clouds,
                                                  const std::string& key,
                                                  formats::SceneVolume& volume) {
  auto cloud = clouds.load(volume);
  if (!volume.has_extinction && !cloud->pyramid.empty()) {
    volume.medium.extinction = cli::choose_extinction(*cloud, volume.first_place(),
                                                      cli::kChosenThickness, volume.density_map);
    volume.has_extinction = true;
    if (!o.common.quiet) {
      std::cerr << kTool << ": no extinction is set; chose "
                << cli::readable(volume.medium.extinction)
                << " per world unit (change it with --set " << key << "=X)\n";
    }
  }
  return cloud;
}

/// Names bounds that do not hold, where trackers with weights make up for them.
void warn_of_bounds(const std::filesystem::path& file, const Volume& volume) {
  const BoundsExcess& e = volume.density.excess;
  if (e.nodes == 0) return;
  cli::print_warnings(
      kTool, {fmt::format("{}: the bounds of {} cubes do not hold; the worst majorant is {} times "
                          "too low, at ({:.0f}, {:.0f}, {:.0f}). The tracker's weights compensate "
                          "for it with more noise; fit the cloud again",
                          file.string(), e.nodes, cli::readable(e.factor), e.worst.lo.x,
                          e.worst.lo.y, e.worst.lo.z)});
}

/// Makes the clouds of a scene ready, and chooses extinctions and camera where it has none.
RenderJob load_as_named(const Options& o, formats::SceneFile file) {
  RenderJob job;
  job.input = o.input;
  job.sets = o.sets;
  job.file = std::move(file);
  cli::load_sky(job.file);
  cli::load_surfaces(job.file);
  Scene& scene = job.file.scene;
  cli::SceneClouds clouds({kTool, o.common.quiet}, o.grid.strict, job.file);
  for (formats::SceneVolume& v : job.file.volumes) {
    const std::size_t number = job.volumes.size() + 1;
    const std::string key =
        number == 1 ? "medium.extinction" : fmt::format("volume[{}].medium.extinction", number);
    const auto loaded = load_volume(o, clouds, key, v);
    const formats::Cloud& cloud = *loaded;
    job.volumes.push_back(cli::naming(v.file, [&] {
      const cli::StageLine stage("preparing " + v.file.filename().string(), o.common.quiet);
      return cli::make_volume(cloud, v, scene);
    }));
    warn_of_bounds(v.file, job.volumes.back());
    job.reports.push_back({v.file, cloud.metadata.quantisation, cloud.metadata.quantisation_error});
    job.facts.push_back(describe(job.volumes.back(), cli::describe(cloud, v)));
    if (scene.options.shells != ShellUse::off) cli::require_proof(v.file, cloud);
  }
  if (!job.file.has_camera) {
    scene.camera = cli::frame_all(job.volumes, scene);
    job.file.has_camera = true;
  }
  return job;
}

/// The same from copies of the files on this machine, where the options want them.
RenderJob load(const Options& o, formats::SceneFile file) {
  const auto own = cli::use_local_copies(kTool, cli::local_folder(o.local_copies), file);
  RenderJob job = load_as_named(o, std::move(file));
  if (!o.print_scene && !o.split.parts) job.key = cli::picture_key(job.file);
  cli::restore_names(own, job.file);
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    job.reports[i].file = job.file.volumes[i].file;
    job.volumes[i].name = job.reports[i].file.string();
  }
  return job;
}

void make_plan(const Options& o, RenderJob& job) {
  Scene& scene = job.file.scene;
  cli::StageLine stage("planning", o.common.quiet);
  job.chose_transmittance = scene.options.transmittance == Transmittance::automatic;
  job.plan =
      plan(job.volumes, o.denoise ? cli::with_needs_of_filter(scene) : scene,
           {.facts = job.facts, .force = o.force || o.print_scene, .forecast = !o.print_scene});
  stage.erase();
  cli::print_warnings(kTool, job.plan.warnings);
  const bool any_shell = std::any_of(job.volumes.begin(), job.volumes.end(),
                                     [](const Volume& v) { return v.shell != nullptr; });
  if (scene.options.shells == ShellUse::on && !any_shell) {
    cli::print_warnings(kTool, {"--shells on: no volume has a shell; fit one with pvol-fit CLOUD "
                                "--shells auto"});
  }
  if (!o.print_scene) scene.options.transmittance = job.plan.scene.options.transmittance;
}

// --- rendering ----------------------------------------------------------------------------------

/// Shows the picture so far. A render that is worth hours does not end for a page: whether it went
/// well.
bool show_live(const Options& o, const RenderJob& job, const std::filesystem::path& png,
               const Film& film, report::LivePage& live) {
  try {
    const std::uint64_t samples = cli::count_samples(film);
    live.show(fmt::format("{:.4g} samples per pixel, {}",
                          double(samples) / double(film.pixels.size()), cli::noise_text(film)),
              [&] { cli::save_png(o, png, job, film); });
    return true;
  } catch (const Error& e) {
    cli::print_warnings(kTool, {std::string(e.what()) + "; rendering continues without --live"});
    return false;
  }
}

/// Filters the picture. Where that is interrupted, or the render was and has too few samples for
/// it, the picture is saved as it is.
std::optional<cli::FilteredPicture> filter(const Options& o, const RenderJob& job,
                                           const RenderResult& result) {
  const cli::StageLine stage("filtering", o.common.quiet);
  try {
    // A render that was interrupted is filtered to the end: only the filter itself is interrupted.
    return cli::filter_picture(result.film, job.file.scene.options,
                               [&] { return result.complete && cli::interrupted(); });
  } catch (const Error& e) {
    if (result.complete && !cli::interrupted()) throw;
    cli::print_warnings(kTool, {std::string(e.what()) + "; the picture is saved unfiltered"});
    return std::nullopt;
  }
}

// --- the end ------------------------------------------------------------------------------------

void end_live(report::LivePage& live, const TimedRender& t) {
  try {
    live.end(fmt::format("{}: {} samples in {}", t.result.complete ? "done" : "interrupted",
                         cli::readable_count(t.samples), cli::readable_seconds(t.wall_seconds)));
  } catch (const Error& e) {  // the picture is saved
    cli::print_warnings(kTool, {e.what()});
  }
}

/// Prints facts about the clouds with `verbose`.
int render_and_save(const Options& o, const cli::Outputs& out, RenderJob job, bool verbose,
                    cli::FrameOutcome& outcome) {
  make_plan(o, job);
  if (o.print_scene) {
    std::cout << formats::to_toml(job.file);
    return cli::kSuccess;
  }
  if (!out.exr.empty()) cli::check_layout(o, job.file.scene);
  job.denoise = o.denoise;
  cli::ResumeState begun = cli::find_resume_state(o, out, job);
  if (begun.finished) {
    if (!o.common.quiet) std::cerr << kTool << ": " << out.exr.string() << " is finished\n";
    outcome.state = cli::FrameState::finished;
    return cli::kSuccess;
  }
  if (verbose && !o.common.quiet) cli::print_facts(job);
  if (!o.common.quiet && !begun.film.pixels.empty()) {
    std::cerr << kTool << ": resuming with " << cli::readable_count(cli::count_samples(begun.film))
              << " samples from " << (o.pilot.empty() ? out.exr : o.pilot).string() << '\n';
  }
  std::optional<report::LivePage> live;
  if (o.live) live.emplace(out.png);
  const cli::SavesOnInterrupt saves;
  formats::use_exr_threads(job.file.scene.options.threads);
  report::LivePage* page = live ? &*live : nullptr;
  const auto show = [&](const Film& film) {
    if (page && !show_live(o, job, out.png, film, *page)) page = nullptr;
  };
  TimedRender t = begun.complete ? cli::already_rendered(std::move(begun.film))
                                 : cli::render_timed(o, out, job, std::move(begun.film), show);
  if (t.samples == 0) throw Error("interrupted before the first sample; nothing is saved");
  // A whole is filtered when it is merged.
  const bool whole = t.result.complete && job.file.scene.options.part_end == 0;
  if (o.denoise && (whole || out.exr.empty())) t.filtered = filter(o, job, t.result);
  cli::save(o, out, job, t);
  if (live) end_live(*live, t);
  outcome.wall_seconds = t.wall_seconds, outcome.cpu_seconds = t.cpu_seconds;
  outcome.noise = relative_noise(t.film());
  if (t.result.complete && (!o.denoise || !whole || t.filtered)) {
    outcome.state = cli::FrameState::rendered;
    return cli::kSuccess;
  }
  throw Error("interrupted after " + cli::progress_text(t) +
              " samples; the picture so far is saved" +
              (out.exr.empty() || !out.deep.empty() ? "" : ", and --resume continues it"));
}

// --- sequences ----------------------------------------------------------------------------------

/// The scene of a frame with nothing left open, for all frames to take extinction and camera from.
formats::SceneFile choose(const Options& o, int frame) {
  const formats::SceneFile open = cli::scene_of_frame(o, frame);
  const std::string what = cli::open_choices(open);
  RenderJob job = load(cli::options_of_frame(o, frame), open);
  std::size_t empty = 0;
  bool chosen_for_nothing = false;
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    if (!job.volumes[i].density.world_box.empty()) continue;
    ++empty;
    chosen_for_nothing = chosen_for_nothing || !open.volumes[i].has_extinction;
  }
  if (chosen_for_nothing || empty == job.volumes.size()) {
    throw Error(
        fmt::format("frame {}: the density is 0 everywhere, so extinction and camera "
                    "cannot be chosen; name another frame with --lock-frame N",
                    frame));
  }
  if (!o.common.quiet) {
    std::cerr << kTool << ": no value is set for " << what << "; chosen for frame " << frame
              << ", and used for all frames\n";
  }
  return std::move(job.file);
}

int render_frames(const Options& o) {
  const cli::SequenceTool tool{kTool, o.common.quiet, true};
  cli::check_sequence(o);
  const std::vector<int> frames = cli::frames_to_do(
      tool, o.frames, [&](int f) { return cli::is_rendered(cli::options_of_frame(o, f)); });
  if (frames.empty()) return cli::kSuccess;
  const bool alone = o.frames.all().size() == 1 && !o.frames.lock_frame;
  const int reference = o.frames.lock_frame.value_or(o.frames.all().front());
  const bool open = cli::check_scenes(o, frames, reference);
  if (open && alone) {
    const std::string what = cli::open_choices(cli::scene_of_frame(o, reference));
    cli::print_warnings(
        kTool,
        {fmt::format("no value is set for {}; chosen for frame {} alone. For pictures that match, "
                     "give all frames as well, --frames A-B, or the same --lock-frame N to each",
                     what, reference)});
  }
  std::optional<formats::SceneFile> chosen;
  if (open && !alone) chosen = choose(o, reference);
  std::vector<cli::FrameOutcome> outcomes;
  for (const int frame : frames) outcomes.push_back({.frame = frame});
  std::size_t begun = 0;
  const int code = cli::for_each_frame(tool, frames, [&](int frame, const std::string& label) {
    cli::FrameOutcome& outcome = outcomes[begun++];
    outcome.state = cli::FrameState::failed;
    const Options one = cli::options_of_frame(o, frame);
    formats::SceneFile scene = cli::scene_of_frame(o, frame);
    const bool locked = !cli::open_choices(scene).empty();
    if (chosen) cli::lock(scene, *chosen);
    if (o.resume.value_or(true) && cli::is_finished(one, scene)) {
      outcome.state = cli::FrameState::finished;
      if (!o.common.quiet) {
        std::cerr << kTool << ": " << label << ": " << one.output.string() << " is finished\n";
      }
      return cli::kSuccess;
    }
    RenderJob job = load(one, std::move(scene));
    job.frame = {frame, locked ? std::optional(reference) : std::nullopt, label};
    return render_and_save(one, cli::choose_outputs(one), std::move(job), frame == frames.front(),
                           outcome);
  });
  if (!o.summary.empty()) cli::write_text(o.summary, cli::summary_json(outcomes));
  if (frames.size() > 1 && !o.common.quiet) std::cerr << cli::summary_text(outcomes);
  return code;
}

// --- parts --------------------------------------------------------------------------------------

/// Prints the commands that render the picture, or all frames, in parts.
int print_split(const Options& o) {
  const bool frames = o.frames.any();
  if (frames) cli::check_sequence(o);
  // All frames are cut alike: as the one that is read for their choices.
  const int reference = frames ? o.frames.lock_frame.value_or(o.frames.all().front()) : 0;
  RenderJob job = load(frames ? cli::options_of_frame(o, reference) : o,
                       frames ? cli::scene_of_frame(o, reference) : cli::scene_of(o));
  make_plan(o, job);
  const cli::SplitText split = cli::split_text(o, job.plan);
  std::cout << split.commands;
  if (!o.common.quiet) std::cerr << kTool << ": " << split.summary << '\n';
  return cli::kSuccess;
}

int run(const Options& o) {
  cli::check_frames(o.frames);
  cli::check_split(o);
  const cli::Outputs out = cli::choose_outputs(o);
  if (o.split.parts) return print_split(o);
  if (o.frames.any()) return render_frames(o);
  cli::refuse_pattern(o.input);
  formats::SceneFile scene = cli::scene_of(o);
  for (const auto& file : cli::files_of(scene)) cli::refuse_pattern(file);
  cli::FrameOutcome outcome;
  return render_and_save(o, out, load(o, std::move(scene)), true, outcome);
}

}  // namespace

int main(int argc, char** argv) {
  cli::watch_signals(kTool);
  Options options;
  if (const auto code = cli::read_command_line(argc, argv, options)) return *code;
  return cli::run_guarded(kTool, [&] { return run(options); });
}
