// What pvol-render is to write, under which names and in which layout: decided before any work.
#pragma once

#include <filesystem>

#include "cli/render_options.h"
#include "pvol/formats/image.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/scene.h"

namespace pvol::cli {

/// Names of the files to write; empty for those that are not wanted.
struct Outputs {
  std::filesystem::path exr, png, deep;
};

/// The outputs that the options ask for, none where the scene is printed. Throws UsageError where
/// they do not go together, and Error for names that cannot be written to.
[[nodiscard]] Outputs choose_outputs(const RenderOptionsGiven& o);

/// Throws UsageError where one of them is a file that the scene reads.
void check_inputs_stay(const Outputs& out, const formats::SceneFile& scene);

/// Whether all of them are there, and the statistics.
[[nodiscard]] bool all_there(const RenderOptionsGiven& o, const Outputs& out);

/// How the .exr of a scene is written.
[[nodiscard]] formats::ExrOptions exr_options(const RenderOptionsGiven& o, const Scene& scene);

/// Throws UsageError for layers that cannot be written as the options say, before anything is
/// rendered for them.
void check_layout(const RenderOptionsGiven& o, const Scene& scene);

}  // namespace pvol::cli
