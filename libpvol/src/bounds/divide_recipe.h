// Descent through a recipe's box by halves, leaving out what is empty: common to its bounds and its
// support.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "density/recipe_view.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {

inline constexpr int kLeafLog2 = 3;
inline constexpr int kTaskLog2 = 6;  // some hundred tasks in a cloud of 256 cells a side
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
[[nodiscard]] inline Box box_of(const Recipe& recipe, const Cube& cube) {
  return {place(recipe, Vec3i(cube.lo)), place(recipe, Vec3i(cube.lo + Vec3l(cube.edge())))};
}

[[nodiscard]] inline NarrowedRecipe narrow(const RecipeView& view, const Cube& cube) {
  return narrow(view, box_of(*view.recipe, cube));
}

/// The least cube of leaves, times a power of two, that holds the box.
[[nodiscard]] inline Cube root_of(const Recipe& recipe, const Box& box) {
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
[[nodiscard]] std::vector<Found> divide_root(const RecipeView& view, const Cube& root,
                                             const Whole& whole, const Leaf& leaf) {
  std::vector<Task> tasks;
  std::vector<Found> found(1);
  divide(
      view, root, std::max(kLeafLog2, std::min(kTaskLog2, root.log2)),
      [&](const Cube& cube, Interval range) { return whole(cube, range, found[0]); },
      [&](const RecipeView& near, const Cube& cube, Interval) {
        tasks.push_back({near, cube});
      });
  found.resize(tasks.size() + 1);
  parallel_for(0, tasks.size(), [&](std::size_t i) {
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
[[nodiscard]] inline std::uint64_t code_of(const Cube& root, const Cube& cube) {
  const Vec3l d = cube.lo - root.lo;
  return morton_encode(
      Vec3<std::uint32_t>(Vec3l(d.x >> cube.log2, d.y >> cube.log2, d.z >> cube.log2)));
}

/// Throws Error where a number of halvings is not in 0..3.
inline void check_range(int v, const std::string& what) {
  if (v >= 0 && v <= kLeafLog2) return;
  throw Error(what + " is " + std::to_string(v) + "; expected 0 to 3");
}

}  // namespace pvol::detail
