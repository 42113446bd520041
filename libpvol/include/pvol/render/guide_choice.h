// Whether guiding pays for a scene.
#pragma once

#include <span>

#include "pvol/render/lighting.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Whether paths are guided, and a reason in a few words for the log.
struct GuideChoice {
  bool used = false;
  const char* reason = "";
  double scatterings = 0;  ///< of a path, expected; 0 where other things decide
};

/// `automatic` guides where paths scatter so often, and are so many, that it should pay, and where
/// light comes from more than a smooth sky; fires do not count, whose own noise it hardly lessens.
/// Guiding needs a volume, and majorants that hold: `on` throws Error without them.
/// Deterministic, from the scene and the number of camera paths alone.
[[nodiscard]] GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene,
                                       double paths);
/// The same, of a scene whose lighting is made.
[[nodiscard]] GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene,
                                       const Lighting& lighting, double paths);

}  // namespace pvol
