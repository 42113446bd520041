// Shapes of pbrt that bound media.
#pragma once

#include "pbrt/pbrt_description.h"
#include "pvol/math/box.h"

namespace pvol::formats::detail {

/// A box, or the ball that touches its sides, in the shape's own space.
struct PbrtHull {
  Box box;
  bool is_ball = false;
};

/// Of a whole sphere, or of triangles whose corners are all eight of a box; nothing of others.
[[nodiscard]] std::optional<PbrtHull> hull_of(const PbrtShape& shape);

/// Whether the hull holds the image of a box under a map, but for a thousandth of its size.
[[nodiscard]] bool contains(const PbrtHull& hull, const Affine& map, const Box& box);

/// The factor of a map that keeps angles; nothing of others.
[[nodiscard]] std::optional<double> even_scale(const Affine& map);

/// Whether a sphere is one, not a part cut off by heights or angles.
[[nodiscard]] bool is_whole_sphere(const PbrtShape& sphere);

}  // namespace pvol::formats::detail
