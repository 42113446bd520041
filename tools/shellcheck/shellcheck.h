// An independent check that a shell holds its cloud, with exact arithmetic and geometry from CGAL.
//
// Nothing here uses the certificate or the arithmetic behind it. CGAL stays inside the sources; a
// binary that links them is GPL-3.0-or-later as a whole.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol {

struct ShellCheckOptions {
  std::uint64_t points = 1'000'000;  ///< of the boundary's lattice points, evenly thinned to this
  std::uint64_t rational_points = 2000;  ///< the tightest points, always decided in rationals
  int mesh_resolution = 128;             ///< first one tried for the shell's mesh, 8 to 512
  std::uint64_t mesh_points = 200'000;  ///< of the boundary's lattice points, thinned to about this
};

/// A point of a closed occupied cell that the shell does not hold.
struct ShellWitness {
  Vec3d index;       ///< index space
  std::string what;  ///< cuts it off: "the box", "the form" or "dent 7", counted from 0
  double value = 0;  ///< the slack there: below 0; 0 for the box
};

/// What was found. Distances and the mesh's step are in cells.
struct ShellCheck {
  bool contained = false;               ///< no point outside by exact signs
  std::optional<ShellWitness> witness;  ///< the worst point found, if any
  std::uint64_t points =
      0;  ///< whose sign was decided, by intervals or, failing that, by rationals
  std::uint64_t rational = 0;  ///< of these by rationals
  std::uint64_t cells = 0;  ///< over which the exact greatest value of each dent was found not to
                            ///< be above 0

  bool mesh_contained =
      false;             ///< no boundary point farther outside the shell's mesh than it is fine
  double mesh_step = 0;  ///< the mesh lies within sqrt(3) steps of the shell's surface
  /// Directed Hausdorff distances from the boundary of the cells to the shell's surface, and from
  /// that to the cells. They are upper bounds: the true ones lie at most `excess` below, where the
  /// shell has no walls thinner than the mesh's step.
  double support_to_shell = 0, support_to_shell_excess = 0;
  double shell_to_support = 0, shell_to_support_excess = 0;

  double shell_volume_ratio = 0;      ///< volume inside the shell's mesh over that of the support
  double ellipsoid_volume_ratio = 0;  ///< of the least ellipsoid around it, at most 1 % too large
  double hull_volume_ratio = 0;       ///< of its convex hull
};

/// Checks a shell against a support that is not empty.
///
/// Exact signs of the slack are taken at the lattice points of the support's boundary, at corners
/// of octree nodes inside it, at points 1/4 cell apart in the cells around the tightest of them,
/// and at the critical point of each quadric that lies in an occupied cell. For hard shells the
/// greatest value of each dent over those cells is exact as well, not sampled. Deterministic.
/// Throws Error for an empty support and options out of range.
[[nodiscard]] ShellCheck check_shell(const Shell& shell, const Support& support,
                                     const ShellCheckOptions& options = {});

/// A few lines of plain text for people.
[[nodiscard]] std::string describe(const ShellCheck& check);

}  // namespace pvol
