// The phase function of clouds and dust by two Henyey-Greenstein lobes.
#pragma once

#include "pvol/volume/henyey_greenstein.h"

namespace pvol {

/// A share of a forward lobe, the rest of a second one: p = w p_g + (1 - w) p_h. Based on:
/// Kattawar. A three-parameter analytic phase function for multiple scattering calculations. 1975
/// (THEORY.md, T4.2).
struct TwoLobes {
  static constexpr const char* kName = "two-lobes";
  HenyeyGreenstein forward{0.85}, backward{-0.3};
  double share = 0.9;  ///< of what scatters into the forward lobe, in [0, 1]
  friend bool operator==(const TwoLobes&, const TwoLobes&) = default;
};

// The questions that every phase function answers, see phase.h.

[[nodiscard]] inline double mean_cosine(const TwoLobes& p) {
  return p.share * p.forward.mean_cosine + (1 - p.share) * p.backward.mean_cosine;
}

[[nodiscard]] inline float pdf_phase(const TwoLobes& p, Vec3f from, Vec3f to) {
  const auto w = float(p.share);
  return w * pdf_phase(p.forward, from, to) + (1 - w) * pdf_phase(p.backward, from, to);
}

[[nodiscard]] inline PhaseSample sample_phase(const TwoLobes& p, Vec3f from, float u,
                                              float azimuth) {
  const auto w = float(p.share);
  const Vec3f d = u < w ? sample_phase(p.forward, from, u / w, azimuth).direction
                        : sample_phase(p.backward, from, (u - w) / (1 - w), azimuth).direction;
  return {d, pdf_phase(p, from, d)};
}

}  // namespace pvol
