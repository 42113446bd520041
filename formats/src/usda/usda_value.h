// Values of usda text.
#pragma once

#include "usda/usda_prim.h"
#include "usda/usda_tokens.h"

namespace pvol::formats::detail {

/// What comes next as a value. Where it `says_arcs`, a prim may follow a file, and a shift of its
/// time both. Throws Error for what is none.
[[nodiscard]] UsdValue read_value(UsdTokens& in, bool says_arcs = false);

/// { time: value, ... }, by time.
[[nodiscard]] std::vector<std::pair<double, UsdValue>> read_samples(UsdTokens& in);

/// Passes what comes next between an opening bracket and the one that closes it.
void skip_enclosed(UsdTokens& in);

}  // namespace pvol::formats::detail
