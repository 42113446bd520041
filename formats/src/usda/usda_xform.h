// Where prims are.
#pragma once

#include <optional>

#include "pvol/math/affine.h"
#include "usda/usda_view.h"

namespace pvol::formats::detail {

/// A place at the frame, and one frame later.
struct UsdPlace {
  Affine now{}, later{};
  [[nodiscard]] bool moves() const { return !(now == later); }
  [[nodiscard]] friend UsdPlace operator*(const UsdPlace& a, const UsdPlace& b) {
    return {a.now * b.now, a.later * b.later};
  }
};

/// From a prim's space to that around it, by its xformOpOrder.
struct UsdXform {
  UsdPlace place{};
  bool resets = false;  ///< whether that around it is the world
};
[[nodiscard]] UsdXform xform_of(const UsdView& now);

/// The factor of a map that scales all directions alike; nothing of others.
[[nodiscard]] std::optional<double> uniform_scale(const Affine& map);

/// A turn by a quaternion of any length: its real part, then the others. That of length 0, which
/// programs write for what has no orientation, turns nothing.
[[nodiscard]] Affine turn_of(const std::array<double, 4>& quaternion);

}  // namespace pvol::formats::detail
