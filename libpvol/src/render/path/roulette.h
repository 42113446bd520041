// Which paths go on.
#pragma once

#include <algorithm>
#include <cmath>

#include "math/philox.h"
#include "pvol/math/vec.h"

namespace pvol::detail {

[[nodiscard]] inline float largest(Rgb c) {
  return std::max(std::abs(c.x), std::max(std::abs(c.y), std::abs(c.z)));
}

/// Paths of a throughput below this are continued with probability throughput / threshold.
inline constexpr float kPathRoulette = 1.0f / 16;

[[nodiscard]] inline bool survives(Rgb& throughput, float threshold, Rng& rng) {
  const float most = largest(throughput);
  if (most >= threshold) return true;
  if (!(rng.uniform() * threshold < most)) return false;
  throughput *= threshold / most;
  return true;
}
[[nodiscard]] inline bool survives(Rgb& throughput, Rng& rng) {
  return survives(throughput, kPathRoulette, rng);
}

}  // namespace pvol::detail
