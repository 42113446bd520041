#include "pvol/field/procedural.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "density/recipe_view.h"
#include "field/micro_codes.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {

using detail::is_constant;
using detail::NarrowedRecipe;
using detail::RecipePoint;
using detail::RecipeView;

namespace {

/// The cells lo + [0, edge)^3.
struct Cube {
  Vec3l lo;
  std::int64_t edge = 0;
};

/// Holds the places of all look-ups in the closed cube: sums with an offset in [0, 1] and products
/// with the voxel round monotonically (T8.2).
Box box_of(double voxel, const Cube& cube) {
  return {Vec3d(cube.lo) * voxel, Vec3d(cube.lo + Vec3l(cube.edge)) * voxel};
}

struct ProceduralBrick {
  RecipeView view;
  Cube cube;
};

}  // namespace

struct ProceduralField {
  std::shared_ptr<const Recipe> recipe;
  Vec3l origin;                         ///< of the pyramid, and of the octree's cells
  std::vector<ProceduralBrick> bricks;  ///< the first is not used: nothing is there
};

namespace {

/// Finds the bricks' views from the root down, so that each looks only at what its parent left.
class Narrowing {
 public:
  Narrowing(const Pyramid& pyramid, const std::vector<std::vector<std::uint32_t>>& brick_of,
            ProceduralField& field)
      : pyramid_(pyramid), brick_of_(brick_of), field_(field) {}

  void descend(std::size_t level, std::size_t i, const RecipeView& above) {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    const PyramidNode& node = pyramid_.levels[level][i];
    const Cube cube{pyramid_.origin + Vec3l(morton_decode(node.code)) * edge, edge};
    NarrowedRecipe here = narrow(above, box_of(field_.recipe->voxel, cube));
    const NodeRange below = children(pyramid_, level, i);
    if (below.empty()) {
      check(node, cube, here.view);
      field_.bricks[brick_of_[level][i]] = {std::move(here.view), cube};
      return;
    }
    parallel_for(below.begin, below.end,
                 [&](std::size_t child) { descend(level - 1, child, here.view); });
  }

 private:
  void check(const PyramidNode& node, const Cube& cube, const RecipeView& view) const {
    for (int i = 0; i < 9; ++i) {
      const Vec3d part = i == 8 ? Vec3d(0.5) : Vec3d(i & 1, i >> 1 & 1, i >> 2);
      const Vec3d p = (Vec3d(cube.lo) + part * double(cube.edge)) * field_.recipe->voxel;
      const auto rho = static_cast<float>(density(view, p));
      if (node.lo <= rho && rho <= node.hi) continue;
      throw Error(std::to_string(rho) + " is a density in leaf " + std::to_string(node.code) +
                  ", whose bounds are [" + std::to_string(node.lo) + ", " +
                  std::to_string(node.hi) +
                  "]: they belong to another recipe or were damaged; fit the recipe again.");
    }
  }

  const Pyramid& pyramid_;
  const std::vector<std::vector<std::uint32_t>>& brick_of_;
  ProceduralField& field_;
};

/// Ranges of a cube's parts, for those of a brick: dividing first tells which of the recipe's parts
/// density there.
void add_ranges(const RecipeView& view, double voxel, const Cube& brick, const Cube& cube, int edge,
                detail::CubeRanges& ranges) {
  const NarrowedRecipe here = narrow(view, box_of(voxel, cube));
  if (cube.edge > edge && !is_constant(here.density)) {
    const std::int64_t half = cube.edge / 2;
    for (int c = 0; c < 8; ++c) {
      const Cube part{cube.lo + Vec3l(c & 1, c >> 1 & 1, c >> 2) * half, half};
      add_ranges(here.view, voxel, brick, part, edge, ranges);
    }
    return;
  }
  // Rounding to float is monotone, and look-ups round the same densities.
  const DensityRange r{float(here.density.lo), float(here.density.hi)};
  ranges.all = {std::min(ranges.all.lo, r.lo), std::max(ranges.all.hi, r.hi)};
  const std::int64_t n = kLeafEdge / edge, count = cube.edge / edge;
  const Vec3l at = cube.lo - brick.lo, first(at.x / edge, at.y / edge, at.z / edge);
  for (std::int64_t i = first.x; i < first.x + count; ++i) {
    for (std::int64_t j = first.y; j < first.y + count; ++j) {
      const auto row = ranges.cube.begin() + (i * n + j) * n + first.z;
      std::fill_n(row, count, r);
    }
  }
}

/// Where look-ups are made.
Vec3d world_of(const ProceduralField& field, const LatticePoint& p) {
  const Vec3d at = Vec3d(field.origin + Vec3l(vec3(p.cell))) + Vec3d(vec3(p.frac));
  return at * field.recipe->voxel;
}

}  // namespace

float density_in_brick(const ProceduralField& field, std::uint32_t brick, const LatticePoint& p) {
  return brick == kZeroBrick ? 0 : float(density(field.bricks[brick].view, world_of(field, p)));
}

void densities_in_bricks(const ProceduralField& field, std::span<const std::uint32_t> bricks,
                         std::span<const LatticePoint> points, float* rho) {
  std::vector<RecipePoint> inside;
  std::vector<std::size_t> of;
  for (std::size_t k = 0; k < points.size(); ++k) {
    rho[k] = 0;
    if (bricks[k] == kZeroBrick) continue;
    inside.push_back({&field.bricks[bricks[k]].view, world_of(field, points[k])});
    of.push_back(k);
  }
  std::vector<float> found(inside.size());
  detail::RecipeScratch scratch;
  densities(inside, scratch, found.data());
  for (std::size_t k = 0; k < of.size(); ++k) rho[of[k]] = found[k];
}

Pyramid limit_depth(const Pyramid& pyramid, int depth) {
  Pyramid limited = pyramid;
  const int deeper = int(pyramid.levels.size()) - 1 - depth;
  for (int level = 0; level < deeper; ++level) limited.levels[std::size_t(level)].clear();
  return limited;
}

ProceduralWithLinks make_procedural_field(std::shared_ptr<const Recipe> recipe,
                                          const Pyramid& pyramid) {
  validate(*recipe);
  ProceduralWithLinks r;
  r.brick_of.resize(pyramid.levels.size());
  std::uint32_t next = kZeroBrick + 1;
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    r.brick_of[level].assign(pyramid.levels[level].size(), kZeroBrick);
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      if (level == 0 || is_uniform(pyramid, level, i)) r.brick_of[level][i] = next++;
    }
  }
  auto field = std::make_shared<ProceduralField>();
  field->recipe = std::move(recipe);
  field->origin = pyramid.origin;
  field->bricks.resize(next);
  if (!pyramid.empty()) {
    Narrowing(pyramid, r.brick_of, *field)
        .descend(pyramid.levels.size() - 1, 0, detail::view(*field->recipe));
  }
  r.field = std::move(field);
  return r;
}

MicroBounds build_micro_bounds(const ProceduralField& field, int edge) {
  const auto ranges_of = [&field](std::size_t b, int size, detail::CubeRanges& ranges) {
    if (b == kZeroBrick) {
      ranges.all = {0, 0};
      ranges.cube.fill(ranges.all);
      return;
    }
    const auto& [view, cube] = field.bricks[b];
    ranges.all = {std::numeric_limits<float>::max(), 0};
    if (cube.edge > kLeafEdge) {  // one set of codes for all the leaves in it
      const Interval all = narrow(view, box_of(field.recipe->voxel, cube)).density;
      ranges.all = {float(all.lo), float(all.hi)};
      ranges.cube.fill(ranges.all);
      return;
    }
    add_ranges(view, field.recipe->voxel, cube, cube, size, ranges);
  };
  return detail::make_micro_bounds(field.bricks.size(), edge, ranges_of);
}

std::uint64_t count_bytes(const ProceduralField& field) {
  return field.bricks.size() * sizeof(ProceduralBrick);
}

}  // namespace pvol
