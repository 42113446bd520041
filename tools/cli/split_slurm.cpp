#include "cli/split_slurm.h"

#include "cli/shell_words.h"
#include "cli/split_text.h"

namespace pvol::cli {
namespace {

/// Appends the parts of a stage and their merge.
void append(const SplitStage& stage, bool has_threads, SlurmArray& parts, SlurmArray& merges) {
  for (const PartCommand& p : stage.parts) {
    parts.lines.push_back(shell_line(p.command) +
                          (has_threads ? "" : " --threads \"${SLURM_CPUS_ON_NODE:-0}\""));
  }
  merges.lines.push_back(shell_line(stage.merge));
}

}  // namespace

SlurmWork slurm_work(const SplitJob& job, const RenderOptionsGiven& o) {
  SlurmWork work{.about = summary(job) + ".",
                 .folder = job.folder.string(),
                 .all_or_nothing = job.pictures.size() == 1,
                 .at_once = o.split.at_once};
  const bool has_threads = o.options.contains("threads");
  SlurmArray pilots{"pilots", {}}, pilot_merges{"pilot-merges", {}, false};
  SlurmArray parts{"parts", {}}, merges{"merges", {}, false};
  for (const SplitPicture& p : job.pictures) {
    if (p.pilots) append(*p.pilots, has_threads, pilots, pilot_merges);
    append(p.parts, has_threads, parts, merges);
    work.folders.push_back(p.folder.string());
  }
  if (!pilots.lines.empty()) work.arrays = {std::move(pilots), std::move(pilot_merges)};
  work.arrays.push_back(std::move(parts));
  work.arrays.push_back(std::move(merges));
  return work;
}

}  // namespace pvol::cli
