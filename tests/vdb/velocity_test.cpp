// Velocities in .vdb files: vectors, three grids of numbers, names, and what cannot be.
#include "pvol/formats/velocity.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <limits>

#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace velocity_test {

namespace fs = std::filesystem;
using test::error_of;

class Velocity : public ::testing::Test {
 protected:
  TemporaryFolder folder_;

  Velocity() { openvdb::initialize(); }

  fs::path write(const openvdb::GridCPtrVec& grids) {
    const fs::path path = folder_.file("v.vdb");
    openvdb::io::File file(path.string());
    file.write(grids);
    return path;
  }
};

openvdb::math::Transform::Ptr voxel(double size) {
  return openvdb::math::Transform::createLinearTransform(size);
}

/// (1, -2, 3) i at (i, 0, -i), and a tile.
template <class Grid>
typename Grid::Ptr vectors(const std::string& name) {
  using Vector = typename Grid::ValueType;
  auto grid = Grid::create(Vector(0.0));
  for (int i = 1; i < 12; ++i) {
    const auto x = typename Vector::value_type(i);
    grid->tree().setValueOn({i, 0, -i}, Vector(x, -2 * x, 3 * x));
  }
  grid->tree().addTile(1, {64, 0, 0}, Vector(-1, 0, 4), true);
  grid->setName(name);
  grid->setTransform(voxel(0.5));
  return grid;
}

openvdb::FloatGrid::Ptr numbers(const std::string& name, float value, double size = 0.5) {
  auto grid = openvdb::FloatGrid::create(0.0f);
  grid->tree().setValueOn({3, 4, -5}, value);
  grid->setName(name);
  grid->setTransform(voxel(size));
  return grid;
}

Vec3d at(const VelocityGrid& grid, Vec3i p) {
  return {double(sample(grid.along[0], p)), double(sample(grid.along[1], p)),
          double(sample(grid.along[2], p))};
}

void expect_vectors(const LoadedVelocity& v) {
  for (int i = 0; i < 12; ++i) EXPECT_EQ(at(v.grid, {i, 0, -i}), Vec3d(1, -2, 3) * double(i)) << i;
  EXPECT_EQ(at(v.grid, {67, 7, 2}), Vec3d(-1, 0, 4));
  EXPECT_EQ(at(v.grid, {63, 7, 2}), Vec3d(0));
  for (const VoxelGrid& g : v.grid.along) EXPECT_EQ(g.index_to_world, scaling(Vec3d(0.5)));
  EXPECT_TRUE(v.warnings.empty());
}

TEST_F(Velocity, OfARecipeIsCalledFlow) {
  const fs::path file = folder_.file("r.toml");
  std::ofstream(file) << "[recipe]\nresolution = 16\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, "
                         "0, 0]\nradii = 1\n"
                         "[flow]\nvelocity = [1, 0, 0]\n";
  for (const char* name : {"", "flow", "v"}) EXPECT_TRUE(read_velocity(file, name)) << name;
  EXPECT_TRUE(says(error_of([&] { (void)read_velocity(file, "wind"); }), "motion.of_recipe"));
}

TEST_F(Velocity, VectorsOfEveryPrecisionAreRead) {
  const auto half = vectors<openvdb::Vec3SGrid>("v");
  half->setSaveFloatAsHalf(true);
  for (const openvdb::GridBase::Ptr& grid : std::initializer_list<openvdb::GridBase::Ptr>{
           vectors<openvdb::Vec3SGrid>("v"), vectors<openvdb::Vec3DGrid>("v"), half}) {
    const auto loaded = read_velocity(write({numbers("density", 1), grid}), "v", true);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->name, "v");
    expect_vectors(*loaded);
  }
}

TEST_F(Velocity, UsualNamesAreFoundWhateverTheirCase) {
  for (const char* name : {"v", "V", "vel", "Vel", "VELOCITY"}) {
    const auto loaded =
        read_velocity(write({numbers("density", 1), vectors<openvdb::Vec3SGrid>(name)}), "");
    ASSERT_TRUE(loaded) << name;
    EXPECT_EQ(loaded->name, name);
  }
  // A number called v is none; v comes before velocity.
  EXPECT_EQ(read_velocity(write({numbers("v", 1), vectors<openvdb::Vec3SGrid>("velocity"),
                                 vectors<openvdb::Vec3SGrid>("vel")}),
                          "")
                ->name,
            "vel");
  EXPECT_FALSE(read_velocity(write({numbers("density", 1), numbers("v", 1)}), ""));
}

TEST_F(Velocity, ThreeGridsOfNumbersAreOne) {
  for (const char* between : {".", "_", ""}) {
    const auto part = [&](char axis, float value) {
      return numbers(std::string("Vel") + between + axis, value);
    };
    const fs::path file = write({part('z', 3), part('x', -1.5f), part('y', 2)});
    for (const char* name : {"", "vel"}) {
      const auto loaded = read_velocity(file, name);
      ASSERT_TRUE(loaded) << between;
      EXPECT_EQ(at(loaded->grid, {3, 4, -5}), Vec3d(-1.5, 2, 3));
      EXPECT_EQ(loaded->name, "vel");
    }
  }
}

TEST_F(Velocity, WhatIsNotFiniteIsTakenAsZero) {
  auto grid = vectors<openvdb::Vec3SGrid>("v");
  const float inf = std::numeric_limits<float>::infinity();
  grid->tree().setValueOn({20, 0, 0}, {1, -inf, std::numeric_limits<float>::quiet_NaN()});
  grid->tree().setValueOff({21, 0, 0}, {7, 7, 7});
  const fs::path file = write({grid});
  const auto loaded = read_velocity(file, "");
  EXPECT_EQ(at(loaded->grid, {20, 0, 0}), Vec3d(1, 0, 0));
  EXPECT_EQ(at(loaded->grid, {21, 0, 0}), Vec3d(0)) << "inactive";
  ASSERT_EQ(loaded->warnings.size(), 1u);
  EXPECT_EQ(loaded->warnings[0].find("2 components"), 0u) << loaded->warnings[0];
  EXPECT_TRUE(
      says(error_of([&] { (void)read_velocity(file, "", true); }), "motion.grid_v_refused"));
}

TEST_F(Velocity, StaggeredOnesAreTakenAtVoxelsWithAWarning) {
  auto grid = vectors<openvdb::Vec3SGrid>("v");
  grid->setGridClass(openvdb::GRID_STAGGERED);
  const auto loaded = read_velocity(write({grid}), "");
  ASSERT_EQ(loaded->warnings.size(), 1u);
  EXPECT_TRUE(says(loaded->warnings[0], "motion.velocities_staggered"));
}

TEST_F(Velocity, WhatCannotBeIsRefusedInWords) {
  const auto refusal = [](const fs::path& file, const std::string& name) {
    return error_of([&] { (void)read_velocity(file, name); });
  };
  const fs::path file = write({numbers("density", 1), vectors<openvdb::Vec3SGrid>("v")});
  EXPECT_TRUE(says(refusal(file, "wind"), "motion.no_grid_vectors"));
  EXPECT_TRUE(
      says(refusal(write({numbers("v.x", 1), numbers("v.y", 1, 0.25), numbers("v.z", 1)}), "v"),
           "motion.grids_v_x"));
  EXPECT_TRUE(says(refusal(folder_.file("cloud.nvdb"), ""), "motion.velocities_read_vdb"));
  EXPECT_NE(refusal(folder_.file("absent.vdb"), ""), "");
  auto frustum = vectors<openvdb::Vec3SGrid>("v");
  const openvdb::BBoxd box(openvdb::Vec3d(0.0), openvdb::Vec3d(100.0));
  frustum->setTransform(
      openvdb::math::Transform::createFrustumTransform(box, /*taper=*/0.5, /*depth=*/2.0));
  EXPECT_TRUE(says(refusal(write({frustum}), "v"), "motion.in_a_frustum"));
  // Cut off.
  const fs::path cut = write({vectors<openvdb::Vec3SGrid>("v")});
  fs::resize_file(cut, fs::file_size(cut) - 9);
  EXPECT_NE(refusal(cut, "v"), "");
}

}  // namespace velocity_test
}  // namespace pvol::formats
