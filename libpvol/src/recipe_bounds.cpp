#include "pvol/bounds/recipe_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "pvol/error.h"
#include "recipe_view.h"

namespace pvol {
namespace {

using detail::is_constant;
using detail::NarrowedRecipe;
using detail::place;
using detail::RecipeView;

constexpr int kLeafLog2 = 3;
constexpr int kTaskLog2 = 6;  // some hundred tasks in a cloud of 256 cells a side
static_assert(kLeafEdge == 1 << kLeafLog2);

/// The cells lo + [0, 2^log2)^3, as the closed cube of index space that they fill.
struct Cube {
  Vec3l lo;
  int log2 = 0;
  [[nodiscard]] std::int64_t edge() const { return std::int64_t(1) << log2; }
  [[nodiscard]] Cube child(int c) const {
    return {lo + Vec3l(c & 1, c >> 1 & 1, c >> 2) * (edge() / 2), log2 - 1};
  }
};

/// Holds the places of all samples in the closed cube, as computed: their products with the voxel
/// are rounded as those of the corners are.
Box box_of(const Recipe& recipe, const Cube& cube) {
  return {place(recipe, Vec3i(cube.lo)), place(recipe, Vec3i(cube.lo + Vec3l(cube.edge())))};
}

NarrowedRecipe narrow(const RecipeView& view, const Cube& cube) {
  return narrow(view, box_of(*view.recipe, cube));
}

/// The least cube of leaves, times a power of two, that holds the box.
Cube root_of(const Recipe& recipe, const Box& box) {
  Cube root{{}, kLeafLog2};
  std::int64_t cells = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // One more on each side, whatever the quotients were rounded to.
    const auto lo = std::int64_t(std::floor(box.lo[axis] / recipe.voxel)) - 1;
    const auto hi = std::int64_t(std::ceil(box.hi[axis] / recipe.voxel)) + 1;
    root.lo[axis] = lo & ~std::int64_t(kLeafEdge - 1);
    cells = std::max(cells, hi - root.lo[axis]);
  }
  while (root.edge() < cells) ++root.log2;
  return root;
}

/// Divides the cube down to cubes of 2^last cells for `visit(view, cube, range)`, and leaves out
/// those without density. `whole(cube, range)` may take a larger cube as one, and says so.
template <class Whole, class Visit>
void divide(const RecipeView& view, const Cube& cube, int last, const Whole& whole,
            const Visit& visit) {
  const auto [near, range] = narrow(view, cube);
  if (range.hi == 0) return;
  if (cube.log2 == last) return visit(near, cube, range);
  if (whole(cube, range)) return;
  for (int c = 0; c < 8; ++c) divide(near, cube.child(c), last, whole, visit);
}

struct Task {
  RecipeView view;
  Cube cube;
};

/// Divides the root down to leaves. What is found goes to `found`: in [0] cubes larger than a task,
/// in [i] what the i-th task finds, in order.
template <class Found, class Whole, class Leaf>
std::vector<Found> divide_root(const RecipeView& view, const Cube& root, const Whole& whole,
                               const Leaf& leaf) {
  std::vector<Task> tasks;
  std::vector<Found> found(1);
  divide(
      view, root, std::max(kLeafLog2, std::min(kTaskLog2, root.log2)),
      [&](const Cube& cube, Interval range) { return whole(cube, range, found[0]); },
      [&](const RecipeView& near, const Cube& cube, Interval) {
        tasks.push_back({near, cube});
      });
  found.resize(tasks.size() + 1);
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
    Found& mine = found[i + 1];
    divide(
        tasks[i].view, tasks[i].cube, kLeafLog2,
        [&](const Cube& cube, Interval range) { return whole(cube, range, mine); },
        [&](const RecipeView& near, const Cube& cube, Interval range) {
          leaf(near, cube, range, mine);
        });
  });
  return found;
}

/// Code of a cube among those of its size in the root.
std::uint64_t code_of(const Cube& root, const Cube& cube) {
  const Vec3l d = cube.lo - root.lo;
  return morton_encode(
      Vec3<std::uint32_t>(Vec3l(d.x >> cube.log2, d.y >> cube.log2, d.z >> cube.log2)));
}

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

PyramidNode quantize(const PyramidNode& n, float scale) {
  return {n.code, decode(encode_down(n.lo, scale), scale), decode(encode_up(n.hi, scale), scale)};
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
  p.interpolation = Interpolation::procedural;
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
      p.levels[std::size_t(level)].push_back(quantize(node, p.scale));
    }
  }
  for (std::vector<PyramidNode>& level : p.levels) {
    std::sort(level.begin(), level.end(),
              [](const PyramidNode& a, const PyramidNode& b) { return a.code < b.code; });
  }
  complete_levels(p);
  return p;
}

/// What a task finds of the support.
struct FoundCells {
  std::vector<MaskedBlock> parts;
  std::vector<SupportBlock> full;
};

void mark(const Cube& block, const Cube& cube, CellMask& mask) {
  const Vec3l from = cube.lo - block.lo;
  for (std::int64_t x = from.x; x < from.x + cube.edge(); ++x) {
    for (std::int64_t y = from.y; y < from.y + cube.edge(); ++y) {
      const std::uint64_t row = (std::uint64_t(1) << cube.edge()) - 1;
      mask[std::size_t(x)] |= row << (8 * y + from.z);
    }
  }
}

void mark_occupied(const RecipeView& view, const Cube& block, const Cube& cube, Interval range,
                   int last, CellMask& mask) {
  if (range.hi == 0) return;
  if (range.lo > 0 || cube.log2 == last) return mark(block, cube, mask);
  for (int c = 0; c < 8; ++c) {
    const Cube part = cube.child(c);
    const NarrowedRecipe near = narrow(view, part);
    mark_occupied(near.view, block, part, near.density, last, mask);
  }
}

void check_range(int v, const std::string& what) {
  if (v >= 0 && v <= kLeafLog2) return;
  throw Error(what + " is " + std::to_string(v) + "; expected 0 to 3");
}

}  // namespace

Pyramid build_pyramid(const Recipe& recipe, int refine, std::uint64_t max_leaves) {
  validate(recipe);
  check_range(refine, "the refinement of leaves");
  const Box box = support(recipe);
  if (box.empty()) return assemble({}, {});
  const Cube root = root_of(recipe, box);
  std::atomic<std::uint64_t> count = 0;
  const auto add = [&](const Cube& cube, Interval range, FoundNodes& found) {
    if (++count > max_leaves) {
      throw Error("the recipe takes more than " + std::to_string(max_leaves) +
                  " leaves of 8^3 voxels to bound; enlarge the voxel");
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

Support make_support(const Recipe& recipe, int block_log2) {
  validate(recipe);
  check_range(block_log2, "the size of support blocks as a power of two");
  const Box box = support(recipe);
  if (box.empty()) return {};
  const Cube root = root_of(recipe, box);
  const auto whole = [&](const Cube& cube, Interval range, FoundCells& found) {
    if (!(range.lo > 0) || cube.log2 == kLeafLog2) return false;
    const std::uint64_t code = code_of(root, {cube.lo, kLeafLog2});
    found.full.push_back({code, std::uint32_t(cube.log2 - kLeafLog2), 0});
    return true;
  };
  const auto leaf = [&](const RecipeView& view, const Cube& cube, Interval range,
                        FoundCells& found) {
    MaskedBlock part{code_of(root, cube), {}};
    mark_occupied(view, cube, cube, range, block_log2, part.mask);
    found.parts.push_back(part);
  };
  FoundCells all;
  for (FoundCells& f : divide_root<FoundCells>(detail::view(recipe), root, whole, leaf)) {
    std::move(f.parts.begin(), f.parts.end(), std::back_inserter(all.parts));
    std::move(f.full.begin(), f.full.end(), std::back_inserter(all.full));
  }
  const Support s = make_support(root.lo, root.log2, std::move(all.parts), std::move(all.full));
  return s.empty() ? Support{} : s;
}

}  // namespace pvol
