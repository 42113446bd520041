// The support of a recipe straight from its closed form, without samples.
#pragma once

#include "pvol/density/recipe.h"
#include "pvol/shell/support.h"

namespace pvol {

/// Default below: cubes of 2^3 cells.
inline constexpr int kSupportBlockLog2 = 1;

/// The cells in which density_range() leaves room for density, decided for cubes of 2^block_log2
/// cells at once (0..3, single cells to blocks of 8^3): a superset of the cells of
/// make_support(make_grid(recipe), ...). In parallel; the same for any number of threads. Throws
/// Error as validate(recipe) does.
[[nodiscard]] Support make_support(const Recipe& recipe, int block_log2 = kSupportBlockLog2);

}  // namespace pvol
