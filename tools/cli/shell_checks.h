// CGAL's check of a shell, where pvol was built with CGAL.
#pragma once

#include <string>

#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol::cli {

/// Whether pvol was built with CGAL.
[[nodiscard]] bool can_check_shells();

/// What a check found. Distances in voxels between the cloud's boundary and the shell's surface,
/// directed Hausdorff distances and upper bounds of them; volumes over the cloud's own.
struct CheckedShell {
  std::string text;  ///< a report of some lines
  double cloud_to_shell = 0, shell_to_cloud = 0;
  double volume_ratio = 0, ellipsoid_volume_ratio = 0, hull_volume_ratio = 0;
};

/// Checks the shell in exact arithmetic. Throws Error that names
/// a point of the cloud where the shell does not hold it, and where pvol was built without CGAL.
[[nodiscard]] CheckedShell check_shell(const Shell& shell, const Support& support);

}  // namespace pvol::cli
