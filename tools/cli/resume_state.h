// Where a render begins: with nothing, or with what an earlier one left.
#pragma once

#include "cli/render_options.h"
#include "cli/render_outputs.h"
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
[[nodiscard]] ResumeState find_resume_state(const RenderOptionsGiven& o, const Outputs& out,
                                            const RenderJob& job);

/// Whether a file is a picture that a render left before it had all samples that are wanted.
[[nodiscard]] bool is_unfinished(const RenderOptionsGiven& o, const std::filesystem::path& file);

/// Whether a frame's picture is finished, by the scene with nothing left to choose and the contents
/// of its files: without loading clouds.
[[nodiscard]] bool is_finished(const RenderOptionsGiven& of_frame, const formats::SceneFile& scene);

/// The samples that a job renders.
[[nodiscard]] formats::FilmPiece piece_of(const RenderOptions& o, bool complete);

}  // namespace pvol::cli
