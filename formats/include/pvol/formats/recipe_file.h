// Procedural clouds as TOML files.
//
//   [recipe]
//   name = "density"      # of the grid
//   resolution = 256      # samples along the longest side of the box that surely holds the cloud,
//                         # which itself is smaller by what the noise may add; 1..4096; or
//   voxel = 0.01          # distance of samples in world units
//   density = 1.0         # deep inside the cloud
//   edge = 0.02           # world units from the surface to full density
//
//   [cumulus]             # a whole cumulus, after struct Cumulus in pvol/medium/cumulus.h
//   seed = 3
//   width = 2.0
//   height = 1.1         # 0.55 widths where left out
//   towers = 10
//   generations = 3
//   detail = 1.0
//   wisps = 1.0
//
//   [[form]]              # any number; the cloud is their union
//   shape = "ellipsoid"
//   centre = [0, 1, 0]
//   radii = [1, 0.5, 1]   # or one number
//   rotation = [0, 0, 30] # degrees about x, then y, then z
//   steepness = 1.0       # factor on the form's values, which are about distances from the surface
//
//   [[form.perturbation]] # adds strength * max(0, Q)^2, with Q = 1 in the centre of an ellipsoid
//   shape = "ellipsoid"   # any shape, without steepness
//   centre = [0.5, 1, 0]
//   radii = 0.3
//   strength = 0.2        # world units; negative for a dent
//
//   [[cut]]               # as [[form]]; the cloud is what lies inside all of them
//   shape = "half-space"
//   point = [0, 0, 0]
//   inward = [0, 1, 0]
//
//   [[displacement]]      # noise on the surface, after struct Displacement in pvol/medium/recipe.h
//   kind = "billow"       # or "smooth"
//   amplitude = 0.1       # world units
//   cell = 0.2            # world units, size of the largest features
//   octaves = 5           # 1..16
//   gain = 0.5            # (0, 1]
//   seed = 1
//   mask = { shape = "half-space", point = [0, 1, 0], inward = [0, -1, 0], steepness = 2.0 }
//
// The third shape is "quadric", with `coefficients` of x^2, y^2, z^2, yz, zx, xy, x, y, z and 1;
// its values are taken as they are. Keys have the values of the structs where they are left out;
// with neither resolution nor voxel the longest side has 256 samples. A recipe needs [cumulus] or a
// [[form]]; where it has both, the forms, cuts and displacements are added to the cumulus.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "pvol/medium/recipe.h"

namespace pvol::formats {

/// Reads a recipe; Error names file, line, what was found and what was expected. The result is
/// valid in the sense of validate().
[[nodiscard]] Recipe read_recipe(const std::filesystem::path& file);

/// The same for text in memory, which messages call `source`.
[[nodiscard]] Recipe parse_recipe(std::string_view text, const std::string& source);

/// Whether a .toml file is a recipe (it has a [recipe] table) and not a scene.
[[nodiscard]] bool is_recipe(const std::filesystem::path& file);

}  // namespace pvol::formats
