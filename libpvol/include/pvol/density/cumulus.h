// A fair-weather cumulus: puffs on puffs over a flat base.
#pragma once

#include <cstdint>

#include "pvol/density/recipe.h"

namespace pvol {

/// What an artist says of a cumulus. It stands on the plane y = 0 around the y axis, in world
/// units.
struct Cumulus {
  std::uint64_t seed = 1;  ///< another seed, another cloud of the same kind
  double width = 2;        ///< across, > 0
  double height = 1.1;     ///< of the highest tower, in [0.2, 2] widths
  int towers = 10;         ///< columns of the body, in 1..kMostTowers
  int generations = 3;     ///< of puffs that grow on puffs of twice their size, in 0..3
  double detail = 1;       ///< strength of the billows on the surface, in [0, 2]
  double wisps = 1;        ///< strength of the fraying of base and edges, in [0, 2]
  friend bool operator==(const Cumulus&, const Cumulus&) = default;
};
inline constexpr int kMostTowers = 24;

/// The recipe, with a voxel of 1/256 of its longest side. Throws Error for values out of range.
[[nodiscard]] Recipe make_recipe(const Cumulus& cumulus);

}  // namespace pvol
