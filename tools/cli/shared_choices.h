// What scenes leave open and pictures must share to go together: extinction, a fire's intensity and
// camera, chosen for one frame and the same for all.
#pragma once

#include <optional>
#include <string>

#include "pvol/formats/scene_file.h"

namespace pvol::cli {

struct FrameJobs;

/// "extinction", "camera", "extinction and camera" and the like, or nothing.
[[nodiscard]] std::string open_choices(const formats::SceneFile& scene);

/// The scene of a sequence's reference frame with nothing left open, for all frames to take it
/// from. Nothing where there is no reference; a frame alone that chooses for itself gets a warning.
/// Throws Error where the frame has no density to choose for.
[[nodiscard]] std::optional<formats::SceneFile> choose_for_all(const FrameJobs& work);

/// Takes what the scene leaves open from one in which it was chosen. Throws Error where that one
/// has fewer volumes.
void lock(formats::SceneFile& scene, const formats::SceneFile& chosen);

}  // namespace pvol::cli
