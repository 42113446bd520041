// Work for Slurm: a script that submits arrays of tasks, one after another.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace pvol::cli {

/// Command lines that may run at the same time.
struct SlurmArray {
  std::string name;                ///< of a file: "parts"
  std::vector<std::string> lines;  ///< for bash
  bool many = true;                ///< whether the limit on running tasks is about them
};

struct SlurmWork {
  std::string about;                   ///< in a sentence or two
  std::string folder;                  ///< of lists and logs
  std::vector<std::string> folders{};  ///< that tasks want besides
  std::vector<SlurmArray> arrays{};    ///< each begins after those before it
  /// Whether an array waits for success of all tasks before it. Otherwise only for their end: tasks
  /// whose own input is there go on.
  bool all_or_nothing = true;
  std::optional<int> at_once;  ///< most tasks that run at a time
};

/// For bash 5 and Slurm's own commands. Tasks that fail are queued again a few times, all that are
/// ended by a limit on time are until they are done.
[[nodiscard]] std::string slurm_script(const SlurmWork& work);

}  // namespace pvol::cli
