// Directions of guided paths after a collision.
#pragma once

#include <array>
#include <cmath>

#include "render/guide/importance.h"

namespace pvol::detail {

/// Importance below which paths are ended by roulette.
inline constexpr float kEndBelow = 0.5f;

/// Scatters a path of a direction. Where light comes mostly from the axis, its new one is one of
/// two from the phase function and one from the axis' lobe, chosen in proportion to phase function
/// times importance over the sum of their densities, which the throughput makes up for (THEORY.md,
/// T5.5). Azimuths are those of `Kind`, a kind of paths. Based on: Talbot et al. Importance
/// Resampling for Global Illumination. 2005.
template <class Kind, class Phase>
[[nodiscard]] inline Vec3f turn_by_importance(const Importance& importance,
                                              const Importance::Row& row, const Phase& phase,
                                              Vec3f from, Rgb& throughput, Rng& rng) {
  if (!row.turns()) return sample_phase(phase, from, rng);
  const HenyeyGreenstein& lobe = importance.lobe();
  const Vec3f axis = importance.axis();
  std::array<Vec3f, 3> d;
  std::array<float, 3> value, weight;
  float sum = 0;
  const auto propose = [&](std::size_t i, PhaseSample to, float from_axis) {
    const float q = pdf_of_angle(lobe, from_axis);
    d[i] = to.direction;
    value[i] = row.of(std::sqrt(0.5f * from_axis));
    weight[i] = value[i] * to.pdf / (2 * to.pdf + q);
    sum += weight[i];
  };
  const auto [u0, azimuth0, u1, azimuth1] = rng.uniform4();
  const auto [u2, azimuth2, choice, spare] = rng.uniform4();
  const auto azimuth = Kind::azimuths(Float4{azimuth0, azimuth1, azimuth2, spare});
  const PhaseSample s0 = sample_phase(phase, from, u0, azimuth[0]);
  const PhaseSample s1 = sample_phase(phase, from, u1, azimuth[1]);
  const float c2 = one_minus_cos_of_share(lobe, u2);
  const Vec3f d2 = turn(axis, c2, azimuth[2]);
  propose(0, s0, one_minus_cos(s0.direction, axis));
  propose(1, s1, one_minus_cos(s1.direction, axis));
  propose(2, {d2, pdf_phase(phase, from, d2)}, c2);
  const float u = choice * sum;
  const std::size_t chosen = u < weight[0] ? 0 : u < weight[0] + weight[1] ? 1 : 2;
  throughput *= sum / value[chosen];
  return d[chosen];
}

/// Whether a path of this estimated contribution goes on, by roulette where that is little.
[[nodiscard]] inline bool survives_by_contribution(float contribution, Rgb& throughput, Rng& rng) {
  if (contribution >= kEndBelow) return true;
  if (!(rng.uniform() < contribution)) return false;
  throughput *= 1 / contribution;
  return true;
}

}  // namespace pvol::detail
