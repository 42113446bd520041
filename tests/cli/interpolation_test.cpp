// --interpolation of pvol-fit and pvol-render, and what goes with which cloud.
#include <gtest/gtest.h>

#include <fstream>

#include "pvol/formats/pvol_file.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace interpolation_test {

using testing::run_tool;
using testing::RunResult;

class Interpolations : public ::testing::Test {
 protected:
  testing::ScratchFolder folder_;
  const std::string recipe_ = folder_ / "ball.toml", grid_ = folder_ / "ball.vdb";

  void SetUp() override {
    std::ofstream(recipe_) << "[recipe]\nresolution = 24\nedge = 0.2\n[[form]]\n"
                              "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
    ASSERT_EQ(run_tool(PVOL_CONVERT, {recipe_, grid_}).exit, 0);
  }

  /// A tiny picture of the cloud; its statistics are on stdout.
  [[nodiscard]] RunResult render(const std::string& cloud, const std::string& look_up,
                                 std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{
        cloud,     "-o", folder_ / "out.exr", "--size", "16x16",  "--spp", "4",
        "--stats", "-",  "--interpolation",   look_up,  "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(PVOL_RENDER, arguments);
  }
  void expect_renders(const std::string& cloud, const std::string& look_up) const {
    const RunResult r = render(cloud, look_up);
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_NE(r.out.find('"' + look_up + '"'), std::string::npos) << r.out;
  }
  void expect_refused(const std::string& cloud, const std::string& look_up,
                      const std::string& key) const {
    const RunResult r = render(cloud, look_up);
    EXPECT_EQ(r.exit, 1) << cloud;
    EXPECT_NE(r.err.find(cloud), std::string::npos) << r.err;
    EXPECT_TRUE(says(r.err, key));
  }
};

TEST_F(Interpolations, EveryCloudTakesWhatItCan) {
  for (const char* i : {"nearest", "trilinear", "tricubic"}) {
    expect_renders(grid_, i);
    expect_renders(recipe_, i);
  }
  expect_renders(recipe_, "procedural");
  expect_refused(grid_, "procedural", "interpolation.procedural_look_ups");
  EXPECT_EQ(render(grid_, "cubic").exit, 2);
}

TEST_F(Interpolations, FilesSayWhatTheirBoundsHoldFor) {
  const std::string narrow = folder_ / "narrow.pvol", wide = folder_ / "wide.pvol",
                    closed = folder_ / "closed.pvol";
  ASSERT_EQ(run_tool(PVOL_FIT, {grid_, "-o", narrow}).exit, 0);
  ASSERT_EQ(
      run_tool(PVOL_FIT, {grid_, "-o", wide, "--interpolation", "tricubic", "--shells", "4"}).exit,
      0);
  ASSERT_EQ(run_tool(PVOL_FIT, {recipe_, "-o", closed, "--closed-form"}).exit, 0);
  EXPECT_EQ(formats::read_pvol(narrow).pyramid.look_up, LookUp::trilinear);
  EXPECT_EQ(formats::read_pvol(wide).pyramid.look_up, LookUp::tricubic);
  EXPECT_EQ(formats::read_pvol(closed).pyramid.look_up, LookUp::procedural);

  expect_renders(narrow, "trilinear");
  expect_refused(narrow, "tricubic", "interpolation.bounds_made_interpolation");
  expect_refused(narrow, "procedural", "interpolation.procedural_look_ups_recipes");
  for (const char* i : {"nearest", "trilinear", "tricubic"}) expect_renders(wide, i);
  EXPECT_EQ(render(wide, "tricubic", {"--shells", "on"}).exit, 0);  // proves its shell again
  for (const char* i : {"nearest", "trilinear", "procedural"}) expect_renders(closed, i);
  expect_refused(closed, "tricubic", "interpolation.bounds_made_interpolation");

  // New samples get new bounds, also where the old ones were in closed form.
  EXPECT_EQ(render(closed, "trilinear", {"--preview", "1"}).exit, 0);
  EXPECT_EQ(render(closed, "trilinear", {"--density", "fp8"}).exit, 0);
  EXPECT_EQ(render(wide, "tricubic", {"--density", "fp8", "--preview", "1"}).exit, 0);
  const RunResult unsampled = render(closed, "procedural", {"--preview", "1"});
  EXPECT_EQ(unsampled.exit, 1);
  EXPECT_TRUE(says(unsampled.err, "interpolation.procedural_look"));

  std::ofstream(recipe_, std::ios::app) << "# changed\n";
  expect_refused(closed, "procedural", "interpolation.density_ball_toml");
}

TEST_F(Interpolations, ClosedFormsAndCellsDoNotMixWithOthers) {
  EXPECT_EQ(run_tool(PVOL_FIT, {recipe_, "-o", folder_ / "x.pvol", "--closed-form",
                                "--interpolation", "tricubic"})
                .exit,
            2);
  EXPECT_EQ(
      run_tool(PVOL_FIT, {grid_, "-o", folder_ / "x.pvol", "--interpolation", "procedural"}).exit,
      2);
  for (const char* option : {"--tracker", "--transmittance"}) {
    const RunResult r = render(grid_, "tricubic", {option, "regular"});
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(says(r.err, "interpolation.regular_tracking_regular"));
  }
  const std::string scene = folder_ / "scene.toml";
  std::ofstream(scene) << "[[volume]]\nfile = \"ball.toml\"\n[[volume]]\nfile = \"ball.vdb\"\n"
                          "[render]\ninterpolation = \"procedural\"\n";
  const RunResult r = run_tool(PVOL_RENDER, {scene, "-o", folder_ / "two.exr"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "interpolation.procedural_look_ups"));
}

}  // namespace interpolation_test
}  // namespace pvol
