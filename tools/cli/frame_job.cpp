#include "cli/frame_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "cli/cli.h"
#include "cli/filter_picture.h"
#include "cli/resume_state.h"
#include "cli/scene_line.h"
#include "cli/sequence.h"
#include "cli/view_line.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/scene_files.h"
#include "pvol/math/rng.h"

namespace pvol::cli {
namespace {

/// The names of all outputs that options have.
template <class GivenOptions>
auto output_names(GivenOptions& o) {
  std::vector files{&o.output, &o.png, &o.deep};
  if (o.stats != "-") files.push_back(&o.stats);
  return files;
}

formats::SceneFile parse_scene(const RenderOptionsGiven& o) {
  const StageLine stage("reading " + o.input.filename().string(), o.common.quiet);
  formats::SceneFile file = read_scene_as_set(o.input, o.sets, o.flags_of_sets, o.grid.grid);
  apply_options(o.options, file);
  if (o.denoise_layers) file.scene.options.aovs.add(layers_for_sequence());
  file.scene.options.count = !o.stats.empty();
  file.scene.options.deep = !o.deep.empty();
  return file;
}

/// Noise that stays while the picture moves looks like a dirty window, so each frame has random
/// numbers of its own. Below 2^63, for scenes to hold it.
std::uint64_t seed_of_frame(std::uint64_t seed, int frame) {
  // Mixed twice, so that frame 2 of seed 1 is not frame 1 of seed 2.
  return mix64(seed + mix64(std::uint64_t(frame))) >> 1;
}

// --- frames -------------------------------------------------------------------------------------

/// What the frames of a sequence have in common.
struct SequenceGiven {
  RenderOptionsGiven options;  ///< without the frames, of which each job would keep a list
  std::size_t frames_of_run = 0;
  bool alone = false;  ///< the frame chooses for itself
  int reference = 0;
  std::optional<formats::SceneFile> scene{};  ///< of all frames, where the input has no pattern
};

/// Throws UsageError for names without a place for the frame's number, and for what goes with one
/// picture only.
SequenceGiven common_to_frames(const RenderOptionsGiven& o) {
  const FramesGiven& frames = o.frames;
  (void)choose_outputs(o);
  SequenceGiven given{.options = o,
                      .frames_of_run = frames.now().size(),
                      .alone = frames.all().size() == 1 && !frames.lock_frame,
                      .reference = frames.lock_frame.value_or(frames.all().front())};
  given.options.frames = {};
  if (!has_pattern(o.input)) {
    given.scene = parse_scene(o);
    require_pattern(files_of(*given.scene));
  }
  if (o.print_scene && given.frames_of_run > 1) {
    throw UsageError("--print-scene prints one scene; choose its frame with --frame N");
  }
  for (const std::filesystem::path* file : output_names(o)) require_output_pattern(frames, *file);
  return given;
}

/// A frame's job without its scene.
FrameJob name_frame(const SequenceGiven& given, int frame) {
  FrameJob job{.options = given.options, .frames_of_run = given.frames_of_run};
  job.in_sequence.emplace().number = frame;
  RenderOptionsGiven& o = job.options;
  o.frames.frame = frame;
  o.input = file_of_frame(o.input, frame);
  for (std::filesystem::path* file : output_names(o)) *file = file_of_frame(*file, frame);
  job.outputs = choose_outputs(o);
  return job;
}

/// Parses the scene of a frame, or takes that of all frames, and names its files and its seed.
void add_scene(const SequenceGiven& given, FrameJob& job) {
  const int frame = job.in_sequence->number;
  job.scene = given.scene ? *given.scene : parse_scene(job.options);
  visit_files(job.scene, [&](auto& name) { name = file_of_frame(name, frame).string(); });
  std::uint64_t& seed = job.scene.scene.options.seed;
  seed = seed_of_frame(seed, frame);
}

/// Whether the file of a volume exists and has no grids for its fire.
bool is_out(const formats::SceneVolume& v) {
  return v.fire && std::filesystem::exists(v.file) &&
         formats::lacks_grid(*v.fire, formats::grids_of(v.file));
}

/// Which volumes burn in any frame of a sequence, or in its reference. Each is looked for once.
class Burning {
 public:
  Burning(const SequenceGiven& given, std::vector<int> frames)
      : given_(given), frames_(std::move(frames)) {
    frames_.push_back(given.reference);
  }

  [[nodiscard]] bool has(std::size_t volume) {
    const auto [known, is_new] = known_.try_emplace(volume);
    if (is_new) {
      known->second = std::ranges::any_of(frames_, [&](int f) { return burns(volume, f); });
    }
    return known->second;
  }

 private:
  [[nodiscard]] bool burns(std::size_t volume, int frame) const {
    FrameJob job = name_frame(given_, frame);
    if (!std::filesystem::exists(job.options.input)) return false;
    add_scene(given_, job);
    if (volume >= job.scene.volumes.size()) return false;
    const formats::SceneVolume& v = job.scene.volumes[volume];
    return v.fire && std::filesystem::exists(v.file) && !is_out(v);
  }

  const SequenceGiven& given_;
  std::vector<int> frames_;
  std::map<std::size_t, bool> known_;
};

/// Puts out the fires for which a frame's file has no grids, as before they start to burn. Those
/// that burn in no frame stay: loading them says what is wrong.
void put_out_fires(Burning& burning, FrameJob& job) {
  for (std::size_t i = 0; i < job.scene.volumes.size(); ++i) {
    formats::SceneVolume& v = job.scene.volumes[i];
    if (!is_out(v) || !burning.has(i)) continue;
    job.warnings.push_back(
        fmt::format("{}: the file has no grid for the fire, which is out", v.file.string()));
    v.fire.reset();
  }
}

/// Adds the scene of a frame that is to be loaded, and finds what that leaves open.
void add_scene(const SequenceGiven& given, Burning& burning, FrameJob& job) {
  add_scene(given, job);
  put_out_fires(burning, job);
  job.open = open_choices(job.scene);
  if (job.open.any()) job.in_sequence->locked_to = given.reference;
}

/// Names the frames to do, the first of which tells about its clouds.
std::vector<FrameJob> name_frames(const SequenceGiven& given, const FramesGiven& frames) {
  std::vector<FrameJob> jobs;
  for (const int frame : frames.now()) jobs.push_back(name_frame(given, frame));
  leave_out_existing({kRenderTool, given.options.common.quiet}, frames, jobs, is_rendered);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    jobs[i].in_sequence->label = frame_label(jobs[i].in_sequence->number, i, jobs.size());
    jobs[i].prints_facts = i == 0;
  }
  return jobs;
}

/// Parses the scenes of the frames and, where one of them leaves something open, of the reference.
/// Then throws Error for all files that are missing.
FrameJobs add_scenes(const SequenceGiven& given, const std::vector<int>& frames,
                     std::vector<FrameJob> jobs) {
  std::vector<FrameFile> needed;
  bool open = false;
  Burning burning(given, frames);
  const auto add = [&](FrameJob& job) {
    const int frame = job.in_sequence->number;
    needed.push_back({frame, job.options.input});
    if (!std::filesystem::exists(job.options.input)) return;
    add_scene(given, burning, job);
    for (const auto& file : files_of(job.scene)) needed.push_back({frame, file});
    check_inputs_stay(job.outputs, job.scene);
    if (!job.outputs.exr.empty()) check_layout(job.options, job.scene.scene);
    open = open || job.open.any();
  };
  for (FrameJob& job : jobs) add(job);
  std::optional<FrameJob> reference;
  if (open && !given.alone) {
    const auto among = std::ranges::find(
        jobs, given.reference, [](const FrameJob& job) { return job.in_sequence->number; });
    reference = among != jobs.end() ? *among : name_frame(given, given.reference);
    if (among == jobs.end()) add(*reference);
  }
  require_files(needed);
  return {std::move(jobs), std::move(reference)};
}

}  // namespace

// --- all jobs -----------------------------------------------------------------------------------

FrameJobs resolve_jobs(const RenderOptionsGiven& o) {
  if (o.frames.any()) {
    const SequenceGiven given = common_to_frames(o);
    return add_scenes(given, o.frames.all(), name_frames(given, o.frames));
  }
  FrameJob job{.options = o, .outputs = choose_outputs(o)};
  refuse_pattern(o.input);
  job.scene = parse_scene(o);
  for (const auto& file : files_of(job.scene)) refuse_pattern(file);
  for (const std::filesystem::path* file : output_names(o)) refuse_pattern(*file);
  check_inputs_stay(job.outputs, job.scene);
  return {{std::move(job)}};
}

FrameJob resolve_split(const RenderOptionsGiven& o) {
  if (o.frames.any()) {
    const SequenceGiven given = common_to_frames(o);
    FrameJob job = name_frame(given, given.reference);
    Burning burning(given, o.frames.all());
    add_scene(given, burning, job);
    return job;
  }
  FrameJob job{.options = o, .outputs = choose_outputs(o)};
  job.scene = parse_scene(o);
  return job;
}

}  // namespace pvol::cli
