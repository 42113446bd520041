// Figures that tools print at load.
#include "pvol/volume/facts.h"

#include <gtest/gtest.h>

#include "pvol/bounds/pyramid.h"
#include "pvol/embed.h"
#include "pvol/field/brick_field.h"
#include "pvol/volume/make_volume.h"
#include "support/fields.h"

namespace pvol::test {
namespace facts_test {

TEST(Facts, ThicknessIsTheMeanOverColumnsThatHoldAnything) {
  const Field f =
      make_field("slab", {0, 0, 0}, {16, 24, 40}, [](Vec3i p) { return p.x < 8 ? 1.0 : 0.0; });
  const VolumeFacts v = describe(f.grid, 0.5, {});
  EXPECT_DOUBLE_EQ(v.mean_optical_thickness[0], 4);
  EXPECT_DOUBLE_EQ(v.mean_optical_thickness[1], 12);
  EXPECT_DOUBLE_EQ(v.mean_optical_thickness[2], 20);
  EXPECT_DOUBLE_EQ(v.largest_optical_thickness, 20);
}

TEST(Facts, TheWorldsBoxHoldsAllVolumesThatHoldAnything) {
  const auto cube = [](double at, float value) {
    VoxelGrid grid;
    grid.tiles = {{{0, 0, 0}, 8, value}};
    return make_volume(grid, Medium{}, {.object_to_world = translation(Vec3d(at))});
  };
  const Volume near = cube(0, 1), nothing = cube(1000, 0), far = cube(50, 1);
  EXPECT_TRUE(world_box(std::vector{nothing}).empty());
  const Box box = world_box(std::vector{near, nothing, far});
  EXPECT_EQ(box.lo, near.density.world_box.lo);
  EXPECT_EQ(box.hi, far.density.world_box.hi);
}

/// What holds nothing lies nowhere: not too far away either.
TEST(Facts, NothingMayBeTurnedAboutAnyAxis) {
  const Affine turn{{Vec3d{0.36, 0.48, -0.8}, Vec3d{-0.8, 0.6, 0}, Vec3d{0.48, 0.64, 0.6}}, {}};
  const Volume v = make_volume(VoxelGrid{}, Medium{}, {.object_to_world = turn});
  EXPECT_TRUE(world_box(std::vector{v}).empty());
  EXPECT_EQ(describe(VoxelGrid{}, 1, turn).largest_optical_thickness, 0);
}

/// Leaves at the faces of a tile are alike: millions of them take a handful of bricks.
TEST(Facts, HugeTilesTakeLittleMemory) {
  VoxelGrid grid;
  grid.tiles = {{{0, 0, 0}, 1024, 1.0f}};
  for (const LookUp look_up : {LookUp::trilinear, LookUp::tricubic}) {
    const Pyramid p = build_pyramid(grid, look_up);
    const Volume v = make_volume(grid, p, Medium{}, {.look_up = look_up});
    EXPECT_LT(v.density.bricks().bricks(), 128u);
    EXPECT_EQ(density_at(v, {-0.5, 100.25, 7}), 0.5f);
    EXPECT_EQ(density_at(v, {500, 100.25, 7}), 1.0f);
    EXPECT_EQ(density_at(v, {1023.5, 100.25, 500}), 0.5f);
  }
}

/// A tile of 4096^3 voxels beside one of 128^3: columns count by how many there are.
TEST(Facts, HugeTilesWeighWhatTheyAre) {
  VoxelGrid grid;
  grid.tiles = {{{0, 0, 0}, 4096, 1.0f}, {{4096, 4096, 4096}, 128, 1.0f}};
  const double large = 4096.0 * 4096, small = 128.0 * 128;
  const VolumeFacts v = describe(grid, 1, {});
  for (const double thickness : v.mean_optical_thickness) {
    EXPECT_NEAR(thickness, (large * 4096 + small * 128) / (large + small), 1e-6);
  }
}

}  // namespace facts_test
}  // namespace pvol::test
