// What scenes leave open and pictures must share to go together: extinction, a fire's colour and
// intensity, and camera, chosen for one frame and the same for all.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pvol/formats/scene_file.h"

namespace pvol::cli {

struct FrameJobs;

/// What a scene leaves to choose.
struct OpenChoices {
  bool camera = false;
  std::vector<std::size_t> extinctions;          ///< numbers of the volumes that lack one
  std::vector<std::size_t> colors, intensities;  ///< of those whose fires lack one

  [[nodiscard]] bool any() const {
    return camera || !extinctions.empty() || !colors.empty() || !intensities.empty();
  }
};
[[nodiscard]] OpenChoices open_choices(const formats::SceneFile& scene);

/// The scene of a sequence's reference frame with nothing left open, for all frames to take it
/// from. Nothing where there is no reference; a frame alone that chooses for itself gets a warning.
/// Throws Error where that frame has no density or no fire to choose for.
[[nodiscard]] std::optional<formats::SceneFile> choose_for_all(const FrameJobs& work);

/// Takes what the scene leaves open from one in which it was chosen. A fire that nobody described
/// is out where the file has no grids of one. Throws Error where that scene has fewer volumes.
void lock(formats::SceneFile& scene, const formats::SceneFile& chosen);

}  // namespace pvol::cli
