// Look-ups at points: what the index of leaves finds is what the search from the octree's root
// finds, to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pvol/bounds/leaf_index.h"
#include "pvol/density/cumulus.h"
#include "pvol/density/recipe.h"
#include "pvol/embed.h"
#include "pvol/math/field_map.h"
#include "support/placed_clouds.h"

namespace pvol::test {
namespace point_look_up_test {

constexpr std::uint64_t kAnySize = std::uint64_t(1) << 30;

Volume with_index(Volume v) {
  v.density.leaves = index_leaves(v.density.octree, kAnySize);
  return v;
}
Volume without_index(Volume v) {
  v.density.leaves = nullptr;
  return v;
}

/// Points of the world all over the support and beyond, on faces of cells and leaves, and where
/// nothing is.
std::vector<Vec3d> points(const Volume& v, Rng& rng, int count) {
  const Octree& tree = v.density.octree;
  const Affine to_world = inverse(v.density.world_to_cells);
  const Vec3d lo(vec3(tree.support_lo)), hi(vec3(tree.support_hi));
  const double far[] = {kFar, -kFar, std::nan(""), 1e300, -1e30};
  std::vector<Vec3d> all;
  for (int i = 0; i < count; ++i) {
    const auto [a, b, c, d] = rng.uniform4();
    Vec3d cells = lo - Vec3d(3) + (hi - lo + Vec3d(6)) * Vec3d(double(a), double(b), double(c));
    const int axis = int(3 * d);
    if (i % 4 == 1) cells[axis] = std::round(cells[axis]);
    if (i % 4 == 2) cells[axis] = 8 * std::round(cells[axis] / 8);
    if (i % 4 == 3) cells[axis] = i & 4 ? lo[axis] : hi[axis];
    all.push_back(to_world.point(cells));
    if (i % 16 == 0) {
      all.push_back(all.back());
      all.back()[axis] = far[i / 16 % 5];
    }
  }
  return all;
}

/// At these points and random ones. The share of them at which there is something.
double expect_equal_look_ups(const Volume& made, const std::string& name,
                             std::vector<Vec3d> all = {}) {
  const Volume indexed = with_index(made), searched = without_index(made);
  Rng rng(kPlacedSeed, 30, 0);
  int solid = 0;
  for (const Vec3d& p : points(made, rng, 2000)) all.push_back(p);
  for (const Vec3d& p : all) {
    const float expected = density_at(searched, p);
    solid += expected > 0;
    for (const Volume* v : {&made, &indexed}) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(density_at(*v, p)),
                std::bit_cast<std::uint32_t>(expected))
          << name;
      EXPECT_EQ(extinction_at(*v, p), extinction_at(searched, p)) << name;
    }
  }
  return solid / double(all.size());
}

TEST(PointLookUp, IsThatOfTheTree) {
  for (const LookUp look_up : {kNearest, kTrilinear, LookUp::tricubic}) {
    for (const Field& f : fields()) {
      for (const Placement& place : {placements()[0], placements()[2]}) {
        const PlacedCloud cloud(f, place.to_world, 0.7, {.look_up = look_up});
        const std::string name = f.name + ", " + place.name + ", " + pvol::name(look_up);
        std::vector<Vec3d> near;
        Rng rng(kPlacedSeed, 31, 0);
        for (int i = 0; i < 300; ++i) near.push_back(cloud.place_inside(rng));
        EXPECT_GT(expect_equal_look_ups(cloud.volume, name, near), 0.01) << name;
      }
    }
  }
}

TEST(PointLookUp, IsThatOfTheTreeUnderAMap) {
  auto map = std::make_shared<FieldMap>();
  map->scale = 2;
  map->offset = -0.4;
  for (const LookUp look_up : {kNearest, kTrilinear}) {
    const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 0.7,
                            {.look_up = look_up, .map = map});
    EXPECT_GT(expect_equal_look_ups(cloud.volume, "mapped"), 0.001);
  }
}

TEST(PointLookUp, IsThatOfTheTreeForRecipes) {
  Recipe recipe = make_recipe(Cumulus{.towers = 3, .generations = 1});
  recipe.voxel = voxel_for(recipe, 60);
  const Volume v = make_volume(recipe, {.extinction = 3});
  EXPECT_GT(expect_equal_look_ups(v, "recipe"), 0.001);
}

/// Cubes of one value, far larger than leaves, which a tree holds in few nodes.
TEST(PointLookUp, KnowsUniformCubes) {
  VoxelGrid grid;
  grid.tiles.push_back({{128, 0, -128}, 128, 0.5f});
  grid.tiles.push_back({{0, 0, -128}, 8, 0.25f});
  const Volume v = make_volume(grid, {.extinction = 2});
  EXPECT_GT(expect_equal_look_ups(v, "tiles"), 0.3);
  EXPECT_EQ(density_at(with_index(v), {200, 60, -60}), 0.5f);
  EXPECT_EQ(density_at(with_index(v), {3, 3, -125}), 0.25f);
  EXPECT_EQ(density_at(with_index(v), {60, 60, -60}), 0);
}

/// Volumes have an index where it is small beside the samples, and say so.
TEST(PointLookUp, IndexesAreSmall) {
  const PlacedCloud dense(field("gaussian"), {}, 1);
  ASSERT_NE(dense.volume.density.leaves, nullptr);
  EXPECT_LE(dense.volume.density.leaves->bytes(), dense.volume.density.value_bytes() / 50);
  const Octree& tree = dense.volume.density.octree;
  const std::uint64_t bytes = dense.volume.density.leaves->bytes();
  EXPECT_NE(index_leaves(tree, bytes), nullptr);
  EXPECT_EQ(index_leaves(tree, bytes - 1), nullptr);

  // Two voxels as far apart as lattices reach: more leaves than 64 bits can count.
  const auto put = [](Vec3i, float* values) { std::fill_n(values, kBrickSamples, 1.0f); };
  VoxelGrid apart = make_grid({0, 0, 0}, {8, 8, 8}, put);
  const VoxelGrid other = make_grid(Vec3i(1 << 20), Vec3i((1 << 20) + 8), put);
  apart.bricks.push_back(other.bricks[0]);
  const Volume v = make_volume(apart, {.extinction = 1});
  EXPECT_EQ(v.density.leaves, nullptr);
  EXPECT_EQ(density_at(v, Vec3d(3.5)), 1);
  EXPECT_EQ(density_at(v, Vec3d((1 << 20) + 3.5)), 1);
  EXPECT_EQ(density_at(v, Vec3d(1 << 19)), 0);
  EXPECT_EQ(index_leaves(Octree{}, kAnySize), nullptr);
}

}  // namespace point_look_up_test
}  // namespace pvol::test
