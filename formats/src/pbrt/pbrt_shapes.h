// pbrt's shapes as triangles.
#pragma once

#include "pbrt/pbrt_description.h"
#include "pvol/math/triangle_mesh.h"

namespace pvol::formats::detail {

/// In the shape's own space: trianglemesh and bilinearmesh by their vertices; sphere, disk and
/// cylinder in steps of a few degrees, which is named. Without triangles, and named, for others.
/// Throws Error for vertices that are not there.
[[nodiscard]] TriangleMesh triangles_of(const PbrtShape& shape, ImportNotes& notes);

}  // namespace pvol::formats::detail
