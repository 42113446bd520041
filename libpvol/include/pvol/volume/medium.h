// What a cloud is made of, besides its density. What users set of it: medium_keys.h.
#pragma once

#include <vector>

#include "pvol/math/vec.h"
#include "pvol/volume/phase.h"

namespace pvol {

/// A kind of medium that takes part in the extinction: droplets, soot, hot gas.
struct Component {
  double share = 1;    ///< of the extinction, everywhere, in [0, 1]
  Rgb albedo{0.999f};  ///< mu_s / mu_t by channel, in [0, 1]
  PhaseFunction phase = HenyeyGreenstein(0.5);
  Rgb emission{0.0f};  ///< radiance L_e: the component emits mu_a L_e per unit length
  friend bool operator==(const Component&, const Component&) = default;
};

/// Optical properties of a cloud whose density field is known: mu_t = extinction * rho.
struct Medium {
  double extinction = 1;  ///< per world unit and unit of density, >= 0
  /// At least one; their shares sum up to 1.
  std::vector<Component> components = std::vector<Component>(1);
  /// Share of the extinction by channel, in [0, 1], the largest 1: mu_t = extinction * share * rho.
  Rgb extinction_color{1.0f};
  friend bool operator==(const Medium&, const Medium&) = default;
};

/// Whether channels differ in their extinction.
[[nodiscard]] inline bool is_chromatic(const Medium& m) { return m.extinction_color != Rgb(1.0f); }

/// Gives the first component the share that the others leave; false where that is less than none.
[[nodiscard]] bool share_rest(Medium& medium);

/// Throws Error, which says what is wrong, for a medium whose components are out of range.
void validate(const Medium& medium);

/// The largest albedo of any component and channel.
[[nodiscard]] float largest_albedo(const Medium& medium);

/// Whether any component emits.
[[nodiscard]] bool emits(const Medium& medium);

}  // namespace pvol
