// The phase function of fog and clouds by the size of their droplets.
#pragma once

#include "pvol/volume/draine.h"

namespace pvol {

/// Of water droplets, in micrometres: what the fit was made for.
inline constexpr double kLargestDroplet = 50;

/// Water droplets in visible light: a Henyey-Greenstein peak and a Draine lobe, fitted to the
/// theory of Mie. Without its coronas, bow and glory. Based on: Jendersie, d'Eon. An Approximate
/// Mie Scattering Function for Fog and Cloud Rendering. 2023 (THEORY.md, T4.5).
struct Droplets {
  static constexpr const char* kName = "droplets";
  double diameter = 0;  ///< in micrometres, in (0, kLargestDroplet]
  HenyeyGreenstein peak;
  Draine wide;
  double wide_share = 0;  ///< of what scatters into the wide lobe

  Droplets() : Droplets(20) {}
  explicit Droplets(double micrometres);
  friend bool operator==(const Droplets&, const Droplets&) = default;
};

// The questions that every phase function answers, see phase.h.

[[nodiscard]] double mean_cosine(const Droplets& p);
[[nodiscard]] float pdf_phase(const Droplets& p, Vec3f from, Vec3f to);
[[nodiscard]] PhaseSample sample_phase(const Droplets& p, Vec3f from, float u, float azimuth);

}  // namespace pvol
