// Motion blur as users call it: a .vdb with velocities, a shutter on the command line.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <fstream>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace motion_tool_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// A ball of fog that velocities carry to the right.
class MotionTool : public ::testing::Test {
 protected:
  MotionTool() : vdb_(folder_ / "fog.vdb") {
    openvdb::initialize();
    auto density = openvdb::FloatGrid::create(0.0f);
    auto velocity = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
    for (int x = 0; x < 24; ++x) {
      for (int y = 0; y < 24; ++y) {
        for (int z = 0; z < 24; ++z) {
          const float d = float((x - 12) * (x - 12) + (y - 12) * (y - 12) + (z - 12) * (z - 12));
          if (d < 100) density->tree().setValueOn({x, y, z}, 1 - d / 100);
        }
      }
    }
    velocity->tree().fill(openvdb::CoordBBox({-32, -8, -8}, {63, 31, 31}), {240, 0, 0}, true);
    density->setName("density");
    velocity->setName("vel");
    openvdb::io::File(vdb_).write({density, velocity});
    openvdb::io::File(folder_ / "plain.vdb").write({density});
  }

  [[nodiscard]] RunResult render(const std::string& cloud, const std::string& image,
                                 std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {cloud, "-o", folder_ / image, "--size", "24x16", "--spp", "16",
                               "--set", "medium.extinction=0.4"});
    return run_tool(PVOL_RENDER, more);
  }

  ScratchFolder folder_;
  std::string vdb_;
};

constexpr const char* kShutter = "camera.shutter=[-0.5, 0.5]";

TEST_F(MotionTool, AShutterIsAllThatItTakes) {
  const RunResult r = render(vdb_, "a.exr", {"--set", kShutter});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "motion.moves_grid_vel"));
  EXPECT_TRUE(says(r.err, "motion.motion_blurred_moves"));
  const auto same = [&](const std::string& a, const std::string& b) {
    return read_text(folder_ / a) == read_text(folder_ / b);
  };
  EXPECT_EQ(render(vdb_, "a.png", {"--set", kShutter}).exit, 0);
  EXPECT_EQ(render(vdb_, "still.png").exit, 0);
  EXPECT_EQ(render(vdb_, "closed.png", {"--set", "camera.shutter=[0, 0]"}).exit, 0);
  EXPECT_TRUE(same("still.png", "closed.png"));
  EXPECT_FALSE(same("still.png", "a.png"));
  // Half the frames in a second take a scale of a half.
  EXPECT_EQ(
      render(vdb_, "slow.png",
             {"--set", kShutter, "--set", "camera.fps=12", "--set", "medium.motion.scale=0.5"})
          .exit,
      0);
  EXPECT_TRUE(same("a.png", "slow.png"));
  // Velocities of another file.
  EXPECT_EQ(render(folder_ / "plain.vdb", "other.png",
                   {"--set", kShutter, "--set", "medium.motion.file=" + vdb_})
                .exit,
            0);
  EXPECT_TRUE(same("a.png", "other.png"));
}

TEST_F(MotionTool, AVolumeMovesAsAWholeWithoutVelocities) {
  const std::string cloud = folder_ / "plain.vdb";
  const std::vector<std::string> moves = {"--set", kShutter, "--set",
                                          "volume.to.translate=[10, 0, 0]"};
  const RunResult r = render(cloud, "whole.png", moves);
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "motion.motion_whole_moves"));
  EXPECT_EQ(times_said(r.err, "motion.no_velocities_v_vel_velocity"), 0);
  EXPECT_EQ(render(cloud, "rest.png").exit, 0);
  EXPECT_EQ(render(cloud, "shut.png", {"--set", "volume.to.translate=[10, 0, 0]"}).exit, 0);
  EXPECT_NE(read_text(folder_ / "whole.png"), read_text(folder_ / "rest.png"));
  EXPECT_EQ(read_text(folder_ / "shut.png"), read_text(folder_ / "rest.png"));
}

TEST_F(MotionTool, PrintedScenesRenderTheSamePicture) {
  const RunResult printed = run_tool(
      PVOL_RENDER, {vdb_, "--size", "24x16", "--spp", "16", "--set", "medium.extinction=0.4",
                    "--set", kShutter, "--print-scene", "--quiet"});
  EXPECT_EQ(printed.exit, 0) << printed.err;
  EXPECT_NE(printed.out.find("shutter = [-0.5, 0.5]"), std::string::npos) << printed.out;
  std::ofstream(folder_ / "s.toml") << printed.out;
  EXPECT_EQ(render(vdb_, "a.png", {"--set", kShutter}).exit, 0);
  EXPECT_EQ(run_tool(PVOL_RENDER, {folder_ / "s.toml", "-o", folder_ / "b.png", "--quiet"}).exit,
            0);
  EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "b.png"));
}

TEST_F(MotionTool, WhatCannotMoveSaysSo) {
  const RunResult still = render(folder_ / "plain.vdb", "a.png", {"--set", kShutter});
  EXPECT_EQ(still.exit, 0);
  EXPECT_TRUE(says(still.err, "motion.no_velocities_v_vel_velocity"));
  const auto refused = [&](std::vector<std::string> sets, const std::string& cloud) {
    std::vector<std::string> more{"--set", kShutter};
    for (std::string& s : sets) more.insert(more.end(), {"--set", std::move(s)});
    const RunResult r = render(cloud, "a.png", more);
    EXPECT_NE(r.exit, 0);
    return r.err;
  };
  EXPECT_TRUE(says(refused({"medium.motion.field=wind"}, vdb_), "motion.no_grid_vectors_called"));
  EXPECT_TRUE(says(refused({"medium.motion.scale=1"}, folder_ / "plain.vdb"),
                   "motion.no_velocities_v_vel"));
  const std::string pvol = folder_ / "a.pvol";
  const RunResult fitted = run_tool(PVOL_FIT, {vdb_, "-o", pvol});
  EXPECT_EQ(fitted.exit, 0) << fitted.err;
  EXPECT_TRUE(says(fitted.err, "motion.velocities_vel_left"));
  const RunResult lacks = render(pvol, "a.png", {"--set", kShutter});
  EXPECT_TRUE(says(lacks.err, "motion.no_velocities_v"));
  EXPECT_TRUE(says(refused({"medium.motion.field=vel"}, pvol), "motion.no_velocity_called"));
  const RunResult given =
      render(pvol, "b.png", {"--set", kShutter, "--set", "medium.motion.file=" + vdb_});
  EXPECT_EQ(given.exit, 0) << given.err;
}

TEST_F(MotionTool, VelocitiesOfAPvolFileAreThoseOfTheSource) {
  ASSERT_EQ(render(vdb_, "a.png", {"--set", kShutter}).exit, 0);
  for (const char* fields : {"all", "vel"}) {
    const std::string pvol = folder_ / "kept.pvol";
    const RunResult fitted = run_tool(PVOL_FIT, {vdb_, "-o", pvol, "--fields", fields});
    ASSERT_EQ(fitted.exit, 0) << fitted.err;
    EXPECT_EQ(times_said(fitted.err, "motion.velocities_vel_left"), 0);
    const RunResult r = render(pvol, "b.png", {"--set", kShutter});
    EXPECT_TRUE(says(r.err, "motion.moves_with_kept_grid"));
    EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "b.png")) << fields;
    const RunResult back = run_tool(PVOL_CONVERT, {pvol, folder_ / "back.vdb"});
    ASSERT_EQ(back.exit, 0) << back.err;
    EXPECT_EQ(render(folder_ / "back.vdb", "c.png", {"--set", kShutter}).exit, 0);
    EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "c.png")) << fields;
  }
}

/// A recipe with a flow moves by itself, from its file, and as a .vdb; to the byte where its
/// density is the same.
TEST_F(MotionTool, RecipesMoveByTheirFlow) {
  std::ofstream(folder_ / "ball.toml") << "[recipe]\nresolution = 24\nedge = 0.3\n"
                                          "[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\n"
                                          "radii = 1\n"
                                          "[flow]\nvelocity = [12, 0, 0]\nspin = [0, 400, 0]\n"
                                          "turbulence = 2\ncell = 0.7\n";
  const std::vector<std::string> moves{"--set", kShutter, "--set", "medium.extinction=3"};
  const RunResult r = render(folder_ / "ball.toml", "a.png", moves);
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "motion.moves_grid_flow"));
  ASSERT_EQ(render(folder_ / "ball.toml", "still.png", {"--set", "medium.extinction=3"}).exit, 0);
  EXPECT_NE(read_text(folder_ / "a.png"), read_text(folder_ / "still.png"));
  const std::string pvol = folder_ / "ball.pvol", vdb = folder_ / "ball.vdb";
  ASSERT_EQ(run_tool(PVOL_FIT, {folder_ / "ball.toml", "-o", pvol}).exit, 0);
  ASSERT_EQ(run_tool(PVOL_CONVERT, {folder_ / "ball.toml", vdb}).exit, 0);
  for (const std::string& file : {pvol, vdb}) {
    const RunResult moved = render(file, "b.png", moves);
    EXPECT_TRUE(says(moved.err, "motion.moves_grid_v"));
    EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "b.png")) << file;
  }
  std::ofstream(folder_ / "bad.toml") << "[recipe]\n[[form]]\nshape = \"ellipsoid\"\n"
                                         "centre = [0, 0, 0]\nradii = 1\n[flow]\nturbulence = 1\n";
  const RunResult bad = render(folder_ / "bad.toml", "a.png", moves);
  EXPECT_NE(bad.exit, 0);
  EXPECT_NE(bad.err.find("cell"), std::string::npos) << bad.err;
}

}  // namespace motion_tool_test
}  // namespace pvol
