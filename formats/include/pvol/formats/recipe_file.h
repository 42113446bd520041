// Procedural clouds as TOML files.
//
//   [recipe]
//   name = "density"      # of the grid
//   resolution = 256      # samples along the longest side of the box that surely holds the cloud,
//                         # which itself is smaller by what the noise may add; 1..4096; or
//   voxel = 0.01          # distance of samples in world units
//   density = 1.0         # deep inside the cloud
//   edge = 0.02           # world units from the surface to full density
//   profile = "linear"    # how it rises over the edge; or "smooth"; or points [depth, density] in
//                         # units of edge and density, the first density 0, say
//                         # [[0, 0], [1, 1], [4, 0.5]]
//
//   [cumulus]             # a whole cumulus, after struct Cumulus in pvol/density/cumulus.h
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
//   scale = [1, 2, 1]     # or one number; the form is first scaled about the origin, then
//   rotate = [0, 90, 0]   # turned about the origin, degrees about x, then y, then z, then
//   translate = [0, 0, 5] # moved; its values are scaled by the least of the three factors
//
//   [[form.perturbation]] # adds strength * max(0, Q)^2, with Q = 1 in the centre of an ellipsoid
//   shape = "ellipsoid"   # any shape, without steepness
//   centre = [0.5, 1, 0]
//   radii = 0.3
//   strength = 0.2        # world units; negative for a dent
//
//   [[form.perturbation.perturbation]]  # bends Q itself, and so on; here without unit
//   shape = "ellipsoid"
//   centre = [0.6, 1, 0]
//   radii = 0.1
//   strength = 2.0
//
//   [[form]]              # in place of a shape: a tree of parts, each of them as [[form]]
//   op = "difference"     # the first part without the others; "union", "intersection"
//   part = [{ use = "rock" }, { use = "caves", rotate = [0, 90, 0] }]   # or [[form.part]] tables
//
//   [[body.rock]]         # in place of a shape or op: use = NAME, the body that these tables make,
//   shape = "ellipsoid"   # as [[form]], the union of those with the same name. Bodies may use one
//   centre = [0, 0, 0]    # another.
//   radii = 1
//
//   [[cut]]               # as [[form]]; the cloud is what lies inside all of them
//   shape = "half-space"
//   point = [0, 0, 0]
//   inward = [0, 1, 0]
//
//   [[displacement]]      # noise on the surface, after struct MaskedNoise in pvol/density/recipe.h
//   kind = "billow"       # or "smooth"
//   amplitude = 0.1       # world units
//   cell = 0.2            # world units, size of the largest features
//   octaves = 5           # 1..16
//   gain = 0.5            # (0, 1]
//   seed = 1
//   mask = { shape = "half-space", point = [0, 1, 0], inward = [0, -1, 0], steepness = 2.0 }
//
//   [[modulation]]        # noise on the density: factor max(0, 1 + sum of modulations)
//   amplitude = 0.5       # without unit; all keys as [[displacement]]
//   cell = 0.2
//
//   [[solid]]             # a dense region, also inside the cloud: the density is the larger one
//   density = 1.0         # deep inside
//   edge = 0.02           # world units from its surface to that density
//
//   [[solid.form]]        # one or more, and [[solid.cut]]: as [[form]] and [[cut]]
//   shape = "ellipsoid"
//   centre = [0, 1, 0]
//   radii = 0.2
//
// clang-format off
//   [flow]                # how the recipe moves, for motion blur; struct Flow in pvol/density/flow.h
//   velocity = [0, 1, 0]  # world units per second, everywhere
//   spin = [0, 90, 0]     # degrees per second about axes through the centre
//   stretch = [0, 0, 0]   # growth per second along the axes, from the centre
//   centre = [0, 0, 0]
//   turbulence = 0.5      # world units per second, of a noise
//   cell = 0.2            # its keys as of [[displacement]]
//   octaves = 4
//   gain = 0.5
//   seed = 1
// clang-format on
//
// The third shape is "quadric", with `coefficients` of x^2, y^2, z^2, yz, zx, xy, x, y, z and 1;
// its values are taken as they are. Keys have the values of the structs where they are left out;
// with neither resolution nor voxel the longest side has 256 samples. A recipe needs [cumulus], a
// [[form]] or a [[solid]]; beside [cumulus], forms, cuts and displacements are added to its own.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "pvol/density/flow.h"
#include "pvol/density/recipe.h"

namespace pvol::formats {

/// Reads a recipe; Error names file, line, what was found and what was expected. The result is
/// valid in the sense of validate().
[[nodiscard]] Recipe read_recipe(const std::filesystem::path& file);

/// The same for text in memory, which messages call `source`.
[[nodiscard]] Recipe parse_recipe(std::string_view text, const std::string& source);

/// How a recipe moves; nothing where it does not say. Errors as above.
[[nodiscard]] std::optional<Flow> read_flow(const std::filesystem::path& file);
[[nodiscard]] std::optional<Flow> parse_flow(std::string_view text, const std::string& source);

/// Whether a .toml file is a recipe (it has a [recipe] table) and not a scene.
[[nodiscard]] bool is_recipe(const std::filesystem::path& file);

}  // namespace pvol::formats
