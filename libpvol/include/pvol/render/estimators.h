// Which estimators suit a volume, by its bounds.
#pragma once

#include <span>

#include "pvol/render/scene.h"
#include "pvol/render/volume.h"

namespace pvol {

/// Integrals over the support's box of the bounds that walks meet, in mu_t x cells^3.
struct BoundIntegrals {
  double hi = 0, lo = 0;
  /// Look-ups of decomposition per collision that lies as the density does, taking the density to
  /// be in the middle of its bounds.
  [[nodiscard]] double open_share() const { return hi > 0 ? 2 * (hi - lo) / (hi + lo) : 0; }
};
[[nodiscard]] BoundIntegrals integrate_bounds(const Octree& octree);

/// The same integral of the part of [lo, hi) that micro-bounds leave open as well: over that of
/// mu_t, the look-ups of `decomposition` per collision that lies as the density does. hi - lo for a
/// volume without micro-bounds. For complete pyramids, not those of limit_depth.
[[nodiscard]] double integrate_open(const Volume& volume);

/// The estimator of shadow rays for `Transmittance::automatic`, and why.
struct TransmittanceChoice {
  Transmittance estimator = Transmittance::analog;
  double thickness = 0;  ///< mean optical thickness of the volumes' boxes over all chords, about
  double control_share = 0;  ///< of the majorants' integral that the minorants make up
};

/// Thick clouds take `analog`: a shadow ray ends at its first collision, where `ratio` goes on to
/// dim. Thin ones take `ratio`, or `residual_ratio` where minorants carry most of the extinction
/// (THEORY.md, T23). Deterministic; all choices give the same picture on average.
[[nodiscard]] TransmittanceChoice choose_transmittance(std::span<const Volume> volumes);

/// Whether paths are guided, and a reason in a few words for the log.
struct GuideChoice {
  bool used = false;
  const char* reason = "";
  double scatterings = 0;  ///< of a path, expected; 0 where other things decide
};

/// `automatic` guides where paths scatter so often, and are so many, that it should pay. Guiding
/// needs one volume, a tracker without weights and no limit on bounces: `on` throws Error without
/// them. Deterministic, from the scene alone; the size of the crop does not matter.
[[nodiscard]] GuideChoice choose_guide(std::span<const Volume> volumes, const Scene& scene);

}  // namespace pvol
