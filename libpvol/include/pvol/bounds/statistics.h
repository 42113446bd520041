// How tight the bounds of a cloud are, and what that is worth to a tracker.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"

namespace pvol {

/// What a node of a pyramid holds. Mass is the integral of the trilinear density, or of the
/// tricubic one where the bounds are made for that, over the node's cube, in density times cells;
/// it is exact but for rounding.
struct NodeContent {
  double mass = 0;
  bool leaf = false;     ///< nothing below it
  bool uniform = false;  ///< a leaf in which the density is constant
};

/// Contents by level and node, as in `Pyramid::levels`. All masses of a level, with those of the
/// leaves above it, add up to the sum of all samples.
using PyramidContent = std::vector<std::vector<NodeContent>>;
[[nodiscard]] PyramidContent measure_content(const VoxelGrid& grid, const Pyramid& pyramid);

/// Tentative collisions and look-ups for each real collision; at best 1 and 0. Which figure applies
/// depends on where light goes, so there are two:
/// `even`: collisions lie as the density does, as when light reaches every place alike (a cloud
/// thin enough to see through): the integral of the bound over that of the density. `dense`: light
/// is proportional to the mean density of each leaf, as where paths stay in the core of the cloud.
/// Paths in a thick cloud that see its rim alone meet looser bounds than either.
struct CollisionCost {
  double even = 0, dense = 0;
};

/// Bounds that tile the density. Volumes end at the box of the support, as walks do.
struct Tightness {
  CollisionCost majorant;  ///< hi per collision: look-ups of delta tracking
  CollisionCost residual;  ///< hi - lo per collision: look-ups of decomposition tracking
};

/// The pyramid at one depth.
struct DepthStatistics {
  int depth = 0;             ///< 0 is the root
  std::int64_t edge = 0;     ///< of a cube, in cells
  std::uint64_t nodes = 0;   ///< of this depth
  std::uint64_t leaves = 0;  ///< those of them with nothing below
  /// Means over nodes of hi / (mean density in the support's box) and lo / (the same).
  double mean_hi = 0, mean_lo = 0;
  /// For a walk that stops here, or at a leaf above.
  Tightness tightness;
};

/// Leaves of one kind.
struct ClassStatistics {
  std::uint64_t leaves = 0;
  double volume = 0;  ///< in cells
  double mass = 0;
};

struct BoundsStatistics {
  std::vector<DepthStatistics> depths;  ///< from the root down
  double root_volume = 0;               ///< in cells
  ClassStatistics uniform, mixed;
  ClassStatistics empty;  ///< the rest of the root's cube: no leaves, no mass
  double mass = 0;        ///< of the cloud
  /// For one majorant, the largest bound, over the box of the support.
  CollisionCost global_majorant;
};

[[nodiscard]] BoundsStatistics measure_bounds(const Pyramid& pyramid,
                                              const PyramidContent& content);

/// The same for the terminals of a tree built from this pyramid with this extinction > 0.
[[nodiscard]] Tightness measure_cut(const Pyramid& pyramid, const PyramidContent& content,
                                    const Octree& tree, double extinction);

}  // namespace pvol
