// A cloud made ready for rendering: density in bricks, bounds as a tree with its cut chosen.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/leaf_micro_bounds.h"
#include "pvol/bounds/micro_bounds.h"
#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/math/box.h"
#include "pvol/medium/brick_field.h"
#include "pvol/medium/procedural.h"
#include "pvol/render/scene.h"
#include "pvol/shell/ray_shell.h"

namespace pvol {

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

/// Figures about a volume that tools print at load, because a wrong unit is the commonest mistake.
struct VolumeFacts {
  double largest_extinction = 0;                 ///< per world unit
  double shortest_free_path = 0;                 ///< world units, at the largest extinction
  double mean_optical_thickness[3] = {0, 0, 0};  ///< along the index axes, over columns that hit
  double largest_optical_thickness = 0;          ///< over all those columns
  double null_collisions = 0;                    ///< see worst_null_collisions
  int depth = 0;                                 ///< largest octree depth at which the walk stops
  std::uint64_t nodes = 0;                       ///< of the tree, those below the cut included
  std::uint64_t terminals = 0;                   ///< at which the walk stops
  std::uint64_t field_bytes = 0, octree_bytes = 0;
};

/// Makes a cloud ready for the scene's medium, interpolation and tracker: the walk stops at
/// options.depth or, without it, where the cost model says (THEORY.md, T5); at the root for the
/// tracker delta_global. Micro-bounds are made where options.micro_bounds asks for them: of those
/// `stored`, where they are there and of the size that is wanted, else built.
/// Trackers with weights take bounds up to kMostBoundsExcess too low, options.majorant_scale
/// included. Throws Error where bounds or stored micro-bounds do not hold for the grid otherwise or
/// were not made for the scene's interpolation, the map is singular, the extinction is negative or
/// too large for a float, or the placement is so far from the origin that positions lose more than
/// 1/1000 of a voxel.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid, const Scene& scene,
                                 const LeafMicroBounds* stored = nullptr);

/// The same for procedural look-ups, which the scene must ask for. The pyramid is that of
/// build_pyramid(*recipe, ...); cells are the recipe's voxels.
[[nodiscard]] Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                                 const Scene& scene);

/// About how many null collisions a ray meets in the thin part of the worst segment.
[[nodiscard]] double worst_null_collisions(const Volume& volume);

[[nodiscard]] VolumeFacts describe(const Volume& volume, const VoxelGrid& grid,
                                   const Medium& medium);

/// The same for procedural look-ups. The largest density and the thickness are estimates from
/// samples of the recipe, kCoarseResolution along its longest side.
[[nodiscard]] VolumeFacts describe(const Volume& volume, const Recipe& recipe,
                                   const Medium& medium);
inline constexpr int kCoarseResolution = 64;

}  // namespace pvol
