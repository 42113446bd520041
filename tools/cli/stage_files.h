// A scene's files in copies on a disk of this machine, for those that lie on a slow one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/local_copies.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// A scene's files under the names of copies, which stay as long as this lives.
struct StagedFiles {
  std::vector<std::string> own;  ///< the files' own names; none where there are no copies
  std::unique_ptr<LocalCopies> copies;
};

/// Gives a scene's clouds, velocities, pictures and meshes the names of copies in a folder. Where a
/// .pvol file has its density in a file beside it, that comes along. What cannot be copied keeps its
/// name, with a warning of the tool. Does nothing for an empty folder.
[[nodiscard]] StagedFiles use_local_copies(const std::string& tool,
                                           const std::filesystem::path& folder,
                                           formats::SceneFile& scene);

/// Gives the files their own names again, which are those for records.
void restore_names(const StagedFiles& staged, formats::SceneFile& scene);

}  // namespace pvol::cli
