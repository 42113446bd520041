// The lobe of a surface that scatters evenly: in proportion to the cosine to its normal.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/philox.h"
#include "pvol/math/direction.h"

namespace pvol::detail {

/// It answers what phase functions do. Based on: Lambert. Photometria. 1760.
struct Lambert {
  Vec3f normal;  ///< unit, on the side of the light
};

/// Density per steradian of `sample_phase`: scattered light over what arrives, for albedo 1.
[[nodiscard]] inline float pdf_phase(const Lambert& lobe, Vec3f /*from*/, Vec3f to) {
  return std::max(0.0f, dot(lobe.normal, to)) * float(1 / std::numbers::pi);
}

[[nodiscard]] inline Vec3f sample_phase(const Lambert& lobe, Vec3f /*from*/, Rng& rng) {
  const auto [u, azimuth] = rng.uniform2();
  // The square of the cosine is uniform; 1 - sqrt(1 - u) without cancellation.
  return turn(lobe.normal, u / (1 + std::sqrt(1 - u)), azimuth);
}

}  // namespace pvol::detail
