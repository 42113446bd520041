// Draine's phase function: Henyey-Greenstein with a share of cos^2, from Rayleigh's to sharp peaks
// with light thrown back.
#pragma once

#include "pvol/volume/henyey_greenstein.h"

namespace pvol {

/// The largest alpha: beyond it the dip at right angles is deeper than directions in float resolve.
inline constexpr double kLargestAlpha = 1e4;

/// p = p_g (1 + alpha cos^2) / (1 + alpha (1 + 2 g^2) / 3), p_g that of Henyey-Greenstein, which it
/// is for alpha = 0. With g = 0 and alpha = 1 it is Rayleigh's. Based on: Draine. Scattering by
/// interstellar dust grains. I. Optical and ultraviolet. 2003 (THEORY.md, T4.4).
struct Draine {
  static constexpr const char* kName = "draine";
  HenyeyGreenstein lobe;  ///< p_g; its mean cosine is g, not that of p
  double alpha = 0;       ///< in [0, kLargestAlpha]
  double turn_share = 0;  ///< of all scattering, within 90 degrees of the peak
  float flat = 1;         ///< p = p_g (flat + squared cos^2)
  float squared = 0;

  Draine() : Draine(0.5, 1) {}
  Draine(double g, double alpha);
  friend bool operator==(const Draine&, const Draine&) = default;
};

// As for Henyey-Greenstein: by 1 - cos to the peak, in [0, 2].

[[nodiscard]] inline float pdf_of_angle(const Draine& p, float one_minus_cos) {
  const float cosine = 1 - one_minus_cos;
  return pdf_of_angle(p.lobe, one_minus_cos) * (p.flat + p.squared * (cosine * cosine));
}
[[nodiscard]] float one_minus_cos_of_share(const Draine& p, float u);

// The questions that every phase function answers, see phase.h.

[[nodiscard]] double mean_cosine(const Draine& p);

[[nodiscard]] inline float pdf_phase(const Draine& p, Vec3f from, Vec3f to) {
  return pdf_of_angle(p, one_minus_cos(from * p.lobe.axis, to));
}

[[nodiscard]] inline PhaseSample sample_phase(const Draine& p, Vec3f from, float u, float azimuth) {
  const float c = one_minus_cos_of_share(p, u);
  return {turn(from * p.lobe.axis, c, azimuth), pdf_of_angle(p, c)};
}

}  // namespace pvol
