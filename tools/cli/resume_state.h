// Where a render begins: with nothing, or with what an earlier one left.
#pragma once

#include "cli/frame_job.h"
#include "cli/render_report.h"
#include "pvol/formats/film_record.h"

namespace pvol::cli {

/// What is there already.
struct ResumeState {
  Film film;              ///< empty: nothing is
  bool complete = false;  ///< the film has all samples
  bool finished = false;  ///< all that was asked for is there
};

/// Looks for it where the options say so, --resume and --pilot. Throws Error where there is a
/// picture of something else.
[[nodiscard]] ResumeState find_resume_state(const FrameJob& frame, const RenderJob& job);

/// Whether all outputs that are asked for exist, and the picture holds all its samples.
[[nodiscard]] bool is_rendered(const FrameJob& frame);

/// Whether a frame's picture is finished, judged by its scene with nothing left to choose and by
/// the contents of its files, without loading clouds. Never of a picture by itself, and not with
/// --no-resume.
[[nodiscard]] bool is_finished(const FrameJob& frame);

/// The samples that a job renders.
[[nodiscard]] formats::FilmPiece piece_of(const RenderOptions& o, bool complete);

}  // namespace pvol::cli
