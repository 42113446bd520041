// Flags for a camera that frames the clouds, as tools that show scenes have them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// What flags set of a scene, as --set would, each with the flag as it was given.
using FlagSets = std::vector<std::pair<std::string, std::string>>;

/// --view, --zoom, --fov and --up.
void add_view(const CommandLine& app, FlagSets& sets);

/// Adds what the flags set after all --set, once these are parsed: the parser keeps nothing else in
/// their list.
void add_to(std::vector<std::string>& sets, std::map<std::string, std::string>& flags_of_sets,
            const FlagSets& of_flags);

/// Reads a scene, or one made for a cloud, with what the command line sets of it. Throws UsageError
/// that names the option that was given.
[[nodiscard]] formats::SceneFile read_scene_as_set(
    const std::filesystem::path& input, const std::vector<std::string>& sets,
    const std::map<std::string, std::string>& flags_of_sets, const std::string& grid);

}  // namespace pvol::cli
