// The Henyey-Greenstein phase function.
#pragma once

#include <cmath>
#include <numbers>

#include "pvol/math/circle.h"
#include "pvol/math/rng.h"
#include "pvol/math/vec.h"

namespace pvol {

/// Based on: Henyey, Greenstein. Diffuse radiation in the galaxy. 1941. Backward scattering is
/// forward scattering about the opposite axis, and everything is written in 1 - |g| and 1 - cos:
/// peaks near |g| = 1 keep their digits in float, and g = 0 needs no case of its own (THEORY.md,
/// T4.1).
struct HenyeyGreenstein {
  float g = 0;            ///< |mean cosine|, in [0, 1)
  float one_minus_g = 1;  ///< rounded from double
  float one_minus_g2 = 1;
  float axis = 1;  ///< -1 where the mean cosine is negative

  HenyeyGreenstein() = default;
  /// mean_cosine in (-1, 1).
  explicit HenyeyGreenstein(double mean_cosine)
      : g(float(std::abs(mean_cosine))),
        one_minus_g(float(1 - std::abs(mean_cosine))),
        one_minus_g2(float(1 - mean_cosine * mean_cosine)),
        axis(mean_cosine < 0 ? -1.0f : 1.0f) {}
};

/// 1 - cos of the angle between unit vectors, precise for small angles.
[[nodiscard]] inline float one_minus_cos(Vec3f a, Vec3f b) {
  const Vec3f d = a - b;
  return 0.5f * dot(d, d);
}

/// The unit vector at an angle with this 1 - cos, in [0, 2], from the unit vector `axis`, at
/// azimuth 2 pi u.
[[nodiscard]] inline Vec3f turn(Vec3f axis, float one_minus_cos, float u) {
  Vec3f s, t;
  orthonormal_basis(axis, s, t);
  const auto [cosine, side] = point_at_turns(u);
  const float sine = std::sqrt(one_minus_cos * (2 - one_minus_cos));
  const Vec3f v = s * (sine * cosine) + t * (sine * side) + axis * (1 - one_minus_cos);
  return v * (1.5f - 0.5f * dot(v, v));  // one Newton step towards unit length stops the drift
}

/// Density per steradian of scattering at an angle to the peak with this 1 - cos, in [0, 2].
[[nodiscard]] inline float pdf_of_angle(const HenyeyGreenstein& hg, float one_minus_cos) {
  const float d = hg.one_minus_g * hg.one_minus_g + 2 * hg.g * one_minus_cos;
  return float(0.25 / std::numbers::pi) * hg.one_minus_g2 / (d * std::sqrt(d));
}

/// Density per steradian of scattering from direction `from` into `to`, both along the flight.
[[nodiscard]] inline float pdf_phase(const HenyeyGreenstein& hg, Vec3f from, Vec3f to) {
  return pdf_of_angle(hg, one_minus_cos(from * hg.axis, to));
}

/// The 1 - cos of the angle to the peak within which the share u of all scattering lies: the
/// inverse of the cumulative distribution, ascending from 0 to 2 over [0, 1].
[[nodiscard]] inline float one_minus_cos_of_share(const HenyeyGreenstein& hg, float u) {
  const float d = hg.one_minus_g + 2 * hg.g * (1 - u);
  const float c = hg.one_minus_g * u * (hg.one_minus_g2 / d + hg.one_minus_g) / d;
  return std::min(c, 2.0f);
}

/// A direction with the density of `pdf_phase`.
[[nodiscard]] inline Vec3f sample_phase(const HenyeyGreenstein& hg, Vec3f from, Rng& rng) {
  const auto [u, azimuth] = rng.uniform2();
  return turn(from * hg.axis, one_minus_cos_of_share(hg, u), azimuth);
}

}  // namespace pvol
