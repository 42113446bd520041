// Options of a command line that set values of a scene, and the scene's part of the manual.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "cli/command_line.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// Adds a flag for each row of formats::render_keys, whose text is kept under its key.
void add_scene_options(const CommandLine& app, std::map<std::string, std::string>& options);

/// Sets what was given: of samples and what replaces them the command line has the last word.
/// Throws UsageError for a value out of its limits and for one that goes with another that the
/// scene does not have.
void apply_options(const std::map<std::string, std::string>& options, formats::SceneFile& scene);

/// Every key of a scene, for the man page.
[[nodiscard]] std::vector<ManualPart> scene_manual();

}  // namespace pvol::cli
