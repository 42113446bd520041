// Maps that can be undone.
#pragma once

#include <algorithm>

#include "pvol/math/affine.h"

namespace pvol::formats::detail {

/// Whether the map can be undone in double.
[[nodiscard]] inline bool is_invertible(const Affine& map) {
  const auto is_finite_map = [](const Affine& a) {
    return is_finite(a.t) && std::ranges::all_of(a.m, [](Vec3d row) { return is_finite(row); });
  };
  return is_finite_map(map) && is_finite_map(inverse(map));
}

}  // namespace pvol::formats::detail
