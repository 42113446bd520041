// Rayleigh's phase function: air, and all that is far smaller than the wavelength.
#pragma once

#include "pvol/volume/henyey_greenstein.h"

namespace pvol {

/// p = 3 / (16 pi) (1 + cos^2). Based on: Strutt (Rayleigh). On the light from the sky, its
/// polarization and colour. 1871; of light that is not polarised (THEORY.md, T4.3).
struct Rayleigh {
  static constexpr const char* kName = "rayleigh";
  friend bool operator==(const Rayleigh&, const Rayleigh&) = default;
};

// As for Henyey-Greenstein: by 1 - cos, in [0, 2].

[[nodiscard]] inline float pdf_of_angle(const Rayleigh&, float one_minus_cos) {
  const float cosine = 1 - one_minus_cos;
  return float(0.1875 / std::numbers::pi) * (1 + cosine * cosine);
}
[[nodiscard]] float one_minus_cos_of_share(const Rayleigh&, float u);

// The questions that every phase function answers, see phase.h.

[[nodiscard]] inline double mean_cosine(const Rayleigh&) { return 0; }

[[nodiscard]] inline float pdf_phase(const Rayleigh& p, Vec3f from, Vec3f to) {
  return pdf_of_angle(p, one_minus_cos(from, to));
}

[[nodiscard]] inline PhaseSample sample_phase(const Rayleigh& p, Vec3f from, float u,
                                              float azimuth) {
  const float c = one_minus_cos_of_share(p, u);
  return {turn(from, c, azimuth), pdf_of_angle(p, c)};
}

}  // namespace pvol
