// Phase functions: how media scatter light, by the angle between the directions of flight.
//
// To add one: a header like henyey_greenstein.h with a plain struct and the three questions below,
// its name in PhaseFunction, and its rows in medium_keys.h (libpvol/SOURCES.md). In scenes a phase
// function is known by the first of its keys.
#pragma once

#include <variant>

#include "pvol/math/rng.h"
#include "pvol/volume/draine.h"
#include "pvol/volume/droplets.h"
#include "pvol/volume/henyey_greenstein.h"
#include "pvol/volume/phase_table.h"
#include "pvol/volume/rayleigh.h"
#include "pvol/volume/two_lobes.h"

namespace pvol {

using PhaseFunction =
    std::variant<HenyeyGreenstein, TwoLobes, Rayleigh, Draine, Droplets, PhaseTable>;

/// f(kind), and its result: one lobe first, by which most media scatter, and which a table of
/// calls for all kinds would slow down.
template <class F>
[[nodiscard]] inline decltype(auto) visit_phase(const PhaseFunction& phase, const F& f) {
  if (const auto* one_lobe = std::get_if<HenyeyGreenstein>(&phase)) return f(*one_lobe);
  return std::visit(f, phase);
}

/// Mean cosine of the scattering angle, in (-1, 1).
[[nodiscard]] inline double mean_cosine(const PhaseFunction& phase) {
  return std::visit([](const auto& p) { return mean_cosine(p); }, phase);
}

/// Density per steradian of scattering from direction `from` into `to`, both unit and along the
/// flight. It is the same with the two exchanged, and with both reversed.
[[nodiscard]] inline float pdf_phase(const PhaseFunction& phase, Vec3f from, Vec3f to) {
  return visit_phase(phase, [&](const auto& p) { return pdf_phase(p, from, to); });
}

/// A direction with that density and the density itself, from u and azimuth uniform in [0, 1).
/// Strata of u are strata of what is scattered.
[[nodiscard]] inline PhaseSample sample_phase(const PhaseFunction& phase, Vec3f from, float u,
                                              float azimuth) {
  return visit_phase(phase, [&](const auto& p) { return sample_phase(p, from, u, azimuth); });
}
/// Of any of them, or of one kind.
template <class Phase>
[[nodiscard]] inline Vec3f sample_phase(const Phase& phase, Vec3f from, Rng& rng) {
  const auto [u, azimuth] = rng.uniform2();
  return sample_phase(phase, from, u, azimuth).direction;
}

}  // namespace pvol
