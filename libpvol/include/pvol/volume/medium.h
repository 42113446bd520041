// What a cloud is made of, besides its density.
#pragma once

#include <vector>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/volume/phase.h"

namespace pvol {

/// A kind of matter that takes part in the extinction: droplets, soot, hot gas.
struct Component {
  double share = 1;    ///< of the extinction, everywhere, in [0, 1]
  Rgb albedo{0.999f};  ///< mu_s / mu_t by channel, in [0, 1]
  PhaseFunction phase = HenyeyGreenstein(0.5);
  Rgb emission{0.0f};  ///< radiance L_e: the component emits mu_a L_e per unit length
  friend bool operator==(const Component&, const Component&) = default;
};

/// Of radiance, emission and irradiance: sums of their squares over all samples stay far inside
/// double, and they themselves inside float.
inline constexpr Range kRadianceRange = Range::closed(0, 1e30);

[[nodiscard]] constexpr auto keys(const Component&) {
  using C = Component;
  return std::to_array<Key<C>>({
      key<&C::share>({.key = "share",
                      .metavar = "X",
                      .limits = number(Range::closed(0, 1)),
                      .help = "Share of the extinction; the medium itself has what is left",
                      .required = true}),
      key<&C::albedo>({.key = "albedo",
                       .metavar = "RGB",
                       .limits = number(Range::closed(0, 1)).or_three(),
                       .help = "Scattering over extinction"}),
      keys_of_kind<&C::phase>(),
      key<&C::emission>({.key = "emission",
                         .metavar = "RGB",
                         .limits = number(kRadianceRange).or_three(),
                         .help = "Radiance that absorbing matter emits"}),
  });
}

/// Optical properties of a cloud whose density field is known: mu_t = extinction * rho.
struct Medium {
  double extinction = 1;  ///< per world unit and unit of density, >= 0
  /// At least one; their shares sum up to 1.
  std::vector<Component> components{Component{}};
  friend bool operator==(const Medium&, const Medium&) = default;
};

[[nodiscard]] constexpr auto keys(const Medium&) {
  return std::to_array<Key<Medium>>({
      key<&Medium::extinction>({.key = "extinction",
                                .metavar = "X",
                                .limits = number(Range::at_least(0)),
                                .help = "Extinction per world unit and unit of density",
                                .otherwise = "chosen for the cloud, and printed"}),
  });
}

/// How far the sum of the shares may be off 1.
inline constexpr double kShareSlack = 1e-9;

/// Gives the first component the share that the others leave; false where that is less than none.
[[nodiscard]] bool share_rest(Medium& medium);

/// Throws Error, which says what is wrong, for a medium whose components are out of range.
void validate(const Medium& medium);

/// The largest albedo of any component and channel.
[[nodiscard]] float largest_albedo(const Medium& medium);

}  // namespace pvol
