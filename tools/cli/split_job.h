// The command lines of a picture's parts, and of the merges that put them together.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/render_options.h"
#include "cli/split.h"

namespace pvol::cli {

using Arguments = std::vector<std::string>;  ///< of a command, its name the first

struct PartCommand {
  Arguments command{};
  std::filesystem::path output{};
  PicturePart part{};
  bool samples_told = true;  ///< false: as many as pixels need
};

/// Puts the files of one folder together that a pattern of the shell matches.
struct MergeCommand {
  Arguments before, after;  ///< the files' names
  std::filesystem::path folder;
  std::string pattern;  ///< of the files' names, without the folder
  std::vector<std::filesystem::path> files;

  /// With all names, for those who start processes without a shell.
  [[nodiscard]] Arguments command() const;
};

/// Parts that may run at the same time, and their merge after all of them.
struct SplitStage {
  std::vector<PartCommand> parts;
  MergeCommand merge;
};

struct SplitPicture {
  std::optional<int> frame{};
  std::filesystem::path output{}, folder{};  ///< of its parts
  std::optional<SplitStage> pilots{};        ///< before the parts, of adaptive samples
  SplitStage parts{};
};

struct SplitJob {
  std::filesystem::path folder{};  ///< of all that is written on the way
  std::vector<SplitPicture> pictures{};
  double cpu_seconds = 0;  ///< of one picture in parts, each with a guide of its own; by forecast
  double imbalance = 1;    ///< of its parts
};

/// All frames are cut alike, as the plan's picture is. Throws UsageError for more parts than
/// samples, and what map_cost throws.
[[nodiscard]] SplitJob split_job(const RenderOptionsGiven& o, const RenderPlan& plan);

/// The user's command line without what each part and merge says for itself: outputs, looks of the
/// .png, the split, crop and frame. As it was given, so that names stay relative to the folder.
[[nodiscard]] Arguments echoed(const Arguments& given);

/// For people: "200 parts of 62 s of CPU time, 3.4 h in all; the largest takes 1.03
/// times the mean".
[[nodiscard]] std::string summary(const SplitJob& job);

}  // namespace pvol::cli
