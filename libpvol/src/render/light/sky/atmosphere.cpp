#include "render/light/sky/atmosphere.h"

#include <cmath>

#include "render/light/sky/angles.h"

namespace pvol::detail {
namespace {

/// Cross-sections of ozone in 1e-26 m^2, as means over 10 nm that begin at 380 nm, 390 nm and so
/// on.
constexpr std::array<double, 40> kOzone{
    0.02818, 0.06636, 0.1527, 0.2763, 0.5520, 0.8451, 1.582, 2.316, 3.669, 4.924,
    7.752,   9.016,   14.80,  16.02,  21.39,  27.55,  30.91, 35.00, 42.66, 46.72,
    43.98,   47.01,   50.19,  43.05,  37.40,  32.15,  26.62, 22.38, 18.52, 14.73,
    12.09,   9.423,   7.455,  6.566,  5.105,  4.150,  4.228, 3.237, 2.451, 2.801};

/// Of the tent from 10 to 40 km: its column over its height.
constexpr double kOzoneColumn = 15;

}  // namespace

double molecules_depth(double nm) {
  const double s = nm * nm * 1e-6;  // square micrometres
  return 0.0021520 * (1.0455996 - 341.29061 / s - 0.90230850 * s) /
         (1 + 0.0027059889 / s - 85.968563 * s);
}

double ozone_depth(double nm) {
  constexpr double kDobson = 2.687e20;  // molecules over a square metre
  const double at = std::clamp((nm - 385) / 10, 0.0, double(kOzone.size() - 1));
  const std::size_t i = std::min(std::size_t(at), kOzone.size() - 2);
  const double u = at - double(i);
  return (kOzone[i] * (1 - u) + kOzone[i + 1] * u) * 1e-26 * kDobson;
}

Atmosphere make_atmosphere(double aerosols, double ozone, Rgb ground) {
  constexpr double kAngstrom = 1.3;  // exponent of mixed aerosols (Angstrom 1929)
  Atmosphere a;
  a.molecules = Spectrum([&](double nm) { return molecules_depth(nm) / a.molecules_height; });
  a.aerosols = Spectrum(
      [&](double nm) { return aerosols * std::pow(nm / 550, -kAngstrom) / a.aerosols_height; });
  a.ozone = Spectrum([&](double nm) { return ozone * ozone_depth(nm) / kOzoneColumn; });
  a.ground = albedo_spectrum(ground);
  return a;
}

Amounts amounts_at(const Atmosphere& a, double height) {
  const double tent = height < 25 ? (height - 10) / 15 : (40 - height) / 15;
  return {exp_below(float(-height / a.molecules_height)),
          exp_below(float(-height / a.aerosols_height)), float(std::max(tent, 0.0))};
}

float phase_of_molecules(float cosine) { return float(3 / (16 * kPi)) * (1 + cosine * cosine); }

float phase_of_aerosols(const Atmosphere& a, float cosine) {
  const float g = a.mean_cosine, d = 1 + g * g - 2 * g * cosine;
  return float(1 / (4 * kPi)) * (1 - g * g) / (d * std::sqrt(d));
}

}  // namespace pvol::detail
