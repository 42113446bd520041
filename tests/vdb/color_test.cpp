// Colours in .vdb files: what is taken, counted and refused, and what is written again.
#include "pvol/formats/color.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <limits>

#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace color_test {

namespace fs = std::filesystem;
using test::error_of;

class Colors : public ::testing::Test {
 protected:
  TemporaryFolder folder_;

  Colors() { openvdb::initialize(); }

  fs::path write(const openvdb::GridCPtrVec& grids) {
    const fs::path path = folder_.file("c.vdb");
    openvdb::io::File file(path.string());
    file.write(grids);
    return path;
  }
};

/// Each channel its own at (i, 0, -i), black ones among them, a tile, and a background that is
/// none.
template <class Grid>
typename Grid::Ptr vectors(const std::string& name) {
  using Vector = typename Grid::ValueType;
  using Number = typename Vector::value_type;
  auto grid = Grid::create(Vector(Number(0.5)));
  for (int i = 0; i < 12; ++i) {
    grid->tree().setValueOn({i, 0, -i}, Vector(Number(i) / 16, Number(i % 2), Number(0)));
  }
  grid->tree().addTile(1, {64, 0, 0}, Vector(Number(0.25), Number(0), Number(1)), true);
  grid->tree().addTile(1, {72, 0, 0}, Vector(Number(0)), true);
  grid->setName(name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  return grid;
}

void expect_sample(const ColorGrid& grid, Vec3i p, Rgb color, float known) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(sample(grid.channels[c], p), color[int(c)]) << c;
  EXPECT_EQ(sample(grid.known, p), known);
}

void expect_vectors(const ColorGrid& grid) {
  for (int i = 0; i < 12; ++i) {
    expect_sample(grid, {i, 0, -i}, Rgb(float(i) / 16, float(i % 2), 0.0f), 1);
  }
  expect_sample(grid, {67, 7, 2}, Rgb(0.25f, 0.0f, 1.0f), 1);
  expect_sample(grid, {72, 7, 2}, Rgb(0.0f), 1);
  expect_sample(grid, {63, 7, 2}, Rgb(0.0f), 0);
  expect_sample(grid, {1, 0, 0}, Rgb(0.0f), 0);
  EXPECT_EQ(grid.index_to_world(), scaling(Vec3d(0.5)));
  EXPECT_EQ(grid.name(), "Cd");
}

TEST_F(Colors, AreTheActiveVectors) {
  const auto as_halves = vectors<openvdb::Vec3SGrid>("Cd");
  as_halves->setSaveFloatAsHalf(true);
  const openvdb::GridCPtrVec all{vectors<openvdb::Vec3SGrid>("Cd"),
                                 vectors<openvdb::Vec3DGrid>("Cd"), as_halves};
  for (const openvdb::GridBase::ConstPtr& grid : all) {
    const fs::path file = write({grid});
    const LoadedColor loaded = read_color(file, "cd");
    expect_vectors(loaded.grid);
    EXPECT_TRUE(loaded.report.warnings.empty());
    EXPECT_EQ(loaded.report.active, 3 * (12 + 2 * 512u));
    EXPECT_EQ(usual_color_grid(grids_of(file)), "Cd");
  }
}

TEST_F(Colors, AreWrittenAndReadAgain) {
  const LoadedColor loaded = read_color(write({vectors<openvdb::Vec3SGrid>("Cd")}), "Cd");
  const fs::path again = folder_.file("again.vdb");
  write_vdb(again, {}, {&loaded.grid});
  expect_vectors(read_color(again, "Cd").grid);
}

TEST_F(Colors, OfAnAlbedoFieldAreColoursOrNumbers) {
  const AlbedoGrid tint = load_albedo(write({vectors<openvdb::Vec3SGrid>("Cd")}), {.grid = "Cd"});
  ASSERT_TRUE(tint.colors);
  EXPECT_FALSE(tint.numbers);
  expect_vectors(tint.colors->grid);
  auto grid = openvdb::FloatGrid::create(0.0f);
  grid->tree().setValueOn({2, 3, 4}, 0.25f);
  grid->setName("soot");
  const AlbedoGrid soot = load_albedo(write({grid}), {.grid = "soot"});
  EXPECT_FALSE(soot.colors);
  ASSERT_TRUE(soot.numbers);
  EXPECT_EQ(soot.numbers->metadata.source.grid, "soot");
}

TEST_F(Colors, OutOfRangeAreCountedAndTakenIntoIt) {
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  grid->tree().setValueOn({0, 0, 0}, openvdb::Vec3s(std::nanf(""), -2.0f, 7.0f));
  grid->tree().setValueOn({1, 0, 0}, openvdb::Vec3s(kInfinity, 0.5f, 1.5f));
  grid->setName("Cd");
  const fs::path file = write({grid});
  const LoadedColor loaded = read_color(file, "Cd");
  expect_sample(loaded.grid, {0, 0, 0}, Rgb(0.0f, 0.0f, 1.0f), 1);
  expect_sample(loaded.grid, {1, 0, 0}, Rgb(0.0f, 0.5f, 1.0f), 1);
  EXPECT_EQ(loaded.report.non_finite, 2u);
  EXPECT_EQ(loaded.report.negative, 1u);
  ASSERT_EQ(loaded.report.warnings.size(), 3u);
  EXPECT_TRUE(says(loaded.report.warnings[0], "albedo.colours_not_finite"));
  EXPECT_TRUE(says(loaded.report.warnings[1], "albedo.colours_negative"));
  EXPECT_TRUE(says(loaded.report.warnings[2], "albedo.colours_above_one"));
  EXPECT_TRUE(
      says(error_of([&] { (void)read_color(file, "Cd", true); }), "albedo.grid_cd_components"));
}

TEST_F(Colors, OfOtherFilesAndNamesAreRefused) {
  const fs::path file = write({vectors<openvdb::Vec3SGrid>("tint")});
  EXPECT_TRUE(says(error_of([&] { (void)read_color(file, "Cd"); }), "albedo.no_grid_vectors"));
  EXPECT_TRUE(says(error_of([&] { (void)read_color("a.nvdb", "Cd"); }), "albedo.colours_read_vdb"));
  EXPECT_TRUE(
      says(error_of([&] { (void)load_albedo(file, {.grid = "tint", .map = {.scale = 2}}); }),
           "albedo.grid_tint_colours"));
}

}  // namespace color_test
}  // namespace pvol::formats
