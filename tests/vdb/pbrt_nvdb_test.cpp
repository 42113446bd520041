// Media of pbrt's scenes that are files of NanoVDB.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <algorithm>
#include <cmath>

#include "pvol/formats/cloud.h"
#include "support/messages.h"
#include "support/pbrt_text.h"

namespace pvol::formats {
namespace pbrt_nvdb_test {

using test::notes_of;
using test::pbrt_text;

/// Samples of 0 to 9 along each axis, half a unit apart.
openvdb::FloatGrid::Ptr block(const std::string& name, float factor) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  for (int i = 0; i < 1000; ++i) {
    grid->tree().setValue({i / 100, i / 10 % 10, i % 10}, factor * float(i / 100 + 1));
  }
  return grid;
}

class PbrtNvdb : public ::testing::Test {
 protected:
  PbrtNvdb() {
    std::filesystem::create_directory(folder_.file("clouds"));
    std::vector<nanovdb::GridHandle<>> grids;
    grids.push_back(nanovdb::openToNanoVDB(*block("density", 1)));
    grids.push_back(nanovdb::openToNanoVDB(*block("temperature", 0.3f)));
    nanovdb::io::writeGrids(folder_.file("clouds/a.nvdb").string(), grids);
  }

  [[nodiscard]] PbrtScene scene(const std::string& parameters, const std::string& shape) const {
    const std::string fog =
        "Translate 1 2 3\nMakeNamedMedium \"c\" \"string type\" \"nanovdb\" \"string filename\" "
        "\"clouds/a.nvdb\" \"rgb sigma_a\" [ 1 2 1 ] \"rgb sigma_s\" [ 4 3 4 ] " +
        parameters + "\nMediumInterface \"c\" \"\" Material \"interface\" " + shape;
    write_bytes(folder_.file("a.pbrt"), pbrt_text("Camera \"perspective\"", "", fog));
    return read_pbrt(folder_.file("a.pbrt"), "out");
  }

  TemporaryFolder folder_;
};

constexpr const char* kLarge = "Translate 2.25 2.25 2.25 Shape \"sphere\" \"float radius\" 4";
constexpr const char* kSmall = "Translate 2.25 2.25 2.25 Shape \"sphere\" \"float radius\" 3";

TEST_F(PbrtNvdb, TheFileStaysAndHasThePlaceOfItsMedium) {
  const PbrtScene s = scene("\"float LeScale\" 0", kLarge);
  const SceneVolume& v = s.file.volumes.at(0);
  EXPECT_EQ(v.file, folder_.file("clouds/a.nvdb"));
  EXPECT_EQ(v.grid, "density");
  EXPECT_EQ(v.medium.extinction, 5);
  EXPECT_FALSE(v.fire);
  EXPECT_TRUE(s.volumes.empty());
  EXPECT_EQ(v.object_to_world.point({4, 5, 6}), Vec3d(5, 7, -9));  // z is mirrored
  EXPECT_EQ(times_said(notes_of(s), "pbrt.sphere_cuts_off"), 0);
  write_imported(folder_.file("b.toml"), s);
  EXPECT_NE(read_bytes(folder_.file("b.toml")).find("file = \"clouds/a.nvdb\""), std::string::npos);
  EXPECT_EQ(read_scene(folder_.file("b.toml")).volumes.at(0).file, folder_.file("clouds/a.nvdb"));
}

TEST_F(PbrtNvdb, AShapeThatIsTooSmallIsNamed) {
  EXPECT_TRUE(says(notes_of(scene("", kSmall)), "pbrt.sphere_cuts_off_part"));
}

TEST_F(PbrtNvdb, TemperaturesGlow) {
  const PbrtScene s = scene("\"float LeScale\" 2 \"float temperaturescale\" 1000", kLarge);
  const SceneVolume& v = s.file.volumes.at(0);
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(v.fire->field, "density");
  EXPECT_EQ(v.fire->color_by, "temperature");
  const FireFields fields = load_fire(v.file, *v.fire);
  EXPECT_TRUE(fields.color_by);
  // Twice the light of the body, by density and absorption, of which green has twice as much.
  const Rgb one = emission(*v.fire, 1, 2), two = emission(*v.fire, 2, 2);
  EXPECT_GT(one.x, one.y);
  EXPECT_NEAR(double(two.x / one.x), 2, 1e-5);
  const PbrtScene cold = scene("\"float temperaturescale\" 10", kLarge);  // below 100 K
  EXPECT_FALSE(cold.file.volumes.at(0).fire);
}

}  // namespace pbrt_nvdb_test
}  // namespace pvol::formats
