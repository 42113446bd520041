// Procedural look-ups: the density of a recipe at the point itself, without samples.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pvol/bounds/walk.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"

namespace pvol {

struct Recipe;  // density/recipe.h

/// A recipe, and for each terminal of its pyramid (a brick, though without samples) those of its
/// parts that decide the density there: a look-up evaluates these alone. Opaque, immutable, safe to
/// read from any thread; made by `make_procedural_field`.
struct ProceduralField;

/// float(density(recipe, x)) to the last bit, at the point x = voxel * (origin + cell + offset), as
/// rounded to double, of a brick that holds the cell; 0 for kZeroBrick.
[[nodiscard]] float density_in_brick(const ProceduralField& field, std::uint32_t brick,
                                     const LatticePoint& p);

/// The same at many points, each in a brick of its own, in less time for each.
void densities_in_bricks(const ProceduralField& field, std::span<const std::uint32_t> bricks,
                         std::span<const LatticePoint> points, float* rho);

/// mu_t at a point of a segment: scale * rho. As BrickExtinction, but for `corners`. The tree's
/// handles name bricks of the field, and both outlive this.
struct ProceduralExtinction {
  static constexpr LookUp kLookUp = LookUp::procedural;

  const ProceduralField& field;
  const Octree& tree;
  float scale;

  [[nodiscard]] std::uint32_t brick(const Segment& s, const LatticePoint& p) const {
    return tree.brick_at(s.leaf, p.cell, kZeroBrick);
  }
  [[nodiscard]] float in_brick(std::uint32_t brick, const LatticePoint& p) const {
    return scale * density_in_brick(field, brick, p);
  }
  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return in_brick(brick(s, p), p);
  }
  [[nodiscard]] float density(LeafHandle leaf, const LatticePoint& p) const {
    return density_in_brick(field, tree.brick_at(leaf, p.cell, kZeroBrick), p);
  }
};

/// The field of a recipe, and the brick of each leaf and uniform cube of its pyramid, by level and
/// node: what `build_octree` links to.
struct ProceduralWithLinks {
  std::shared_ptr<const ProceduralField> field;
  std::vector<std::vector<std::uint32_t>> brick_of;
};

/// The pyramid without what lies deeper than an octree depth >= 0. Its lowest nodes need not be of
/// one density, as those of other pyramids are that have no children: it serves procedural look-ups
/// alone, which then know no more of the recipe than an octree of that depth can tell them.
[[nodiscard]] Pyramid limit_depth(const Pyramid& pyramid, int depth);

/// `pyramid` is that of build_pyramid(*recipe, ...), or limit_depth of it. In parallel; the same
/// for any number of threads. Throws Error as validate(*recipe) does, and where a density at a
/// corner or in the middle of a leaf leaves its bounds: they belong to another recipe.
[[nodiscard]] ProceduralWithLinks make_procedural_field(std::shared_ptr<const Recipe> recipe,
                                                        const Pyramid& pyramid);

/// Bounds of each cube of edge^3 cells from density_range() (THEORY.md, T8.2), which hold for every
/// look-up, rounding included. As build_micro_bounds of a BrickField, but it takes some 10 us for
/// each cube that is not far from the recipe's surface.
[[nodiscard]] MicroBounds build_micro_bounds(const ProceduralField& field, int edge);

/// What it takes in memory, without the recipe.
[[nodiscard]] std::uint64_t count_bytes(const ProceduralField& field);

}  // namespace pvol
