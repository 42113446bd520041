#include "pvol/density/cumulus.h"

#include <gtest/gtest.h>

#include "pvol/error.h"

namespace pvol {
namespace cumulus_test {

/// Lowest and highest y, and the spread along x and z, of the points with density > 0.
Box extent_of_cloud(const Recipe& recipe) {
  Box box;
  const VoxelGrid grid = make_grid(recipe);
  for (const Brick& b : grid.bricks) {
    for (int n = 0; n < kBrickSamples; ++n) {
      const Vec3i at = b.origin + Vec3i{n / 64, n / 8 % 8, n % 8};
      if (b.values[n] > 0) box = extend(box, Vec3d(at) * recipe.voxel);
    }
  }
  return box;
}

TEST(Cumulus, HasAboutItsWidthAndHeightAndStandsOnItsBase) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Recipe r = make_recipe({.seed = seed, .width = 4, .height = 2});
    r.voxel = voxel_for(r, 64);
    const Box b = extent_of_cloud(r);
    EXPECT_GT(b.extent().x, 0.7 * 4);
    EXPECT_LT(b.extent().x, 1.4 * 4);
    EXPECT_GT(b.hi.y, 0.7 * 2);
    EXPECT_LT(b.hi.y, 1.4 * 2);
    EXPECT_GT(b.lo.y, -0.1 * 4);
    EXPECT_LT(b.lo.y, 0.05 * 4);
  }
}

TEST(Cumulus, IsTheSameForTheSameSeedAndAnotherForAnother) {
  EXPECT_EQ(make_recipe({.seed = 5}), make_recipe({.seed = 5}));
  EXPECT_NE(make_recipe({.seed = 5}), make_recipe({.seed = 6}));
}

/// A scene names a seed: the cloud that it had last year is the one that it has today.
TEST(Cumulus, StaysTheCloudThatItWas) {
  Recipe r = make_recipe({.seed = 5});
  r.voxel = voxel_for(r, 32);
  const VoxelGrid grid = make_grid(r);
  double sum = 0;
  for (const Brick& b : grid.bricks) {
    for (int n = 0; n < kBrickSamples; ++n) sum += double(b.values[n]);
  }
  for (const Tile& t : grid.tiles) sum += double(t.value) * t.edge * t.edge * t.edge;
  EXPECT_NEAR(sum, 3405.4, 0.05);
}

TEST(Cumulus, KeepsItsShapeWhenScaled) {
  const Recipe small = make_recipe({.width = 1, .height = 0.5});
  const Recipe large = make_recipe({.width = 1024, .height = 512});  // a power of 2: no rounding
  ASSERT_EQ(small.forms.size(), large.forms.size());
  for (const Vec3d p : {Vec3d{0, 0.1, 0}, Vec3d{0.1, 0.4, 0.1}, Vec3d{-0.3, 0.05, 0.1}}) {
    EXPECT_NEAR(density(small, p), density(large, p * 1024.0), 1e-9);
  }
}

TEST(Cumulus, IsValidAtTheEndsOfItsRanges) {
  for (const Cumulus& c :
       {Cumulus{.width = 1, .height = 0.2, .towers = 1, .generations = 0, .detail = 0, .wisps = 0},
        Cumulus{.width = 1, .height = 2, .towers = kMostTowers, .generations = 1},
        Cumulus{.detail = 2, .wisps = 2}, Cumulus{.width = 1e20, .height = 1e20},
        Cumulus{.width = 1e-20, .height = 1e-20}}) {
    EXPECT_NO_THROW(validate(make_recipe(c)));
  }
}

TEST(Cumulus, RefusesWhatIsOutOfRange) {
  for (const Cumulus& c :
       {Cumulus{.width = 0}, Cumulus{.width = -1}, Cumulus{.height = 100}, Cumulus{.height = 0},
        Cumulus{.towers = 0}, Cumulus{.towers = kMostTowers + 1}, Cumulus{.generations = 4},
        Cumulus{.detail = -1}, Cumulus{.wisps = 3},
        Cumulus{.width = std::numeric_limits<double>::quiet_NaN()}}) {
    EXPECT_THROW(static_cast<void>(make_recipe(c)), Error);
  }
}

}  // namespace cumulus_test
}  // namespace pvol
