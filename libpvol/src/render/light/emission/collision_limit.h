// Which parts of a fire are scored at collisions.
#pragma once

#include "pvol/volume/volume.h"

namespace pvol::detail {

/// The luminance [emission over extinction] up to which parts of the volume's fire are better
/// scored at collisions than along lines with so many points for each leaf: the one for which the
/// second moment of what a ray gathers, times what it costs, is least over lines through the fire
/// (THEORY.md, T5.11). 0: none are. Deterministic.
[[nodiscard]] double brightest_at_collisions(const Volume& volume, int points);

}  // namespace pvol::detail
