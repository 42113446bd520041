// The smallest ellipsoid around a set of points.
#pragma once

#include "pvol/form/quadric.h"
#include "shell/fit/points.h"

namespace pvol::detail {

/// A quadric F, 1 at its greatest, with F >= 0 at every point (but for float rounding): the
/// ellipsoid of least volume to about one percent. The points must not all lie in one plane.
/// Based on: Khachiyan. Rounding of Polytopes in the Real Number Model of Computation. 1996, with
/// the away steps of Todd, Yildirim. On Khachiyan's Algorithm for the Computation of Minimum-Volume
/// Enclosing Ellipsoids. 2007.
[[nodiscard]] Quadric enclosing_ellipsoid(const Points& points);

}  // namespace pvol::detail
