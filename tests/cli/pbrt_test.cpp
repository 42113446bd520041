// Scenes of pbrt-v4 as users convert and render them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace pbrt_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// A dense cube of 0.8 right of the middle, above it and off the depth of the target.
constexpr const char* kScene = R"(
LookAt 1 2 -6   0 0.5 0   0 1 0
Camera "perspective" "float fov" 50
Film "rgb" "integer xresolution" 32 "integer yresolution" 24
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite" "rgb L" [ 1 1 1 ]
Translate 0.9 1.2 -1
Scale 0.8 0.8 0.8
MakeNamedMedium "cube" "string type" "homogeneous" "rgb sigma_a" [ 50 50 50 ] "rgb sigma_s" [ 1 1 1 ]
MediumInterface "cube" ""
Material "interface"
Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 ]
  "integer indices" [ 0 1 2  5 6 7  1 3 4 ]
)";

class PbrtTool : public ::testing::Test {
 protected:
  PbrtTool() { write("a.pbrt", kScene); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  [[nodiscard]] RunResult convert(std::vector<std::string> arguments) const {
    for (std::string& a : arguments) {
      if (!a.starts_with("--")) a = folder_ / a;
    }
    return run_tool(PVOL_CONVERT, arguments);
  }

  ScratchFolder folder_;
};

/// Where pbrt's camera of kScene sees a place: raster of its screen window, +x right, +y up.
Vec3d raster(Vec3d place) {
  const Vec3d eye{1, 2, -6}, z = normalize(Vec3d{0, 0.5, 0} - eye);
  const Vec3d x = normalize(cross(Vec3d{0, 1, 0}, z)), y = cross(z, x), d = place - eye;
  const double t = std::tan(25 * std::numbers::pi / 180) * dot(d, z);
  return {(dot(d, x) / t / (4.0 / 3) + 1) / 2 * 32, (1 - dot(d, y) / t) / 2 * 24, 0};
}

TEST_F(PbrtTool, TheCloudIsWherePbrtSeesIt) {
  const RunResult made = convert({"a.pbrt", "b.toml"});
  EXPECT_EQ(made.exit, 0) << made.err;
  EXPECT_NE(made.out.find("wrote "), std::string::npos) << made.out;
  EXPECT_TRUE(says(made.err, "pbrt.pbrt_coordinates_left"));
  const RunResult shown =
      run_tool(PVOL_RENDER, {folder_ / "b.toml", "-o", folder_ / "b.exr", "--background", "off"});
  ASSERT_EQ(shown.exit, 0) << shown.err;
  const Film film = formats::read_film(folder_ / "b.exr").film;
  ASSERT_EQ(film.width, 32);
  ASSERT_EQ(film.height, 24);
  Vec3d lo{1e9}, hi{-1e9}, middle, seen;
  for (int i = 0; i < 8; ++i) {
    const Vec3d at = raster(Vec3d{0.9, 1.2, -1} + Vec3d(i & 1, i >> 1 & 1, i >> 2) * 0.8);
    lo = min(lo, at), hi = max(hi, at), middle += at / 8.0;
  }
  ASSERT_GT(lo.x, 17);  // so that a mirrored picture has it elsewhere
  ASSERT_LT(hi.y, 12);
  double sum = 0;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; ++x) {
      const PixelSums& p = film.at(x, y);
      const double alpha = p.alpha / p.samples;
      const bool outside = x + 2 < lo.x || x - 1 > hi.x || y + 2 < lo.y || y - 1 > hi.y;
      if (outside) {
        EXPECT_EQ(alpha, 0) << x << ", " << y;
      }
      sum += alpha, seen += Vec3d(x + 0.5, y + 0.5, 0) * alpha;
    }
  }
  EXPECT_GT(sum, 5);
  EXPECT_LT(length(seen / sum - middle), 0.6);
}

TEST_F(PbrtTool, TheSampleConvertsAndRenders) {
  const RunResult made =
      run_tool(PVOL_CONVERT, {PVOL_SAMPLES "/pbrt_scene.pbrt", folder_ / "s.toml", "--json"});
  EXPECT_EQ(made.exit, 0) << made.err;
  EXPECT_NE(made.out.find("\"warnings\""), std::string::npos);
  const RunResult shown = run_tool(
      PVOL_RENDER, {folder_ / "s.toml", "-o", folder_ / "s.exr", "--size", "32x24", "--spp", "4"});
  EXPECT_EQ(shown.exit, 0) << shown.err;
}

TEST_F(PbrtTool, NotesAreWholeOnStderrAndAtopTheScene) {
  write("c.pbrt", std::string(kScene) + "LightSource \"projection\"\n");
  const RunResult made = convert({"c.pbrt", "c.toml"});
  EXPECT_TRUE(says(made.err, "pbrt.lights_type_projection"));
  EXPECT_TRUE(says(read_text(folder_ / "c.toml"), "pbrt.lights_type_projection"));
  EXPECT_EQ(convert({"c.pbrt", "d.toml", "--strict"}).exit, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "d.toml"));
  EXPECT_EQ(convert({"c.pbrt", "d.toml", "--quiet"}).err, "");
}

TEST_F(PbrtTool, FilesOfOthersAreNotReplaced) {
  write("b_cube.vdb", "mine");
  const RunResult other = convert({"a.pbrt", "b.toml"});
  EXPECT_EQ(other.exit, 1);
  EXPECT_TRUE(says(other.err, "pbrt.beside_is_there"));
  EXPECT_EQ(read_text(folder_ / "b_cube.vdb"), "mine");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.toml"));
  EXPECT_EQ(convert({"a.pbrt", "c.toml"}).exit, 0);
  EXPECT_EQ(convert({"a.pbrt", "c.toml"}).exit, 0);  // over its own
  write("d.toml", "Include \"a.pbrt\"");
  write("d.pbrt", "Include \"d.toml\"");
  EXPECT_TRUE(says(convert({"d.pbrt", "d.toml"}).err, "pbrt.input_is_output"));
  EXPECT_EQ(read_text(folder_ / "d.toml"), "Include \"a.pbrt\"");
}

TEST_F(PbrtTool, BadScenesAndPairsLeaveNothing) {
  write("bad.pbrt", std::string(kScene) + "Shape \"sphere\" \"float radius\" [ one ]\n");
  const RunResult bad = convert({"bad.pbrt", "e.toml"});
  EXPECT_EQ(bad.exit, 1);
  EXPECT_TRUE(says(bad.err, "pbrt.value_float"));
  const RunResult pair = convert({"a.pbrt", "e.vdb"});
  EXPECT_EQ(pair.exit, 2);
  EXPECT_TRUE(says(pair.err, "pbrt.no_conversion_pbrt"));
  EXPECT_EQ(convert({"none.pbrt", "e.toml"}).exit, 1);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    EXPECT_EQ(entry.path().extension(), ".pbrt") << entry.path();
  }
}

}  // namespace pbrt_test
}  // namespace pvol
