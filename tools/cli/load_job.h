// From a job to its clouds in memory and the plan of its render.
#pragma once

#include "cli/frame_job.h"
#include "cli/render_report.h"

namespace pvol::cli {

/// Loads what the scene names, and chooses extinctions and camera where the scene has none. Files
/// are read from their copies on this machine where --local-copies wants them. The plan is not made
/// yet. Throws Error for files that cannot be read.
[[nodiscard]] RenderJob load(const FrameJob& frame);

/// Plans the render, and prints the plan's warnings. Throws Error for renders that would never
/// finish, unless they are forced.
void make_plan(const FrameJob& frame, RenderJob& job);

}  // namespace pvol::cli
