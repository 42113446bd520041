// One verb of pvol-stats for many clouds: a task for each.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cli/split_given.h"

namespace pvol::cli {

struct StatsArray {
  std::vector<std::filesystem::path> clouds;
  SplitGiven given;                    ///< of --for and --at-once
  std::vector<std::string> arguments;  ///< the command line as given, with the tool's name
};

/// Prints a task for each cloud, which leaves the verb's report in CLOUD.VERB.json in this folder:
/// as --for says; without it `run`s the verb for the only cloud. `page` is the --html that was
/// given. Throws UsageError for several clouds without --for, and for what does not go with it.
[[nodiscard]] int run_or_print(const StatsArray& array, const std::string& verb, bool page,
                               const std::function<int(const std::filesystem::path&)>& run);

}  // namespace pvol::cli
