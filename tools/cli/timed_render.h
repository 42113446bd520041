// A render with all that goes on beside it: progress and checkpoints.
#pragma once

#include "cli/frame_job.h"
#include "cli/render_report.h"

namespace pvol::cli {

/// Goes on with a film, perhaps an empty one, until it is done or interrupted. `show`, if any, is
/// given the film between passes. Checkpoints that cannot be written are warnings.
[[nodiscard]] TimedRender render_timed(const FrameJob& frame, const RenderJob& job, Film begun,
                                       const PassDone& show);

/// A film that an earlier run left with all its samples, before it was filtered or all was saved.
[[nodiscard]] TimedRender already_rendered(Film film);

}  // namespace pvol::cli
