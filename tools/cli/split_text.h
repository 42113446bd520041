// A split as a shell runs it and as programs read it.
#pragma once

#include <string>

#include "cli/split_job.h"

namespace pvol::cli {

/// The merge with a pattern in place of the files' names, which may be too many for a line.
[[nodiscard]] std::string shell_line(const MergeCommand& merge);

/// A script for bash that does all parts one after another; each line of a part may as well be
/// given to any queue that starts processes.
[[nodiscard]] std::string split_script(const SplitJob& job);

/// {"parts": [...], "merge": {...}}, and "pilots" with the same for adaptive samples; of
/// sequences {"frames": [{"frame": 1, ...}, ...]}.
[[nodiscard]] std::string split_json(const SplitJob& job);

}  // namespace pvol::cli
