// The Henyey-Greenstein phase function.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/math/direction.h"
#include "pvol/math/vec.h"

namespace pvol {

/// Of mean cosines: beyond it the phase function is one spike in float.
inline constexpr double kLargestMeanCosine = 0.9999;

/// A direction, and its density per steradian.
struct PhaseSample {
  Vec3f direction;
  float pdf = 0;
};

/// Isotropic at g = 0. Based on: Henyey, Greenstein. Diffuse radiation in the galaxy. 1941.
/// Backward scattering is forward scattering about the opposite axis, and everything is written in
/// 1 - |g| and 1 - cos: peaks near |g| = 1 keep their digits in float, and g = 0 needs no case of
/// its own (THEORY.md, T4.1).
struct HenyeyGreenstein {
  static constexpr const char* kName = "henyey-greenstein";
  double mean_cosine = 0;  ///< in [-kLargestMeanCosine, kLargestMeanCosine]
  float g = 0;             ///< |mean cosine|, in [0, 1)
  float one_minus_g = 1;   ///< rounded from double
  float one_minus_g2 = 1;
  float axis = 1;  ///< -1 where the mean cosine is negative

  HenyeyGreenstein() = default;
  explicit HenyeyGreenstein(double cosine)
      : mean_cosine(cosine),
        g(float(std::abs(cosine))),
        one_minus_g(float(1 - std::abs(cosine))),
        one_minus_g2(float(1 - cosine * cosine)),
        axis(cosine < 0 ? -1.0f : 1.0f) {}
  friend bool operator==(const HenyeyGreenstein&, const HenyeyGreenstein&) = default;
};

/// Density per steradian of scattering at an angle to the peak with this 1 - cos, in [0, 2].
[[nodiscard]] inline float pdf_of_angle(const HenyeyGreenstein& hg, float one_minus_cos) {
  const float d = hg.one_minus_g * hg.one_minus_g + 2 * hg.g * one_minus_cos;
  return float(0.25 / std::numbers::pi) * hg.one_minus_g2 / (d * std::sqrt(d));
}

/// The 1 - cos of the angle to the peak within which the share u of all scattering lies: the
/// inverse of the cumulative distribution, ascending from 0 to 2 over [0, 1].
[[nodiscard]] inline float one_minus_cos_of_share(const HenyeyGreenstein& hg, float u) {
  const float d = hg.one_minus_g + 2 * hg.g * (1 - u);
  const float c = hg.one_minus_g * u * (hg.one_minus_g2 / d + hg.one_minus_g) / d;
  return std::min(c, 2.0f);
}

// The questions that every phase function answers, see phase.h.

[[nodiscard]] inline double mean_cosine(const HenyeyGreenstein& hg) { return hg.mean_cosine; }

[[nodiscard]] inline float pdf_phase(const HenyeyGreenstein& hg, Vec3f from, Vec3f to) {
  return pdf_of_angle(hg, one_minus_cos(from * hg.axis, to));
}

/// The azimuth is one that `turn` takes.
template <class Azimuth>
[[nodiscard]] inline PhaseSample sample_phase(const HenyeyGreenstein& hg, Vec3f from, float u,
                                              Azimuth azimuth) {
  const float c = one_minus_cos_of_share(hg, u);
  return {turn(from * hg.axis, c, azimuth), pdf_of_angle(hg, c)};
}

}  // namespace pvol
