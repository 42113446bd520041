// Triangles of UsdGeom's shapes.
#pragma once

#include "pvol/math/triangle_mesh.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {

/// In the shape's own space. Throws Error for faces of points that are not there.
[[nodiscard]] TriangleMesh triangles_of(const UsdView& shape, const UsdMaking& making);

}  // namespace pvol::formats::detail
