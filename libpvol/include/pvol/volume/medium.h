// What a cloud is made of, besides its density.
#pragma once

#include <vector>

#include "pvol/math/affine.h"

namespace pvol {

/// A kind of matter that takes part in the extinction: droplets, soot, hot gas.
struct Component {
  double share = 0;    ///< of the extinction, everywhere, in [0, 1]
  Rgb albedo{0.999f};  ///< mu_s / mu_t by channel, in [0, 1]
  double g = 0.5;      ///< mean cosine of the Henyey-Greenstein phase function, in (-1, 1)
  Rgb emission{0.0f};  ///< radiance L_e: the component emits mu_a L_e per unit length
  friend bool operator==(const Component&, const Component&) = default;
};

/// Optical properties of a cloud whose density field is known: mu_t = extinction * rho.
struct Medium {
  double extinction = 1;  ///< per world unit and unit of density, >= 0
  Rgb albedo{0.999f};     ///< these three are the first component's, whose share is what the
  double g = 0.5;         ///< others leave
  Rgb emission{0.0f};
  std::vector<Component> others{};  ///< further components; their shares sum up to at most 1
  Affine object_to_world{};         ///< placed after the grid's own index_to_world
  friend bool operator==(const Medium&, const Medium&) = default;
};

}  // namespace pvol
