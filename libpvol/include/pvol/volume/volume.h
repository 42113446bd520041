// A cloud made ready for rendering: density in bricks, bounds as a tree with its cut chosen.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/field/procedural.h"
#include "pvol/math/box.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/medium.h"

namespace pvol {

/// Which micro-bounds decide tentative collisions before the density is looked up. The picture is
/// the same to the last bit; trackers with weights do not use them.
enum class MicroBoundsUse {
  automatic,  ///< where segments leave much open and look-ups cost: cubes of 2^3 cells for tricubic
              ///< fields and those that miss the cache, single cells for large pictures of recipes
  none,
  cells_8,  ///< for cubes of 2^3 cells
  cells_1,  ///< for single cells
};

/// What a volume is made for, besides its medium.
struct VolumeOptions {
  Interpolation interpolation = Interpolation::trilinear;
  MicroBoundsUse micro_bounds = MicroBoundsUse::automatic;  ///< never changes a result
  std::optional<int> depth{};  ///< octree depth at which walks stop, 0..16; else by cost
  Tracker tracker = Tracker::decomposition;
  /// Factor on majorants, for measurements: above 1 bounds get looser and the picture stays the
  /// same; below 1, down to 1/3, they do not bound, which takes a tracker with weights.
  double majorant_scale = 1;
  /// Biased: nodes of the octree that can change the optical depth of a ray through them by no more
  /// than this count as homogeneous (homogenise.h).
  std::optional<double> homogenise{};
  /// Paths that are expected, for `automatic` micro-bounds of recipes, which take long to make.
  double paths = std::numeric_limits<double>::infinity();
};

/// Everything a tracker needs to know of a cloud, for one extinction and placement. Immutable and
/// safe to read from any thread.
struct Volume {
  BrickField field;                                    ///< empty where look-ups are procedural
  std::shared_ptr<const ProceduralField> procedure{};  ///< null where they are not
  Octree octree;
  MicroBounds micro;          ///< for the squeeze; of edge 0 where there is none
  bool micro_stored = false;  ///< whether they were given, not built
  Medium medium;              ///< that it was made for
  float extinction = 0;  ///< mu_t = extinction * rho, rounded once for bounds and look-ups alike
  Interpolation interpolation = Interpolation::trilinear;  ///< of the scene that it was made for
  /// The largest factor by which mu_t may exceed a majorant: 1 but for trackers with weights.
  double majorant_excess = 1;
  BoundsExcess excess;  ///< of the pyramid's bounds; without nodes where they hold
  std::optional<HomogeneousParts> homogeneous;  ///< where options.homogenise asked for them
  Affine world_to_cells;                        ///< world to cells from the octree's origin
  Box world_box;                                ///< around the support; empty for an empty cloud
  /// Tested by camera rays before they enter the octree, in its cells; see choose_shell.
  std::optional<RayShell> shell;
};

/// What look-ups of a volume with this interpolation read (track/field.h). Refers to the volume.
template <Interpolation kInterpolation>
[[nodiscard]] auto extinction_source(const Volume& v) {
  if constexpr (kInterpolation == Interpolation::procedural) {
    return ProceduralExtinction{*v.procedure, v.octree, v.extinction};
  } else {
    return BrickExtinction<kInterpolation>{v.field, v.octree, v.extinction};
  }
}

/// Makes a cloud ready for a medium, an interpolation and a tracker: the walk stops at
/// options.depth or, without it, where the cost model says (THEORY.md, T2.1); at the root for the
/// tracker delta_global. Micro-bounds are made where options.micro_bounds asks for them: of those
/// `stored`, where they are there and of the size that is wanted, else built.
/// Trackers with weights take bounds up to kMostBoundsExcess too low, options.majorant_scale
/// included. Throws Error where bounds or stored micro-bounds do not hold for the grid otherwise or
/// were not made for the interpolation, the map is singular, the extinction is negative or too
/// large for a float, or the placement is so far from the origin that positions lose more than
/// 1/1000 of a voxel.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options,
                                 const LeafMicroBounds* stored = nullptr);

/// The same for procedural look-ups, which the options must ask for. The pyramid is that of
/// build_pyramid(*recipe, ...); cells are the recipe's voxels.
[[nodiscard]] Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options);

}  // namespace pvol
