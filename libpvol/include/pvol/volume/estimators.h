// Which estimators suit a volume, by its bounds.
#pragma once

#include <span>

#include "pvol/volume/volume.h"

namespace pvol {

/// The integral of bounds (integrals.h) over the part of [lo, hi) that micro-bounds or codes leave
/// open as well: over that of mu_t, the look-ups of `decomposition` per collision that lies as the
/// density does. hi - lo for a volume without. For complete pyramids, not those of limit_depth.
[[nodiscard]] double integrate_open(const Volume& volume);

/// The estimator of shadow rays for `Transmittance::automatic`, and why.
struct TransmittanceChoice {
  Transmittance estimator = Transmittance::analog;
  double thickness = 0;  ///< mean optical thickness of the volumes' boxes over all chords, about
  double control_share = 0;  ///< of the majorants' integral that the minorants make up
};

/// Thick clouds take `analog`: a shadow ray ends at its first collision, where `ratio` goes on to
/// dim. Thin ones take `ratio`, or `residual_ratio` where minorants carry most of the extinction
/// (THEORY.md, T5.3). Deterministic; all choices give the same picture on average.
[[nodiscard]] TransmittanceChoice choose_transmittance(std::span<const Volume> volumes);

}  // namespace pvol
