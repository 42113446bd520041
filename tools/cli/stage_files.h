// Copies of a scene's files on a disk of this machine, for those that lie on a slow one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// The folder that --local-copies means: "auto" is pvol-USER in $SLURM_TMPDIR, $TMPDIR or /tmp.
[[nodiscard]] std::filesystem::path local_folder(const std::filesystem::path& given);

/// Copies a file into a folder, under its whole name, unless a copy of the same size and time is
/// there; returns the copy's name. Several processes may do so at once. Throws Error.
[[nodiscard]] std::filesystem::path copy_to(const std::filesystem::path& folder,
                                            const std::filesystem::path& file);

/// Gives a scene's clouds, velocities, pictures and meshes the names of copies in a folder, and
/// returns their own for `restore_names`. Where a .pvol file has its density in a file beside it,
/// that comes along. What cannot be copied keeps its name, with a warning of the tool. Does nothing
/// for an empty folder.
[[nodiscard]] std::vector<std::string> use_local_copies(const std::string& tool,
                                                        const std::filesystem::path& folder,
                                                        formats::SceneFile& scene);

/// Gives the files their own names again, which are those for records.
void restore_names(const std::vector<std::string>& own, formats::SceneFile& scene);

}  // namespace pvol::cli
