// Distances between meshes, and the bodies that shells are compared with.
#pragma once

#include "pvol/shell/mesh.h"
#include "shellcheck.h"

namespace pvol::detail {

/// Fills in what the meshes tell. `boundary` is the mesh of the support.
void check_meshes(const Shell& shell, const Support& support, const TriangleMesh& boundary,
                  const ShellCheckOptions& options, ShellCheck& check);

/// Fills in the volumes of the least ellipsoid and of the convex hull.
void compare_with_baselines(const Support& support, const TriangleMesh& boundary,
                            ShellCheck& check);

}  // namespace pvol::detail
