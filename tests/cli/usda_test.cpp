// Scenes of USD as users convert and render them.
#include <gtest/gtest.h>

#include <fstream>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace usda_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// A small cloud right of the camera's axis and above it, in a world where z is up.
constexpr const char* kScene = R"(#usda 1.0
( upAxis = "Z" metersPerUnit = 1 )
def Volume "cloud" {
    rel field:density = </cloud/density>
    double3 xformOp:translate.timeSamples = { 1: (1, 0, 1), 2: (-1, 0, 1) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def OpenVDBAsset "density" { asset filePath = @ball.vdb@ token fieldName = "density" }
}
def Camera "camera" {
    float focalLength = 20 float horizontalAperture = 20 float verticalAperture = 15
    double3 xformOp:translate = (0, -6, 0)
    float xformOp:rotateX = 90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
}
def DomeLight "sky" { }
def RenderSettings "settings" { int2 resolution = (32, 24) }
)";

class UsdaTool : public ::testing::Test {
 protected:
  UsdaTool() {
    write("a.usda", kScene);
    write("ball.toml",
          "[recipe]\nvoxel = 0.06\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\n"
          "radii = [0.5, 0.5, 0.5]\n");
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  [[nodiscard]] RunResult convert(std::vector<std::string> arguments) const {
    for (std::string& a : arguments) {
      if (a.find('.') != a.npos) a = folder_ / a;
    }
    return run_tool(PVOL_CONVERT, arguments);
  }
  /// The centre of what is seen of the converted scene, in pixels.
  [[nodiscard]] Vec3d seen(const std::string& toml) const {
    const RunResult shown =
        run_tool(PVOL_RENDER, {folder_ / toml, "-o", folder_ / "b.exr", "--background", "off",
                               "--spp", "4", "--set", "medium.extinction=10"});
    EXPECT_EQ(shown.exit, 0) << shown.err;
    const Film film = formats::read_film(folder_ / "b.exr").film;
    Vec3d sum;
    double all = 0;
    for (int y = 0; y < film.height; ++y) {
      for (int x = 0; x < film.width; ++x) {
        const double alpha = film.at(x, y).alpha / film.at(x, y).samples;
        sum += Vec3d(x + 0.5, y + 0.5, 0) * alpha, all += alpha;
      }
    }
    return sum / all;
  }

  ScratchFolder folder_;
};

TEST_F(UsdaTool, TheCloudIsWhereUsdSeesItAtEachFrame) {
  ASSERT_EQ(convert({"ball.toml", "ball.vdb"}).exit, 0);
  const RunResult made = convert({"a.usda", "b.toml"});
  ASSERT_EQ(made.exit, 0) << made.err;
  EXPECT_NE(made.out.find("wrote "), std::string::npos) << made.out;
  // One of 6 units away and of half the aperture over the focal length: 32/6 pixels.
  EXPECT_LT(length(seen("b.toml") - Vec3d(16 + 32.0 / 6, 12 - 32.0 / 6, 0)), 0.4);
  ASSERT_EQ(convert({"a.usda", "c.toml", "--frame", "2"}).exit, 0);
  EXPECT_LT(length(seen("c.toml") - Vec3d(16 - 32.0 / 6, 12 - 32.0 / 6, 0)), 0.4);
}

TEST_F(UsdaTool, FramesOfOneSceneBecomeASequenceOfScenes) {
  EXPECT_EQ(convert({"a.usda", "d.##.toml", "--frames", "1-3"}).exit, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "d.03.toml"));
  EXPECT_NE(read_text(folder_ / "d.01.toml"), read_text(folder_ / "d.02.toml"));
  EXPECT_EQ(convert({"a.usda", "e.toml", "--frames", "1-3"}).exit, 2);
}

TEST_F(UsdaTool, TheSampleConvertsAndRenders) {
  std::filesystem::copy(PVOL_SAMPLES "/usd_scene.usda", folder_ / "s.usda");
  ASSERT_EQ(convert({"ball.toml", "cumulus.vdb"}).exit, 0);
  const RunResult made = convert({"s.usda", "s.toml", "--strict", "--json"});
  EXPECT_EQ(made.exit, 0) << made.err;
  const RunResult shown = run_tool(
      PVOL_RENDER, {folder_ / "s.toml", "-o", folder_ / "s.exr", "--size", "32x24", "--spp", "4"});
  EXPECT_EQ(shown.exit, 0) << shown.err;
}

TEST_F(UsdaTool, NotesAreWholeOnStderrAndAtopTheScene) {
  write("c.usda", std::string(kScene) + "def CylinderLight \"c\" { }\n");
  const RunResult made = convert({"c.usda", "c.toml"});
  EXPECT_TRUE(says(made.err, "usd.cylinder_light_on_stderr"));
  EXPECT_TRUE(says(read_text(folder_ / "c.toml"), "usd.cylinder_light_in_scene"));
  EXPECT_EQ(convert({"c.usda", "d.toml", "--strict"}).exit, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "d.toml"));
  EXPECT_EQ(convert({"c.usda", "d.toml", "--quiet"}).err, "");
}

TEST_F(UsdaTool, TextIsReadWhateverItsEndingAndBinaryFilesAreRefused) {
  write("c.usd", kScene);
  EXPECT_EQ(convert({"c.usd", "c.toml"}).exit, 0);
  write("d.usd", "PXR-USDC");
  const RunResult binary = convert({"d.usd", "d.toml"});
  EXPECT_EQ(binary.exit, 1);
  EXPECT_TRUE(says(binary.err, "usd.binary_to_the_tool"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "d.toml"));
  EXPECT_EQ(convert({"a.usda", "d.vdb"}).exit, 2);
}

}  // namespace usda_test
}  // namespace pvol
