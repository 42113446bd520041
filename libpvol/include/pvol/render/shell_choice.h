// Whether a cloud's shell pays for a camera.
#pragma once

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol {

struct Shell;  // shell/shell.h

/// Counts over a coarse grid of camera rays, and what they cost in nanoseconds by the cost models
/// of walk and shell (THEORY.md, T2.1 and T7.5). A ray counts at each of the cloud's places.
struct ShellEstimate {
  int rays = 0;      ///< in the image
  int boxed = 0;     ///< that meet the cloud's box: each tests the shell
  int rejected = 0;  ///< by the shell
  double spent = 0;  ///< on testing the shell, ns per ray that meets the box
  double saved = 0;  ///< on walking rejected rays through the octree, likewise
  [[nodiscard]] bool pays() const { return saved > spent; }
};

/// Deterministic. The volume need not have the shell.
[[nodiscard]] ShellEstimate estimate_shell(const Volume& volume, const Shell& shell,
                                           const Scene& scene);

/// What became of a shell, for the log.
struct ShellChoice {
  bool kept = false;
  ShellEstimate estimate;
};

/// Whether rays test the volume's shell before its octree: where there is one and the scene's
/// options say so, or leave it to the estimate and that says that it pays for the scene's camera.
/// Of one volume those of the camera do, and the picture is the same either way. Of many clouds all
/// rays do that come from elsewhere, and the picture is the same on average: a walk that is left
/// out draws no random numbers.
[[nodiscard]] ShellChoice choose_shell(const Volume& volume, const Scene& scene);

}  // namespace pvol
