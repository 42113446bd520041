// Making a cloud ready for rendering.
#include "pvol/volume/make_volume.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <string>
#include <utility>

#include "field/cube_range.h"
#include "math/digits.h"
#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/integrals.h"
#include "pvol/bounds/map_pyramid.h"
#include "pvol/error.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/field/procedural.h"
#include "pvol/field/sample_codes.h"
#include "pvol/field/shared_field.h"
#include "volume/cell_look_up.h"
#include "volume/field_checks.h"
#include "volume/field_samples.h"
#include "volume/linked_bricks.h"
#include "volume/placement.h"

namespace pvol {
namespace {

void check_majorant_scale(const VolumeOptions& o) {
  const double least = is_weighted(o.tracker) ? 1 / kMostBoundsExcess : 1;
  if (o.majorant_scale >= least && o.majorant_scale <= kMostMajorantScale) return;
  throw Error("a majorant scale of " + detail::digits(o.majorant_scale, 6) + " is outside [" +
              detail::digits(least, 6) + ", " + detail::digits(kMostMajorantScale, 6) +
              "]. Below 1, majorants are no bounds: that needs a weighted tracker, and 1/3 is the "
              "least for which it can compensate.");
}

/// About what a look-up costs, in the unit of the model of T2.1; a recipe may be cheaper or dearer.
constexpr double kTricubicCost = 35, kProceduralCost = 1000;

/// Where the density ramps up from 0, a flight meets about sqrt(2 depth per voxel) null collisions
/// before a real one, and steps of 1 / depth voxels: beyond this both get out of hand.
constexpr double kMaxVoxelDepth = 1e12;

/// Multiplies the majorants of all terminals. Where they or the minorants need not hold afterwards,
/// minorants move away from majorants: lo = hi would promise that mu_t is known.
void scale_majorants(VolumeField& v, double factor) {
  v.majorant_scale = factor;
  v.majorant_excess = std::max(1.0, v.excess.factor / factor);
  const bool doubtful = factor < 1 || v.excess.nodes > 0;
  if (factor == 1 && !doubtful) return;
  for (Octree::Entry& e : v.octree.entries) {
    e.hi = float(double(e.hi) * factor);
    if (doubtful) e.lo = std::min(e.lo, 0.5f * e.hi);
  }
}

/// Whether trackers ask no more of values than on which side of a number they lie, so that bounds
/// of them, which a map would not let hold, may decide.
bool decides_by_bounds(const VolumeOptions& o) {
  return o.map == nullptr && !is_weighted(o.tracker) && o.tracker != Tracker::regular;
}

/// Whether codes of the samples are to decide: in all pictures that they serve, since they are made
/// in the pass that checks the samples, and bounds of small cubes follow from them faster.
bool decides_by_codes(const Pyramid& pyramid, const VolumeOptions& o) {
  const bool wanted = o.micro_bounds == MicroBoundsUse::codes ||
                      (o.micro_bounds == MicroBoundsUse::automatic && std::isfinite(o.paths));
  return wanted && !pyramid.empty() && decides_by_bounds(o) && has_closed_form(o.look_up);
}

/// Whether look-ups are to read a grid's samples where they are.
bool shares_samples(const VoxelGrid& grid, const Pyramid& pyramid, const VolumeOptions& o) {
  if (o.samples != SampleStorage::automatic) return o.samples == SampleStorage::shared;
  return decides_by_codes(pyramid, o) && std::isfinite(o.paths) && grid.owner != nullptr &&
         !o.homogenise;
}

/// The edge of the cubes whose micro-bounds save more time than they cost in a field without codes,
/// whose segments leave much open; 0: none do.
int choose_edge(const VolumeField& v, const Pyramid& pyramid, const VolumeOptions& o) {
  if (v.look_up == LookUp::procedural) {
    // They save some 10 us of a camera sample, half of it, and take 4 ms of a leaf to make.
    constexpr double kSamplesPerLeaf = 400;
    return o.paths > kSamplesPerLeaf * double(pyramid.levels[0].size()) ? 1 : 0;
  }
  if (v.look_up == LookUp::tricubic) return 2;  // 13 % of the time of a field of 19 MB
  // Who traces rays of their own gains little by them; they pay where look-ups miss the cache.
  constexpr std::size_t kLarge = std::size_t(32) << 20;
  return v.value_bytes() > kLarge ? 2 : 0;
}

/// The edge of the cubes whose micro-bounds are to decide collisions; 0: none are.
int edge_for(const VolumeField& v, const Pyramid& pyramid, const VolumeOptions& o) {
  constexpr double kOpen = 0.25;  // look-ups per collision without
  if (!decides_by_bounds(o) || v.octree.empty() || v.codes != nullptr) return 0;
  switch (o.micro_bounds) {
    case MicroBoundsUse::edge_2:
      return 2;
    case MicroBoundsUse::edge_1:
    case MicroBoundsUse::codes:  // of tricubic look-ups and recipes
      return 1;
    case MicroBoundsUse::automatic:
      return integrate_bounds(v.octree).open_share() > kOpen ? choose_edge(v, pyramid, o) : 0;
    case MicroBoundsUse::none:
      break;
  }
  return 0;
}

/// Gives a field micro-bounds where they are to decide collisions in it.
void add_micro_bounds(VolumeField& f, const Pyramid& pyramid, const VolumeOptions& o,
                      const detail::GetMicroBounds& micro_bounds) {
  if (const int edge = edge_for(f, pyramid, o); edge > 0) f.micro = micro_bounds(edge);
}

/// Where a walk should stop, for what look-ups of this kind cost.
Cut choose_cut(const VolumeOptions& o, LookUp look_up) {
  Cut cut;
  cut.depth = o.tracker == Tracker::delta_global ? 0 : o.depth;
  if (look_up == LookUp::tricubic) cut.costs.lookup = kTricubicCost;
  if (look_up == LookUp::procedural) cut.costs.lookup = kProceduralCost;
  return cut;
}

void check_look_up(const Pyramid& pyramid, LookUp wanted) {
  if (pyramid.empty() || holds_for(pyramid.look_up, wanted)) return;
  throw Error(std::string("the bounds were made for ") + name(pyramid.look_up) +
              " interpolation and do not hold for " + name(wanted) +
              "; fit the cloud again with --interpolation " + name(wanted) +
              ", or render it with --interpolation " + name(pyramid.look_up));
}

/// Refuses what does not go with a map.
void check_map(const VolumeOptions& o) {
  if (o.map != nullptr && o.homogenise) {
    throw Error("a mapped density cannot be combined with homogenised parts");
  }
}

/// Refuses what does not go with samples that stay where they are.
void check_shared(const VolumeOptions& o) {
  if (o.samples != SampleStorage::shared) return;
  const char* wrong = o.look_up != LookUp::nearest && o.look_up != LookUp::trilinear
                          ? "interpolation other than nearest and trilinear"
                      : o.homogenise ? "homogenised parts"
                                     : nullptr;
  if (wrong) throw Error(std::string("samples cannot be shared with ") + wrong + "; copy them");
}

/// What a walk may know of parts of leaves: nothing where only the bounds of the pyramid will do,
/// or where shorter segments save no look-ups.
BoundParts parts_of(const VolumeField& f, const VolumeOptions& o) {
  const bool closed = f.look_up == LookUp::nearest || f.look_up == LookUp::trilinear;
  const bool as_they_are = o.majorant_scale == 1 && f.excess.nodes == 0;
  if (!closed || !as_they_are || is_weighted(o.tracker) || o.tracker == Tracker::regular) return {};
  return [&f](std::uint32_t brick) {
    std::array<float, kFieldSamples> scratch;
    const float* const samples = detail::samples_of(f, brick, scratch.data());
    PartBounds r;
    for (std::size_t k = 0; k < r.lo.size(); ++k) {
      const Vec3i part(int(k >> 4), int(k >> 2 & 3), int(k & 3));
      const DensityRange d = detail::reach_of_look_ups(detail::samples_in_cube(samples, part, 2));
      r.lo[k] = d.lo, r.hi[k] = d.hi;
    }
    return r;
  };
}

/// The tree of the field's bounds, or of what its map leaves of them.
Octree build_tree(const Pyramid& pyramid, VolumeField& f, double extinction, double cell_length,
                  const VolumeOptions& o, const std::vector<std::vector<std::uint32_t>>& brick_of) {
  if (f.map == nullptr) {
    return build_octree(pyramid, extinction, cell_length, choose_cut(o, f.look_up), brick_of,
                        kZeroBrick, parts_of(f, o));
  }
  const Pyramid mapped = map_pyramid(pyramid, *f.map);
  if (!(double(f.scale) * double(mapped.scale) <= double(FLT_MAX))) {
    throw Error("the map yields densities up to " + detail::digits(double(mapped.scale), 6) +
                ", and the extinction scales these beyond 3.4e38");
  }
  if (mapped.empty()) f.world_box = {};
  return build_octree(mapped, double(f.scale), cell_length, choose_cut(o, f.look_up),
                      links_of(mapped, pyramid, brick_of), kZeroBrick);
}

Box world_box(const Affine& to_world, const Pyramid& pyramid) {
  return pyramid.empty() ? Box{} : transform(to_world, pyramid.support());
}

/// A volume without its field's values, the world length of its cells' edges at its first place,
/// and the longest diagonal of a cell at any.
struct Placed {
  Volume volume;
  double cell_length, cell_diagonal;
};

/// Throws Error for a place where the cloud is too small, too far or too thick.
void check_place(const Affine& to_world, const Affine& to_cells, const Box& box, double largest) {
  const double cell_length = std::cbrt(std::abs(determinant(to_world)));
  if (largest * cell_length > kMaxVoxelDepth) {
    throw Error(
        "an optical depth of " + detail::digits(largest * cell_length, 6) +
        " per voxel is too large; expected at most 1e12. Check the unit of the extinction.");
  }
  detail::check_placement(to_world, to_cells, box);
}

Placed place(const Affine& index_to_object, const Pyramid& pyramid, const Medium& medium,
             const VolumeOptions& o, LookUp look_up) {
  check_look_up(pyramid, look_up);
  validate(medium);
  const double largest = medium.extinction * double(pyramid.scale);
  if (!(medium.extinction >= 0 && medium.extinction <= double(FLT_MAX) &&
        largest <= double(FLT_MAX))) {
    throw Error("an extinction of " + detail::digits(medium.extinction, 6) +
                " per unit of density with a largest "
                "density of " +
                detail::digits(double(pyramid.scale), 6) + " is outside [0, 3.4e38]");
  }
  check_majorant_scale(o);
  Volume v{.medium = medium, .object_to_world = o.object_to_world};
  if (!o.instances.empty()) v.object_to_world = o.instances.front() * o.object_to_world;
  const Affine to_world = v.object_to_world * index_to_object;
  const Affine to_index = inverse(to_world);
  VolumeField& f = v.density;
  f.scale = float(medium.extinction);
  f.look_up = look_up;
  f.world_to_cells = translation(-Vec3d(pyramid.origin)) * to_index;
  f.world_box = world_box(to_world, pyramid);
  detail::naming_place(0, o.instances.size(),
                       [&] { check_place(to_world, f.world_to_cells, f.world_box, largest); });
  double diagonal = detail::cell_diagonal(to_world);
  for (std::size_t i = 1; i < o.instances.size(); ++i) {
    const Affine& map = v.further_places.emplace_back(o.instances[i] * inverse(o.instances[0]));
    detail::naming_place(i, o.instances.size(), [&] {
      check_place(map * to_world, f.world_to_cells * inverse(map), transform(map, f.world_box),
                  largest);
    });
    diagonal = std::max(diagonal, detail::cell_diagonal(map * to_world));
  }
  return {std::move(v), std::cbrt(std::abs(determinant(to_world))), diagonal};
}

/// Gives a field that has its place the bricks, and the tree of their bounds.
void add_bricks(VolumeField& f, const detail::LinkedBricks& bricks, const Pyramid& bounds,
                const Medium& medium, double cell_length, const VolumeOptions& o) {
  f.map = o.map;
  f.excess = bricks.excess;
  f.values = bricks.values;
  f.codes = bricks.codes;
  f.octree = build_tree(bounds, f, medium.extinction, cell_length, o, bricks.brick_of);
  f.leaves = detail::index_leaves_of(f);
  scale_majorants(f, o.majorant_scale);
}

}  // namespace

FieldValues empty_values() { return std::make_shared<const BrickField>(); }

std::uint64_t VolumeField::value_bytes() const {
  if (shares_samples()) return shared().bytes();
  if (std::holds_alternative<std::shared_ptr<const BrickField>>(values)) {
    return bricks().samples.size() * sizeof(float);
  }
  return count_bytes(recipe());
}

std::uint64_t VolumeField::shared_bytes() const {
  return shares_samples() ? shared().shared_bytes : 0;
}

std::uint64_t VolumeField::squeeze_bytes() const {
  return micro.bytes() + (codes ? codes->bytes() : 0);
}

void validate_placement(const Affine& index_to_world, const Pyramid& pyramid) {
  detail::check_placement(index_to_world,
                          translation(-Vec3d(pyramid.origin)) * inverse(index_to_world),
                          world_box(index_to_world, pyramid));
}

Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid, const Medium& medium,
                   const VolumeOptions& o, const LeafMicroBounds* stored) {
  if (o.look_up == LookUp::procedural) {
    throw Error("found samples with procedural look-ups; expected a recipe");
  }
  check_map(o);
  check_shared(o);
  Placed placed = place(grid.index_to_world, pyramid, medium, o, o.look_up);
  VolumeField& f = placed.volume.density;
  f.name = grid.name;
  FieldOptions rules;
  rules.look_up = o.look_up;
  rules.codes = decides_by_codes(pyramid, o);
  rules.most_excess = is_weighted(o.tracker) ? kMostBoundsExcess * o.majorant_scale : 1;
  HomogenisedPyramid homogenised;
  if (!o.homogenise) {
    detail::require_cover(grid, pyramid);
  } else {
    detail::require_bounds(grid, pyramid);
    homogenised = homogenise(pyramid, measure_content(grid, pyramid), medium.extinction,
                             placed.cell_diagonal, *o.homogenise);
    rules.constant = &homogenised.constant;
    f.homogeneous = std::make_shared<const HomogeneousParts>(homogenised.parts);
  }
  const Pyramid& bounds = o.homogenise ? homogenised.pyramid : pyramid;
  const bool share = shares_samples(grid, pyramid, o);
  const detail::LinkedBricks bricks = share ? detail::link(build_shared_field(grid, bounds, rules))
                                            : detail::link(build_field(grid, bounds, rules));
  add_bricks(f, bricks, bounds, medium, placed.cell_length, o);
  const auto micro_bounds = [&](int edge) {
    f.micro_stored = stored && stored->by_leaf.edge == edge && has_closed_form(f.look_up) &&
                     !o.homogenise && !share;
    return f.micro_stored ? arrange(*stored, f.bricks(), bricks.brick_of, pyramid)
                          : detail::build_micro_bounds(bricks, edge);
  };
  add_micro_bounds(f, bounds, o, micro_bounds);
  return std::move(placed.volume);
}

MicroBounds detail::build_micro_bounds(const LinkedBricks& bricks, int edge) {
  if (const auto* const shared = std::get_if<std::shared_ptr<const SharedField>>(&bricks.values)) {
    return pvol::build_micro_bounds(**shared, edge);
  }
  return pvol::build_micro_bounds(copies_of(bricks), edge);
}

Volume detail::make_volume(const LinkedBricks& bricks, const Pyramid& pyramid,
                           const Affine& index_to_object, const Medium& medium,
                           const VolumeOptions& o, const GetMicroBounds& micro_bounds) {
  Placed placed = place(index_to_object, pyramid, medium, o, o.look_up);
  VolumeField& f = placed.volume.density;
  add_bricks(f, bricks, pyramid, medium, placed.cell_length, o);
  add_micro_bounds(f, pyramid, o, micro_bounds);
  return std::move(placed.volume);
}

Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                   const Medium& medium, const VolumeOptions& o) {
  if (o.homogenise) {
    throw Error(
        "procedural look-ups do not support homogenised parts; choose another interpolation");
  }
  auto [v, cell_length, cell_diagonal] =
      place(scaling(Vec3d(recipe->voxel)), pyramid, medium, o, LookUp::procedural);
  VolumeField& f = v.density;
  f.name = recipe->name;
  ProceduralWithLinks built = make_procedural_field(std::move(recipe), pyramid);
  f.map = o.map;
  f.octree = build_tree(pyramid, f, medium.extinction, cell_length, o, built.brick_of);
  f.values = std::move(built.field);
  f.leaves = detail::index_leaves_of(f);
  scale_majorants(f, o.majorant_scale);
  add_micro_bounds(f, pyramid, o, [&](int edge) { return build_micro_bounds(f.recipe(), edge); });
  return std::move(v);
}

Volume make_volume(const Density& density, const Pyramid& pyramid, const Medium& medium,
                   const VolumeOptions& o, const LeafMicroBounds* stored) {
  if (const auto* grid = std::get_if<VoxelGrid>(&density)) {
    return make_volume(*grid, pyramid, medium, o, stored);
  }
  return make_volume(std::get<std::shared_ptr<const Recipe>>(density), pyramid, medium, o);
}

}  // namespace pvol
