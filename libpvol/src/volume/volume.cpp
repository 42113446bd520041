// Making a cloud ready for rendering.
#include "pvol/volume/volume.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <string>
#include <utility>

#include "pvol/bounds/integrals.h"
#include "pvol/bounds/verify.h"
#include "pvol/error.h"

namespace pvol {
namespace {

std::string text(double v) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", v);
  return buffer;
}

double column_length(const Affine& a, int axis) {
  return length(Vec3d(a.m[0][axis], a.m[1][axis], a.m[2][axis]));
}

/// Positions go from world to cells in double; what they lose is a few ulp of the largest
/// coordinate, seen in cells (THEORY.md, T1.3).
void check_placement(const Affine& to_world, const Affine& to_cells, const Box& world_box) {
  for (int r = 0; r < 3; ++r) {
    if (!is_finite(to_cells.m[std::size_t(r)]) || !std::isfinite(to_cells.t[r]) ||
        !std::isfinite(to_world.t[r])) {
      throw Error(
          "the volume's placement in the world is singular or not finite: it flattens the "
          "cloud. Check the grid's transform and the scene's scale, rotate and matrix.");
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = column_length(to_cells, axis);
    if (!(cells > 1e-30 && cells < 1e30)) {
      throw Error("the volume has " + text(cells) +
                  " voxels per world unit along an axis, expected 1e-30 to 1e30. Check the grid's "
                  "voxel size and the scene's scale.");
    }
  }
  constexpr double kUlps = 4, kMaxLoss = 1e-3;
  double loss = 0;
  for (const Vec3d& row : to_cells.m) {
    const Vec3d reach = max(max(world_box.lo, -world_box.lo), max(world_box.hi, -world_box.hi));
    loss = std::max(loss, kUlps * DBL_EPSILON *
                              dot(Vec3d(std::abs(row.x), std::abs(row.y), std::abs(row.z)), reach));
  }
  if (loss > kMaxLoss) {
    throw Error(
        "the cloud lies so far from the world's origin that positions in it are only known "
        "to " +
        text(loss) + " voxels, where 0.001 are needed. Move it nearer the origin.");
  }
}

void check_majorant_scale(const VolumeOptions& o) {
  const double least = is_weighted(o.tracker) ? 1 / kMostBoundsExcess : 1;
  constexpr double kLargest = 1000;
  if (o.majorant_scale >= least && o.majorant_scale <= kLargest) return;
  throw Error("a majorant scale of " + text(o.majorant_scale) + " is outside [" + text(least) +
              ", 1000]. Below 1 majorants do not bound: that takes one of the trackers with "
              "weights, and 1/3 is the least that they can make up for.");
}

/// About what a look-up costs, in the unit of the model of T2.1; a recipe may be cheaper or dearer.
constexpr double kTricubicCost = 35, kProceduralCost = 1000;

/// Where the density ramps up from 0, a flight meets about sqrt(2 depth per voxel) null collisions
/// before a real one, and steps of 1 / depth voxels: beyond this both get out of hand.
constexpr double kMaxVoxelDepth = 1e12;

/// The length of the longest diagonal of a cell in the world.
double cell_diagonal(const Affine& to_world) {
  double longest = 0;
  for (const Vec3d d : {Vec3d(1, 1, 1), Vec3d(-1, 1, 1), Vec3d(1, -1, 1), Vec3d(1, 1, -1)}) {
    longest = std::max(longest, length(to_world.vector(d)));
  }
  return longest;
}

/// Refuses to homogenise by bounds that do not hold: its bound on the error rests on them.
void require_bounds(const VoxelGrid& grid, const Pyramid& pyramid) {
  const BoundsCheck check = verify_bounds(grid, pyramid);
  if (check.holds()) return;
  throw Error("the bounds do not hold in " + std::to_string(check.wrong.size()) +
              " cubes, so that nothing can be said of homogenised ones. They belong to another "
              "density or were damaged; fit the cloud again, or check it by pvol-stats bounds "
              "--verify.");
}

/// Multiplies the majorants of all terminals. Where they or the minorants need not hold afterwards,
/// minorants move away from majorants: lo = hi would promise that mu_t is known.
void scale_majorants(Volume& v, double factor) {
  v.majorant_excess = std::max(1.0, v.excess.factor / factor);
  const bool doubtful = factor < 1 || v.excess.nodes > 0;
  if (factor == 1 && !doubtful) return;
  for (Octree::Entry& e : v.octree.entries) {
    e.hi = float(double(e.hi) * factor);
    if (doubtful) e.lo = std::min(e.lo, 0.5f * e.hi);
  }
}

/// Whether micro-bounds save more time than they cost, where segments leave much open.
bool pay(const Volume& v, const Pyramid& pyramid, const VolumeOptions& o) {
  // Look-ups in bricks are cheap until they miss the cache: measured on whole renders, micro-bounds
  // cost 3 % of the time with a field of 3 MB and save 7 % with one of 57 MB; with tricubic
  // look-ups 13 % with one of 19 MB.
  constexpr std::size_t kLarge = std::size_t(32) << 20;
  if (v.interpolation == Interpolation::tricubic) return true;
  if (v.interpolation == Interpolation::trilinear || v.interpolation == Interpolation::nearest) {
    return v.field.samples.size() * sizeof(float) > kLarge;
  }
  // Of a recipe those of single cells save some 10 us of a camera sample, half of it, and take 4 ms
  // of a leaf to make.
  constexpr double kSamplesPerLeaf = 400;
  return o.paths > kSamplesPerLeaf * double(pyramid.levels[0].size());
}

/// Edge of the micro-bounds that the options ask for; 0: none.
int micro_edge(const Volume& v, const Pyramid& pyramid, const VolumeOptions& o) {
  constexpr double kOpen = 0.25;  // look-ups per collision without them
  const bool of_use = !is_weighted(o.tracker) && o.tracker != Tracker::regular && !v.octree.empty();
  switch (o.micro_bounds) {
    case MicroBoundsUse::cells_8:
      return of_use ? 2 : 0;
    case MicroBoundsUse::cells_1:
      return of_use ? 1 : 0;
    case MicroBoundsUse::automatic:
      if (!of_use || !pay(v, pyramid, o)) return 0;
      if (integrate_bounds(v.octree).open_share() <= kOpen) return 0;
      return v.interpolation == Interpolation::procedural ? 1 : 2;
    case MicroBoundsUse::none:
      break;
  }
  return 0;
}

/// Whether stored micro-bounds speak of this interpolant: those of files do of two.
bool is_bounded(Interpolation interpolation) {
  return interpolation == Interpolation::nearest || interpolation == Interpolation::trilinear;
}

/// Where a walk should stop, for what look-ups of this kind cost.
Cut choose_cut(const VolumeOptions& o) {
  Cut cut;
  cut.depth = o.tracker == Tracker::delta_global ? 0 : o.depth;
  if (o.interpolation == Interpolation::tricubic) cut.costs.lookup = kTricubicCost;
  if (o.interpolation == Interpolation::procedural) cut.costs.lookup = kProceduralCost;
  return cut;
}

const char* name(Interpolation interpolation) {
  constexpr const char* kNames[] = {"nearest", "trilinear", "tricubic", "procedural"};
  return kNames[std::size_t(interpolation)];
}

void check_interpolation(const Pyramid& pyramid, Interpolation wanted) {
  if (pyramid.empty() || holds_for(pyramid.interpolation, wanted)) return;
  throw Error(std::string("the bounds were made for ") + name(pyramid.interpolation) +
              " interpolation and do not hold for " + name(wanted) +
              "; fit the cloud again with --interpolation " + name(wanted) +
              ", or render it with --interpolation " + name(pyramid.interpolation));
}

/// A volume without its field, and the world length of its cells' edges.
struct Placed {
  Volume volume;
  double cell_length;
};
Placed place(const Affine& index_to_world, const Pyramid& pyramid, const Medium& medium,
             const VolumeOptions& o) {
  check_interpolation(pyramid, o.interpolation);
  const double largest = medium.extinction * double(pyramid.scale);
  if (!(medium.extinction >= 0 && medium.extinction <= double(FLT_MAX) &&
        largest <= double(FLT_MAX))) {
    throw Error("an extinction of " + text(medium.extinction) +
                " per unit of density with a largest "
                "density of " +
                text(double(pyramid.scale)) + " is outside [0, 3.4e38]");
  }
  check_majorant_scale(o);
  const Affine to_world = medium.object_to_world * index_to_world;
  const Affine to_index = inverse(to_world);
  const double cell_length = std::cbrt(std::abs(determinant(to_world)));
  if (largest * cell_length > kMaxVoxelDepth) {
    throw Error(
        "an optical depth of " + text(largest * cell_length) +
        " per voxel is more than paths can resolve (1e12). Check the unit of the extinction.");
  }

  Volume v;
  v.medium = medium;
  v.extinction = float(medium.extinction);
  v.interpolation = o.interpolation;
  v.world_to_cells = translation(-Vec3d(pyramid.origin)) * to_index;
  if (!pyramid.empty()) v.world_box = transform(to_world, pyramid.support());
  check_placement(to_world, v.world_to_cells, v.world_box);
  return {std::move(v), cell_length};
}

}  // namespace

Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid, const Medium& medium,
                   const VolumeOptions& o, const LeafMicroBounds* stored) {
  if (o.interpolation == Interpolation::procedural) {
    throw Error("samples have no procedural look-ups, which are for recipes");
  }
  auto [v, cell_length] = place(grid.index_to_world, pyramid, medium, o);
  FieldOptions rules;
  rules.interpolation = o.interpolation;
  rules.most_excess = is_weighted(o.tracker) ? kMostBoundsExcess * o.majorant_scale : 1;
  HomogenisedPyramid homogenised;
  if (o.homogenise) {
    require_bounds(grid, pyramid);
    const Affine to_world = medium.object_to_world * grid.index_to_world;
    homogenised = homogenise(pyramid, measure_content(grid, pyramid), medium.extinction,
                             cell_diagonal(to_world), *o.homogenise);
    rules.constant = &homogenised.constant;
    v.homogeneous = homogenised.parts;
  }
  const Pyramid& bounds = o.homogenise ? homogenised.pyramid : pyramid;
  FieldWithLinks field = build_field(grid, bounds, rules);
  v.octree = build_octree(bounds, medium.extinction, cell_length, choose_cut(o), field.brick_of,
                          kZeroBrick);
  v.field = std::move(field.field);
  v.excess = field.excess;
  scale_majorants(v, o.majorant_scale);
  if (const int edge = micro_edge(v, bounds, o)) {
    v.micro_stored =
        stored && stored->by_leaf.edge == edge && is_bounded(v.interpolation) && !o.homogenise;
    v.micro = v.micro_stored ? arrange(*stored, v.field, field.brick_of, pyramid)
                             : build_micro_bounds(v.field, edge);
  }
  return std::move(v);
}

Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                   const Medium& medium, const VolumeOptions& o) {
  if (o.interpolation != Interpolation::procedural) {
    throw Error("a recipe without samples has procedural look-ups only; sample it with make_grid");
  }
  if (o.homogenise) {
    throw Error("procedural look-ups leave nothing to homogenise; choose another interpolation");
  }
  auto [v, cell_length] = place(scaling(Vec3d(recipe->voxel)), pyramid, medium, o);
  ProceduralWithLinks field = make_procedural_field(std::move(recipe), pyramid);
  v.octree = build_octree(pyramid, medium.extinction, cell_length, choose_cut(o), field.brick_of,
                          kZeroBrick);
  v.procedure = std::move(field.field);
  scale_majorants(v, o.majorant_scale);
  if (const int edge = micro_edge(v, pyramid, o)) {
    v.micro = build_micro_bounds(*v.procedure, edge);
  }
  return std::move(v);
}

}  // namespace pvol
