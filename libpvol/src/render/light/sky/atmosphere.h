// The air above a planet: what scatters and absorbs light, by height and wavelength.
#pragma once

#include <array>

#include "render/light/sky/spectrum.h"

namespace pvol::detail {

/// Heights in km that light is reckoned at. Ozone has its corners at 10, 25 and 40 km; aerosols are
/// near the ground.
inline constexpr std::array<double, 26> kLevels{0,   0.12, 0.3, 0.55, 0.9, 1.3,  1.8, 2.4, 3.2,
                                                4.2, 5.5,  7,   8.5,  10,  12.5, 15,  18,  21.5,
                                                25,  29,   34,  40,   48,  60,   80,  100};
inline constexpr int kTop = int(kLevels.size()) - 1;

/// Lengths are in km, coefficients per km.
struct Atmosphere {
  double planet = 6371;  ///< its radius
  /// Over which their density falls by e: the mean height of the air, with which columns along
  /// rays down to 5 degrees above the horizon are within 1 % of those of the standard atmosphere.
  double molecules_height = 7.4;
  double aerosols_height = 1.2;   ///< (Bruneton and Neyret 2008)
  Spectrum molecules;             ///< scattering at the ground
  Spectrum aerosols;              ///< extinction at the ground
  float aerosols_albedo = 0.93f;  ///< scattering over extinction
  float mean_cosine = 0.7f;       ///< of aerosols, by Henyey and Greenstein
  Spectrum ozone;   ///< absorption at 25 km, from where it falls linearly to both sides
  Spectrum ground;  ///< albedo of the ground, which is matt
};

/// Vertical optical depth of the molecules of the air over the sea, by wavelength in nm, the fit of
/// Bodhaine, Wood, Dutton and Slusser 1999 (equation 30), good to 0.01 % over 250 to 850 nm.
[[nodiscard]] double molecules_depth(double nm);
/// The same of ozone, one Dobson unit of it, by cross-sections at 233 K (Serdyuchenko et al. 2014,
/// means over 10 nm); of 380 to 770 nm.
[[nodiscard]] double ozone_depth(double nm);

/// Aerosols of this optical depth at 550 nm, which falls as nm^-1.3; ozone in Dobson units.
[[nodiscard]] Atmosphere make_atmosphere(double aerosols, double ozone, Rgb ground);

/// Amounts of what there is: over those at the ground, and of ozone at 25 km. Of columns: in km.
struct Amounts {
  float molecules = 0, aerosols = 0, ozone = 0;
};
[[nodiscard]] Amounts amounts_at(const Atmosphere& a, double height);

[[nodiscard]] inline Spectrum extinction(const Atmosphere& a, const Amounts& n) {
  Spectrum sum = a.molecules * n.molecules;
  return sum.add(a.aerosols, n.aerosols).add(a.ozone, n.ozone);
}

// Phase functions per steradian, of the cosine of the angle between flight directions.
[[nodiscard]] float phase_of_molecules(float cosine);
[[nodiscard]] float phase_of_aerosols(const Atmosphere& a, float cosine);

}  // namespace pvol::detail
