// Triangles for people and for other programs: the surface of a shell and of a support.
#pragma once

#include "pvol/math/triangle_mesh.h"
#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol {

// Meshes of this header are closed surfaces in index space: triangles run counter-clockwise as seen
// from outside, and each edge belongs to exactly two, in opposite directions, where the surface
// does not touch itself.

/// The surface of a shell, the faces of its box included, by marching tetrahedra over `resolution`
/// steps along the box's longest side (8 to 1024); vertices lie on the surface to 1/1000 of a step.
[[nodiscard]] TriangleMesh make_mesh(const Shell& shell, int resolution = 128);

/// The boundary of the occupied cells: two triangles for each face between an occupied cell and one
/// that is not.
[[nodiscard]] TriangleMesh make_mesh(const Support& support);

/// Volume inside a closed mesh.
[[nodiscard]] double volume(const TriangleMesh& mesh);

}  // namespace pvol
