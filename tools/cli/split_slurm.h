// A split as work for Slurm.
#pragma once

#include "cli/render_options.h"
#include "cli/slurm_script.h"
#include "cli/split_job.h"

namespace pvol::cli {

/// Pilots, their merges, parts, merges: of all frames together, each after the one before. Tasks
/// have as many threads as Slurm gives them processors, unless the user told.
[[nodiscard]] SlurmWork slurm_work(const SplitJob& job, const RenderOptionsGiven& o);

}  // namespace pvol::cli
