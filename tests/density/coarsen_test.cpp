// Coarser grids keep the mass, the place and what is constant or linear.
#include "pvol/density/coarsen.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "support/fields.h"

namespace pvol::test {
namespace coarsen_test {

/// Sum of all samples times the volume of a cell.
double mass(const VoxelGrid& g) {
  double sum = 0;
  for (const Brick& b : g.bricks) {
    for (int i = 0; i < kBrickSamples; ++i) sum += double(b.values[i]);
  }
  for (const Tile& t : g.tiles) sum += double(t.value) * std::pow(double(t.edge), 3);
  return sum * std::abs(determinant(g.index_to_world));
}

TEST(Coarsen, KeepsTheMass) {
  for (const Field& f : fields()) {
    VoxelGrid g = f.grid;
    const double before = mass(g);
    for (int times = 1; times <= 3; ++times) {
      g = coarsen(g);
      EXPECT_NEAR(mass(g) / before, 1, 1e-5) << f.name << ", " << times << " times";
    }
  }
}

TEST(Coarsen, WeighsNeighboursByTents) {
  const Field f = make_field("random", {-5, 3, 1}, {21, 18, 30}, [](Vec3i p) {
    const int h = (p.x * 7 + p.y * 13 + p.z * 29) % 11;
    return double(h < 0 ? h + 11 : h);
  });
  const VoxelGrid coarse = coarsen(f.grid);
  for (int x = -4; x < 10; ++x) {
    for (int y = 0; y < 12; ++y) {
      for (int z = -1; z < 18; ++z) {
        double expected = 0;
        for (int i = -1; i <= 1; ++i) {
          for (int j = -1; j <= 1; ++j) {
            for (int k = -1; k <= 1; ++k) {
              const double weight = (i ? 0.25 : 0.5) * (j ? 0.25 : 0.5) * (k ? 0.25 : 0.5);
              expected += weight * double(f.at({2 * x + i, 2 * y + j, 2 * z + k}));
            }
          }
        }
        ASSERT_NEAR(double(sample(coarse, {x, y, z})), expected, 1e-5) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(Coarsen, LeavesTheCloudInItsPlace) {
  const Field f = make_field(
      "linear", {0, 0, 0}, {32, 16, 16}, [](Vec3i p) { return double(p.x + 1); }, Tiles::none,
      0.25);
  const VoxelGrid coarse = coarsen(f.grid);
  const Vec3d from_coarse = coarse.index_to_world.point({5, 3, 2});
  const Vec3d from_fine = f.grid.index_to_world.point({10, 6, 4});
  EXPECT_NEAR(length(from_coarse - from_fine), 0, 1e-12);
  EXPECT_FLOAT_EQ(sample(coarse, {5, 3, 2}), f.at({10, 6, 4}));
}

TEST(Coarsen, KeepsTilesThatAreConstant) {
  const Field& f = field("tiles_128");
  const VoxelGrid coarse = coarsen(f.grid);
  EXPECT_FLOAT_EQ(sample(coarse, {-32, 32, 32}), 0.75f);
  EXPECT_NO_THROW((void)build_pyramid(coarse));
}

TEST(Coarsen, RefusesTilesBeyondMemory) {
  VoxelGrid g;
  for (int i = 0; i < 40; ++i) g.tiles.push_back({{i * 4096, 0, 0}, 4096, 1.0f});
  EXPECT_THROW((void)coarsen(g), Error);
}

}  // namespace coarsen_test
}  // namespace pvol::test
