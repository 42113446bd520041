// pvol-render: a scene, or a cloud alone, into a picture, and sequences of them.
#include <fmt/format.h>

#include <iostream>
#include <optional>

#include "cli/film_samples.h"
#include "cli/filter_picture.h"
#include "cli/frame_job.h"
#include "cli/interrupt.h"
#include "cli/load_job.h"
#include "cli/picture_facts.h"
#include "cli/render_facts.h"
#include "cli/render_options.h"
#include "cli/render_outputs.h"
#include "cli/render_report.h"
#include "cli/resume_state.h"
#include "cli/sequence_summary.h"
#include "cli/shared_choices.h"
#include "cli/split_render.h"
#include "cli/timed_render.h"
#include "pvol/error.h"
#include "pvol/formats/scene_file.h"
#include "report/live_page.h"

namespace {

using namespace pvol;
using cli::FrameJob;
using cli::kRenderTool;
using cli::RenderJob;
using Options = cli::RenderOptionsGiven;
using cli::TimedRender;

// --- rendering ----------------------------------------------------------------------------------

/// Shows the picture so far. A render that is worth hours does not end for a page: whether it went
/// well.
bool show_live(const FrameJob& frame, const RenderJob& job, const Film& film,
               report::LivePage& live) {
  try {
    const std::uint64_t samples = cli::count_samples(film);
    live.show(fmt::format("{:.4g} samples per pixel, {}",
                          double(samples) / double(film.pixels.size()), cli::noise_text(film)),
              [&] { cli::save_png(frame.options, frame.outputs.png, job, film); });
    return true;
  } catch (const Error& e) {
    cli::print_warnings(kRenderTool,
                        {std::string(e.what()) + "; rendering continues without --live"});
    return false;
  }
}

/// Filters the picture. Where that is interrupted, or the render was and has too few samples for
/// it, the picture is saved as it is.
std::optional<cli::FilteredPicture> filter(const FrameJob& frame, const RenderJob& job,
                                           const RenderResult& result) {
  const cli::StageLine stage("filtering", frame.options.common.quiet);
  try {
    // A render that was interrupted is filtered to the end: only the filter itself is interrupted.
    return cli::filter_picture(result.film, job.file.scene.options,
                               [&] { return result.complete && cli::interrupted(); });
  } catch (const Error& e) {
    if (result.complete && !cli::interrupted()) throw;
    cli::print_warnings(kRenderTool, {std::string(e.what()) + "; the picture is saved unfiltered"});
    return std::nullopt;
  }
}

/// Whether all samples of the whole picture are there. Parts are filtered when they are merged.
bool is_whole(const RenderJob& job, const TimedRender& t) {
  return t.result.complete && job.file.scene.options.part_end == 0;
}

void end_live(report::LivePage& live, const TimedRender& t) {
  try {
    live.end(fmt::format("{}: {} samples in {}", t.result.complete ? "done" : "interrupted",
                         cli::readable_count(t.samples), cli::readable_seconds(t.wall_seconds)));
  } catch (const Error& e) {  // the picture is saved
    cli::print_warnings(kRenderTool, {e.what()});
  }
}

/// Renders what the film that there is already lacks, and filters the picture.
TimedRender render(const FrameJob& frame, const RenderJob& job, cli::ResumeState begun,
                   report::LivePage* page) {
  const Options& o = frame.options;
  const auto show = [&](const Film& film) {
    if (page && !show_live(frame, job, film, *page)) page = nullptr;
  };
  TimedRender t = begun.complete ? cli::already_rendered(std::move(begun.film))
                                 : cli::render_timed(frame, job, std::move(begun.film), show);
  if (t.samples == 0) throw Error("interrupted before the first sample; nothing is saved");
  if (o.denoise && (is_whole(job, t) || frame.outputs.exr.empty())) {
    t.filtered = filter(frame, job, t.result);
  }
  return t;
}

/// Renders, filters and saves. Throws Error where that is interrupted, after saving what there is.
void render_and_save(const FrameJob& frame, const RenderJob& job, cli::ResumeState begun,
                     cli::FrameOutcome& outcome) {
  std::optional<report::LivePage> live;
  if (frame.options.live) live.emplace(frame.outputs.png);
  const cli::SavesOnInterrupt saves;
  const TimedRender t = render(frame, job, std::move(begun), live ? &*live : nullptr);
  cli::save(frame, job, t);
  if (live) end_live(*live, t);
  outcome.wall_seconds = t.wall_seconds, outcome.cpu_seconds = t.cpu_seconds;
  outcome.noise = pixel_noise(t.film());
  if (t.result.complete && (!job.denoise || !is_whole(job, t) || t.filtered)) {
    outcome.state = cli::FrameState::rendered;
    return;
  }
  const bool resumable = !frame.outputs.exr.empty() && frame.outputs.deep.empty();
  throw Error("interrupted after " + cli::progress_text(t) +
              " samples; the picture so far is saved" +
              (resumable ? ", and --resume continues it" : ""));
}

// --- frames -------------------------------------------------------------------------------------

/// Notes that an earlier run left all that is asked for. `label` goes in front of the file's name.
void tell_finished(const FrameJob& frame, const std::string& label, cli::FrameOutcome& outcome) {
  outcome.state = cli::FrameState::finished;
  if (frame.options.common.quiet) return;
  std::cerr << kRenderTool << ": " << label << frame.outputs.exr.string() << " is finished\n";
}

void tell_begun(const FrameJob& frame, const RenderJob& job, const Film& begun) {
  if (frame.options.common.quiet) return;
  if (frame.prints_facts) cli::print_facts(job);
  if (begun.pixels.empty()) return;
  const auto& from = frame.options.pilot.empty() ? frame.outputs.exr : frame.options.pilot;
  std::cerr << kRenderTool << ": resuming with " << cli::readable_count(cli::count_samples(begun))
            << " samples from " << from.string() << '\n';
}

/// All of one job, whose clouds are freed at the end. `chosen` has what its scene leaves open.
void do_frame(FrameJob& frame, const std::optional<formats::SceneFile>& chosen,
              cli::FrameOutcome& outcome) {
  if (chosen) cli::lock(frame.scene, *chosen);
  cli::print_warnings(kRenderTool, frame.warnings);
  if (cli::is_finished(frame)) {
    tell_finished(frame, frame.in_sequence->label + ": ", outcome);
    return;
  }
  formats::use_exr_threads(frame.scene.scene.options.threads);
  RenderJob job = cli::load(frame);
  cli::make_plan(frame, job);
  if (frame.options.print_scene) {
    std::cout << formats::to_toml(job.file);
    return;
  }
  if (!frame.outputs.exr.empty()) cli::check_layout(frame.options, job.file.scene);
  cli::ResumeState begun = cli::find_resume_state(frame, job);
  if (begun.finished) {
    tell_finished(frame, "", outcome);
    return;
  }
  tell_begun(frame, job, begun.film);
  render_and_save(frame, job, std::move(begun), outcome);
}

int do_frames(const Options& o, cli::FrameJobs work) {
  const std::optional<formats::SceneFile> chosen = cli::choose_for_all(work);
  std::vector<int> frames;
  std::vector<cli::FrameOutcome> outcomes;
  for (const FrameJob& job : work.jobs) {
    frames.push_back(job.in_sequence->number);
    outcomes.push_back({.frame = frames.back()});
  }
  const cli::SequenceTool tool{kRenderTool, o.common.quiet, true};
  const int code = cli::for_each_frame(tool, frames, [&](std::size_t i) {
    outcomes[i].state = cli::FrameState::failed;
    do_frame(work.jobs[i], chosen, outcomes[i]);
    return cli::kSuccess;
  });
  if (!o.summary.empty()) cli::write_text(o.summary, cli::summary_json(outcomes));
  if (frames.size() > 1 && !o.common.quiet) std::cerr << cli::summary_text(outcomes);
  return code;
}

// --- the tool -----------------------------------------------------------------------------------

/// Prints the commands that render the picture, or all frames, in parts.
void print_split(const Options& o) {
  const FrameJob frame = cli::resolve_split(o);
  RenderJob job = cli::load(frame);
  cli::make_plan(frame, job);
  const cli::SplitText split = cli::split_text(o, job.plan);
  std::cout << split.commands;
  if (!o.common.quiet) std::cerr << kRenderTool << ": " << split.summary << '\n';
}

int run(const Options& o) {
  cli::check_frames(o.frames);
  cli::check_split(o);
  if (o.split.parts) {
    print_split(o);
    return cli::kSuccess;
  }
  cli::FrameJobs work = cli::resolve_jobs(o);
  if (work.jobs.empty()) return cli::kSuccess;
  if (o.frames.any()) return do_frames(o, std::move(work));
  cli::FrameOutcome outcome;
  do_frame(work.jobs.front(), std::nullopt, outcome);
  return cli::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  cli::watch_signals(kRenderTool);
  return cli::run_guarded(kRenderTool, [&] {
    Options options;
    const auto code = cli::read_command_line(argc, argv, options);
    return code ? *code : run(options);
  });
}
