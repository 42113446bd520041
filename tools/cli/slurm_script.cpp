#include "cli/slurm_script.h"

#include <fmt/format.h>

#include "cli/shell_words.h"

namespace pvol::cli {
namespace {

constexpr const char* kHead = R"(#
# Run it in the folder of the job, with options of sbatch for all tasks, such as
#   bash FILE --partition=long --time=4:00:00 --cpus-per-task=16
# It submits arrays and ends. When run again, it does the rest of the work.
set -euo pipefail
)";

// Tasks run this. A tool that is killed, or a node that fails, loses what came after the last
// checkpoint. A tool takes a second SIGTERM as "at once", so that nobody may send two.
constexpr const char* kTask = R"task(#!/bin/bash
# One task of an array: line FIRST + its number of LIST.   task.sh LIST FIRST
most_restarts=5  # of a task that fails; running out of time is no failure
most_in_all=100  # restarts of any kind: it makes no progress within its time

mapfile -t -s $(($2 + SLURM_ARRAY_TASK_ID)) -n 1 line <"$1"
again='' ended='' signalled=''
# Slurm's warning that time is nearly up: save, and queue again.
trap 'signalled=1; again=1; kill -TERM "$tool" 2>/dev/null' USR1
# Slurm ends the task and signals the tool as well. If it does not, saving a checkpoint is harmless.
trap 'signalled=1; ended=1; sleep 1; kill -USR1 "$tool" 2>/dev/null' TERM
eval "${line[0]} &"
tool=$!
wait "$tool"
status=$?
while [[ $signalled ]]; do
  signalled=''
  wait "$tool"
  status=$?
done
((status == 0)) && exit 0
# Wrong usage (2) stays wrong.
[[ $again ]] && most_restarts=$most_in_all
if [[ ! $ended ]] && ((status != 2 && ${SLURM_RESTART_COUNT:-0} < most_restarts)); then
  echo "task.sh: status $status; queued again, after ${SLURM_RESTART_COUNT:-0} times"
  trap - TERM
  scontrol requeue "$SLURM_JOB_ID" && sleep 60  # which ends this
fi
exit "$status"
)task";

constexpr const char* kSubmit = R"submit(
largest=1001
while read -r name _ value; do
  [[ $name == MaxArraySize ]] && largest=$value
done < <(scontrol show config)

# submit LIST COUNT LIMIT AFTER OPTION...: an array, or several where it is too large for one; `jobs`
# are their numbers, each after a colon.
submit() {
  local list=$1 count=$2 limit=$3 after=$4 first=0 size job
  shift 4
  jobs=''
  while ((first < count)); do
    size=$((count - first < largest ? count - first : largest))
    job=$(sbatch --parsable --job-name="pvol-$list" --array="0-$((size - 1))$limit" --requeue \
      --signal=B:USR1@120 --open-mode=append --output="$folder/$list.%A_%a.log" \
      ${after:+"--dependency=$after" --kill-on-invalid-dep=yes} "$@" \
      "$folder/task.sh" "$folder/$list.list" "$first")
    jobs+=":${job%%;*}"
    first=$((first + size))
  done
  echo "$list: $count tasks, job${jobs//:/ }"
}

jobs=''
)submit";

std::string file(const std::string& name, const std::string& content) {
  const std::string end = "end of " + name;  // no line of a list begins so
  return fmt::format("cat >\"$folder/{}\" <<'{}'\n{}{}\n", name, end, content, end);
}

std::string list_of(const SlurmArray& array) {
  std::string text;
  for (const std::string& line : array.lines) text += line + '\n';
  return file(array.name + ".list", text);
}

}  // namespace

std::string slurm_script(const SlurmWork& work) {
  std::string text = fmt::format("#!/bin/bash\n# {}\n{}folder={}\nmkdir -p \"$folder\"\n",
                                 work.about, kHead, shell_word(work.folder));
  for (const std::string& f : work.folders) {
    if (f != work.folder) text += fmt::format("mkdir -p {}\n", shell_word(f));
  }
  for (const SlurmArray& array : work.arrays) text += list_of(array);
  text += file("task.sh", kTask) + kSubmit;
  const std::string after = work.all_or_nothing ? "afterok" : "afterany";
  for (const SlurmArray& array : work.arrays) {
    const std::string limit = work.at_once && array.many ? fmt::format("%{}", *work.at_once) : "";
    text += fmt::format("submit {} {} '{}' \"${{jobs:+{}$jobs}}\" \"$@\"\n", array.name,
                        array.lines.size(), limit, after);
  }
  return text;
}

}  // namespace pvol::cli
