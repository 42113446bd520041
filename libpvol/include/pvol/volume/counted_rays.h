// The calls of pvol/embed.h, one a ray, by any tracker or estimator and with counts of what it
// took: for studies of trackers. They have the results of the templates of pvol/trackers.h, and are
// compiled once, for the processor that they run on.
#pragma once

#include "pvol/embed.h"
#include "pvol/track/tally.h"

namespace pvol {

// All add their counts to those that `tally` has, and throw what those of embed.h throw.

/// By a tracker; flights of weighted ones have weights. `delta_global` is `delta` on the octree
/// that the volume has. Throws Error for `regular` where there is no closed form.
[[nodiscard]] Flight sample_flight(const Volume& volume, const Ray& ray, double t_max, Rng& rng,
                                   Tracker tracker, Tally& tally);

[[nodiscard]] float sample_transmittance(const Volume& volume, const Ray& ray, double t_max,
                                         Rng& rng, Transmittance estimator, Tally& tally);

/// int mu_t up to t_max in closed form; look-ups are cells crossed. Throws Error where there is no
/// closed form.
[[nodiscard]] double exact_optical_depth(const Volume& volume, const Ray& ray, double t_max,
                                         Tally& tally);

}  // namespace pvol
