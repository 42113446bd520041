// The pictures that a command line asks for, resolved once, before work on the first of them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/choose_outputs.h"
#include "cli/render_options.h"
#include "cli/render_report.h"
#include "cli/shared_choices.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// A frame of a sequence, or a picture by itself.
struct FrameJob {
  RenderOptionsGiven options;  ///< with the frame's number in the names of files, and it alone
  Outputs outputs{};
  std::optional<FrameReport> in_sequence{};  ///< its place; nothing for a picture by itself
  std::size_t frames_of_run = 1;             ///< that the command line names, with those left out
  bool prints_facts = true;             ///< about its clouds: of a sequence the first frame does
  formats::SceneFile scene{};           ///< parsed; its clouds, sky and surfaces are not loaded
  OpenChoices open{};                   ///< of a sequence: what the scene leaves to choose
  std::vector<std::string> warnings{};  ///< of a sequence: about fires that are out in the frame
};

/// All that there is to do.
struct FrameJobs {
  std::vector<FrameJob> jobs;  ///< in the order of the work
  /// The frame from which all others take what they leave open; it may be none of the jobs. Nothing
  /// where no scene leaves anything open, and for one frame alone, which chooses for itself.
  std::optional<FrameJob> reference{};
};

/// Resolves the picture or the frames that the options ask for, without the frames that
/// --skip-existing leaves out. Parses their scenes and checks that the files of frames exist,
/// before there is work for the first. Throws UsageError for options that do not go together and
/// names without a place for the frame's number, and Error for files that are missing or cannot be
/// read.
[[nodiscard]] FrameJobs resolve_jobs(const RenderOptionsGiven& o);

/// The picture that is split into parts: of a sequence the reference frame, as all frames are split
/// alike. Its files are not checked. Throws what resolve_jobs throws.
[[nodiscard]] FrameJob resolve_split(const RenderOptionsGiven& o);

}  // namespace pvol::cli
