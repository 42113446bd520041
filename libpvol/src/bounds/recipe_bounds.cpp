#include "pvol/bounds/recipe_bounds.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bounds/divide_recipe.h"
#include "bounds/pyramid_parts.h"
#include "pvol/error.h"

namespace pvol {
namespace {

using detail::code_of;
using detail::Cube;
using detail::divide_root;
using detail::is_constant;
using detail::kLeafLog2;
using detail::NarrowedRecipe;
using detail::RecipeView;
using detail::root_of;

float float_below(double v) {
  const auto f = static_cast<float>(v);
  return double(f) <= v ? f : std::nextafter(f, 0.0f);
}
float float_above(double v) {
  const auto f = static_cast<float>(v);
  return double(f) >= v ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

/// Bounds of the samples, which are densities rounded to float.
PyramidNode make_node(std::uint64_t code, Interval range) {
  if (is_constant(range)) {
    const auto v = static_cast<float>(range.lo);
    return {code, v, v};
  }
  return {code, float_below(range.lo), float_above(range.hi)};
}

struct CellBox {
  Vec3l lo{std::numeric_limits<std::int64_t>::max()};
  Vec3l hi{std::numeric_limits<std::int64_t>::min()};
  void add(Vec3l from, Vec3l to) {
    lo = min(lo, from);
    hi = max(hi, to);
  }
  void add(const Cube& cube) { add(cube.lo, cube.lo + Vec3l(cube.edge())); }
};

/// What a task finds: nodes with their exact bounds, level 0 those of leaves.
struct FoundNodes {
  std::vector<std::pair<int, PyramidNode>> nodes;
  CellBox support;
};

/// The range over the cube as the hull of those over its octants, `refine` times.
Interval refined_range(const RecipeView& view, const Cube& cube, Interval range, int refine,
                       CellBox& support) {
  if (refine == 0 || is_constant(range)) {
    if (range.hi > 0) support.add(cube);
    return range;
  }
  Interval all{std::numeric_limits<double>::infinity(), 0};
  for (int c = 0; c < 8; ++c) {
    const Cube part = cube.child(c);
    const NarrowedRecipe near = narrow(view, part);
    all = hull(all, refined_range(near.view, part, near.density, refine - 1, support));
  }
  return {std::max(range.lo, all.lo), std::min(range.hi, all.hi)};
}

Pyramid assemble(const Cube& root, const std::vector<FoundNodes>& found) {
  Pyramid p;
  p.look_up = LookUp::procedural;
  CellBox support;
  for (const FoundNodes& f : found) {
    for (const auto& [level, node] : f.nodes) p.scale = std::max(p.scale, node.hi);
    support.add(f.support.lo, f.support.hi);
  }
  if (p.scale == 0) return p;
  p.origin = root.lo;
  p.support_lo = support.lo;
  p.support_hi = support.hi;
  p.levels.resize(std::size_t(root.log2 - kLeafLog2 + 1));
  for (const FoundNodes& f : found) {
    for (const auto& [level, node] : f.nodes) {
      p.levels[std::size_t(level)].push_back(detail::quantize(node, p.scale));
    }
  }
  for (std::vector<PyramidNode>& level : p.levels) {
    std::sort(level.begin(), level.end(),
              [](const PyramidNode& a, const PyramidNode& b) { return a.code < b.code; });
  }
  complete_levels(p);
  return p;
}

}  // namespace

Pyramid build_pyramid(const Recipe& recipe, int refine, std::uint64_t max_leaves) {
  validate(recipe);
  detail::check_range(refine, "the refinement of leaves");
  const Box box = support(recipe);
  if (box.empty()) return assemble({}, {});
  const Cube root = root_of(recipe, box);
  std::atomic<std::uint64_t> count = 0;
  const auto add = [&](const Cube& cube, Interval range, FoundNodes& found) {
    if (++count > max_leaves) {
      throw Error("the recipe needs more than " + std::to_string(max_leaves) +
                  " leaves of 8^3 voxels; enlarge the voxel");
    }
    found.nodes.emplace_back(cube.log2 - kLeafLog2, make_node(code_of(root, cube), range));
  };
  const auto whole = [&](const Cube& cube, Interval range, FoundNodes& found) {
    if (!is_constant(range)) return false;
    add(cube, range, found);
    found.support.add(cube);
    return true;
  };
  const auto leaf = [&](const RecipeView& view, const Cube& cube, Interval range,
                        FoundNodes& found) {
    range = refined_range(view, cube, range, refine, found.support);
    if (range.hi > 0) add(cube, range, found);
  };
  return assemble(root, divide_root<FoundNodes>(detail::view(recipe), root, whole, leaf));
}

}  // namespace pvol
