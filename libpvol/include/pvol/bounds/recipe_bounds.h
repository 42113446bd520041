// Bounds of a recipe straight from its closed form, without samples.
#pragma once

#include <cstdint>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/recipe.h"

namespace pvol {

/// Default below: octants of 4^3 cells.
inline constexpr int kLeafRefinement = 1;

/// The pyramid of a recipe from density_range() over the closed boxes of its leaves (T8.1): bounds
/// of the density at every point, rounded to float: for procedural look-ups, and so for trilinear
/// and nearest ones of its samples. They are wider than those of build_pyramid(make_grid(recipe)),
/// leaf by leaf. Each leaf is divided `refine` times (0..3) into octants whose ranges are joined: 8
/// times the work for each, and tighter. Cubes of one density become uniform nodes. The box of the
/// support is as tight as those octants.
///
/// In parallel; the same for any number of threads. Throws Error as validate(recipe) does, for
/// another refinement, and where there are more than `max_leaves` leaves and uniform cubes.
[[nodiscard]] Pyramid build_pyramid(const Recipe& recipe, int refine = kLeafRefinement,
                                    std::uint64_t max_leaves = std::uint64_t(1) << 26);

}  // namespace pvol
