// A scene as a frame of a sequence: names, random numbers, and choices that all frames share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "cli/render_options.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {

/// The scene that the options say, its volumes and sky not loaded yet.
[[nodiscard]] formats::SceneFile scene_of(const RenderOptionsGiven& o);

/// Noise that stays while the picture moves looks like a dirty window, so each frame has random
/// numbers of its own. Below 2^63, for scenes to hold it.
[[nodiscard]] std::uint64_t seed_of_frame(std::uint64_t seed, int frame);

/// The options and the scene of a frame: with its number in the names of files, and its seed.
[[nodiscard]] RenderOptionsGiven options_of_frame(const RenderOptionsGiven& o, int frame);
[[nodiscard]] formats::SceneFile scene_of_frame(const RenderOptionsGiven& o, int frame);

/// Throws UsageError for names without a place for the frame's number, and for what goes with one
/// picture only.
void check_sequence(const RenderOptionsGiven& o);

/// Whether all that a frame's options ask for is there.
[[nodiscard]] bool is_rendered(const RenderOptionsGiven& of_frame);

/// Reads the scenes of all frames, before there is work for the first: throws Error for files that
/// are not there. Returns whether a frame leaves something open; then `reference` is checked, too.
[[nodiscard]] bool check_scenes(const RenderOptionsGiven& o, const std::vector<int>& frames,
                                int reference);

/// What a scene leaves to choose and pictures must share to go together: "extinction", "camera",
/// "extinction and camera" and the like, or nothing.
[[nodiscard]] std::string open_choices(const formats::SceneFile& scene);

/// Takes what the scene leaves open from one in which it was chosen. Throws Error where that one
/// has fewer volumes.
void lock(formats::SceneFile& scene, const formats::SceneFile& chosen);

}  // namespace pvol::cli
