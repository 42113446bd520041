// A cloud made ready for rendering: density in bricks, bounds as a tree with its cut chosen.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/octree.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/density/density.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/field/procedural.h"
#include "pvol/math/box.h"
#include "pvol/math/names.h"
#include "pvol/shell/shell.h"
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
[[nodiscard]] constexpr auto names(MicroBoundsUse) {
  return std::to_array<Named<MicroBoundsUse>>({
      {MicroBoundsUse::automatic, "auto"},
      {MicroBoundsUse::none, "none"},
      {MicroBoundsUse::cells_8, "2"},
      {MicroBoundsUse::cells_1, "1"},
  });
}

/// What a volume is made for, besides its medium.
struct VolumeOptions {
  /// Placed after the density's own map, index to object.
  Affine object_to_world{};
  LookUp look_up = LookUp::trilinear;                       ///< of samples; recipes are evaluated
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

/// What look-ups read: samples in bricks, or a recipe.
using FieldValues = std::variant<BrickField, std::shared_ptr<const ProceduralField>>;

/// A field of a volume, made ready for walks and look-ups: its bounds as a tree that is cut, its
/// values, and where its cells lie.
struct VolumeField {
  std::string name;    ///< of the grid or recipe
  FieldValues values;  ///< looked up in bricks that the octree's handles name
  LookUp look_up = LookUp::trilinear;
  Octree octree;              ///< of bounds of scale * value
  float scale = 1;            ///< rounded once for bounds and look-ups alike
  MicroBounds micro;          ///< of values, for the squeeze; of edge 0 where there is none
  bool micro_stored = false;  ///< whether they were given, not built
  Affine world_to_cells;      ///< world to cells from the octree's origin
  Box world_box;              ///< around the support; empty for an empty field
  /// The largest factor by which scale * value may exceed a majorant: 1 but for trackers with
  /// weights.
  double majorant_excess = 1;
  BoundsExcess excess;  ///< of the pyramid's bounds; without nodes where they hold
  std::optional<HomogeneousParts> homogeneous;  ///< where options.homogenise asked for them

  /// The bricks of samples; the field is no recipe.
  [[nodiscard]] const BrickField& bricks() const { return std::get<BrickField>(values); }
  /// The recipe; the field has no samples.
  [[nodiscard]] const ProceduralField& recipe() const { return *std::get<1>(values); }
  [[nodiscard]] std::uint64_t value_bytes() const;
};

/// Everything a tracker needs to know of a cloud, for one extinction and placement. Safe to read
/// from any thread. The medium's components may be exchanged for others; its extinction and the
/// placement are those of the bounds.
struct Volume {
  Medium medium{};
  Affine object_to_world{};
  VolumeField density{};  ///< scaled to mu_t by the medium's extinction
  /// Certified to hold the density, in its index space; a plan decides whether rays test it.
  std::optional<Shell> shell{};
  std::string name{};  ///< for messages
};

/// What look-ups of this kind read (track/field.h). Refers to the field.
template <LookUp kLookUp>
[[nodiscard]] auto extinction_source(const VolumeField& f) {
  if constexpr (kLookUp == LookUp::procedural) {
    return ProceduralExtinction{f.recipe(), f.octree, f.scale};
  } else {
    return BrickExtinction<kLookUp>{f.bricks(), f.octree, f.scale};
  }
}

/// f(constant), and its result, with the field's kind of look-up as a std::integral_constant.
template <class F>
decltype(auto) visit_look_up(LookUp look_up, const F& f) {
  switch (look_up) {
    case LookUp::nearest:
      return f(std::integral_constant<LookUp, LookUp::nearest>{});
    case LookUp::tricubic:
      return f(std::integral_constant<LookUp, LookUp::tricubic>{});
    case LookUp::procedural:
      return f(std::integral_constant<LookUp, LookUp::procedural>{});
    case LookUp::trilinear:
      break;
  }
  return f(std::integral_constant<LookUp, LookUp::trilinear>{});
}

/// Makes a cloud ready for a medium, a way of look-up and a tracker: the walk stops at
/// options.depth or, without it, where the cost model says (THEORY.md, T2.1); at the root for the
/// tracker delta_global. Micro-bounds are made where options.micro_bounds asks for them: of those
/// `stored`, where they are there and of the size that is wanted, else built.
/// Trackers with weights take bounds up to kMostBoundsExcess too low, options.majorant_scale
/// included. Throws Error where bounds or stored micro-bounds do not hold for the density otherwise
/// or were not made for the way of look-up, the map is singular, the medium is out of range or its
/// extinction too large for a float, or the placement is so far from the origin that positions lose
/// more than 1/1000 of a voxel.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options,
                                 const LeafMicroBounds* stored = nullptr);

/// The same for a recipe, which is not null. The pyramid is that of build_pyramid(*recipe, ...);
/// cells are the recipe's voxels. Throws Error for options.homogenise, too.
[[nodiscard]] Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options);

/// The same for either.
[[nodiscard]] Volume make_volume(const Density& density, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options,
                                 const LeafMicroBounds* stored = nullptr);

}  // namespace pvol
