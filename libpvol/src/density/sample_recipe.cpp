// A recipe's samples: blocks divided down to bricks, and left out where the density is constant.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "density/recipe_view.h"
#include "pvol/density/recipe.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using detail::is_constant;
using detail::place;
using detail::RecipePoint;
using detail::RecipeScratch;
using detail::RecipeView;

/// The samples at origin + [0, edge)^3.
struct Block {
  Vec3i origin;
  std::int32_t edge = 0;
};

/// What one task found.
struct Found {
  std::vector<Vec3i> origins;  ///< of bricks
  std::vector<float> samples;  ///< of all of them
  std::vector<Tile> tiles;
};

void sample_brick(const RecipeView& part, const Block& block, RecipeScratch& scratch,
                  Found& found) {
  std::array<RecipePoint, kBrickSamples> points;
  for (int i = 0; i < kBrickSamples; ++i) {
    const Vec3i at{i / (kBrickEdge * kBrickEdge), i / kBrickEdge % kBrickEdge, i % kBrickEdge};
    points[std::size_t(i)] = {&part, place(*part.recipe, block.origin + at)};
  }
  std::array<float, kBrickSamples> rho;
  densities(points, scratch, rho.data());
  if (std::none_of(rho.begin(), rho.end(), [](float v) { return v > 0; })) return;
  found.origins.push_back(block.origin);
  found.samples.insert(found.samples.end(), rho.begin(), rho.end());
}

bool is_tile(std::int32_t edge) { return edge == 8 || edge == 128 || edge == 4096; }

/// Divides the block into blocks of edge `last` for `visit(part, block)`, and leaves out those in
/// which the density is certainly constant: zero needs no sample, other values become tiles.
template <class Visit>
void divide(const RecipeView& part, const Block& block, std::int32_t last, std::vector<Tile>& tiles,
            const Visit& visit) {
  const Box box{place(*part.recipe, block.origin),
                place(*part.recipe, block.origin + Vec3i(block.edge - 1))};
  const auto [near, range] = narrow(part, box);
  if (range.hi == 0) return;
  if (is_constant(range) && is_tile(block.edge)) {
    tiles.push_back({block.origin, block.edge, static_cast<float>(range.lo)});
  } else if (block.edge == last) {
    visit(near, block);
  } else {
    const std::int32_t half = block.edge / 2;
    for (int child = 0; child < 8; ++child) {
      const Vec3i step{child & 1 ? half : 0, child & 2 ? half : 0, child & 4 ? half : 0};
      divide(near, {block.origin + step, half}, last, tiles, visit);
    }
  }
}

struct Task {
  RecipeView part;
  Block block;
};
constexpr std::int32_t kTaskEdge = 64;  // some hundred tasks in a grid of 256 samples a side

/// The few largest blocks, aligned to their edge, that hold all samples in the box.
std::vector<Block> roots(const Box& box, double voxel) {
  const auto sample = [&](double x) { return static_cast<std::int32_t>(std::floor(x / voxel)); };
  // One more on each side, whatever the quotients were rounded to.
  const Vec3i lo = Vec3i{sample(box.lo.x), sample(box.lo.y), sample(box.lo.z)} - Vec3i(1);
  const Vec3i hi = Vec3i{sample(box.hi.x), sample(box.hi.y), sample(box.hi.z)} + Vec3i(2);
  std::int32_t edge = kTaskEdge;
  while (edge < max_component(hi - lo)) edge *= 2;
  const auto aligned = [edge](std::int32_t x) { return x & -edge; };
  std::vector<Block> blocks;
  for (std::int32_t x = aligned(lo.x); x <= hi.x; x += edge) {
    for (std::int32_t y = aligned(lo.y); y <= hi.y; y += edge) {
      for (std::int32_t z = aligned(lo.z); z <= hi.z; z += edge)
        blocks.push_back({{x, y, z}, edge});
    }
  }
  return blocks;
}

/// One grid of what the tasks found.
VoxelGrid collect(const Recipe& recipe, std::vector<Found> found, std::vector<Tile> tiles) {
  VoxelGrid grid;
  grid.name = recipe.name;
  grid.index_to_world = scaling(Vec3d(recipe.voxel));
  grid.tiles = std::move(tiles);
  const auto owner = std::make_shared<const std::vector<Found>>(std::move(found));
  for (const Found& f : *owner) {
    grid.tiles.insert(grid.tiles.end(), f.tiles.begin(), f.tiles.end());
    const float* values = f.samples.data();
    for (const Vec3i origin : f.origins) {
      grid.bricks.push_back({origin, values});
      values += kBrickSamples;
    }
  }
  grid.owner = owner;
  sort(grid);
  return grid;
}

}  // namespace

VoxelGrid make_grid(const Recipe& recipe) {
  validate(recipe);
  const Box box = support(recipe);
  if (box.empty()) return collect(recipe, {}, {});
  const RecipeView whole = detail::view(recipe);
  std::vector<Task> tasks;
  std::vector<Tile> tiles;
  for (const Block& root : roots(box, recipe.voxel)) {
    divide(whole, root, kTaskEdge, tiles, [&](const RecipeView& part, const Block& block) {
      tasks.push_back({part, block});
    });
  }
  std::vector<Found> found(tasks.size());
  parallel_for(0, tasks.size(), [&](std::size_t i) {
    RecipeScratch scratch;
    divide(tasks[i].part, tasks[i].block, kBrickEdge, found[i].tiles,
           [&](const RecipeView& part, const Block& block) {
             sample_brick(part, block, scratch, found[i]);
           });
  });
  return collect(recipe, std::move(found), std::move(tiles));
}

}  // namespace pvol
