// Tools that are kept below one folder: what lies outside is neither read nor written, by whatever
// name.
#include <gtest/gtest.h>
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace root_test {

namespace fs = std::filesystem;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;
using testing::operator+;

/// The folder `in` of a service, with a cloud; what scenes may not have lies beside it in `out`.
class Root : public ::testing::Test {
 protected:
  void SetUp() override {
    if (syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) < 1) {
      GTEST_SKIP() << "the kernel has no Landlock";
    }
    fs::create_directory(folder_.path() / "in");
    fs::create_directory(folder_.path() / "out");
    for (const char* place : {"in", "out"}) {
      write(std::string(place) + "/ball.toml",
            "[recipe]\nresolution = 16\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii "
            "= [1, 1, 1]\n");
    }
    write("out/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("out/phase.txt", "0 2\n90 1\n180 1\n");
  }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }

  RunResult run(const std::string& tool, const Words& more) {
    // A sanitized tool looks for leaks in /proc, which is not below the folder either.
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
    const RunResult result = run_tool(tool, more + Words{"--root", folder_ / "in"});
    unsetenv("ASAN_OPTIONS");
    return result;
  }

  /// Renders a scene of the service's folder into `picture`.
  static Words render(const std::string& scene, const std::string& picture) {
    return {scene, "-o", picture, "--size", "8x8", "--spp", "2", "--quiet", "--no-png"};
  }

  /// A scene that renders, and does not once its tool is kept below the folder.
  void refuse(const std::string& scene) {
    const Words line = render(folder_ / scene, folder_ / "in/a.exr");
    const RunResult free = run_tool(PVOL_RENDER, line);
    ASSERT_EQ(free.exit, 0) << free.err;
    fs::remove(folder_ / "in/a.exr");
    const RunResult kept = run(PVOL_RENDER, line);
    EXPECT_EQ(kept.exit, 1) << scene;
    EXPECT_TRUE(says(kept.err, "tools.only_below_root"));
    EXPECT_FALSE(fs::exists(folder_ / "in/a.exr")) << scene;
  }

  ScratchFolder folder_;
};

/// Their module is loaded when the tool is kept below the folder already.
TEST_F(Root, OpenVdbFilesAreReadAndWritten) {
  ASSERT_EQ(run(PVOL_CONVERT, {folder_ / "in/ball.toml", folder_ / "in/ball.vdb"}).exit, 0);
  const RunResult picture = run(PVOL_RENDER, render(folder_ / "in/ball.vdb", folder_ / "in/a.exr"));
  EXPECT_EQ(picture.exit, 0) << picture.err;
  EXPECT_TRUE(fs::exists(folder_ / "in/a.exr"));
}

TEST_F(Root, ChangesNothingForFilesBelowIt) {
  const RunResult fit =
      run(PVOL_FIT, {folder_ / "in/ball.toml", "-o", folder_ / "in/ball.pvol", "--quiet"});
  ASSERT_EQ(fit.exit, 0) << fit.err;
  const Words line = render(folder_ / "in/ball.pvol", folder_ / "in/a.exr");
  const RunResult kept = run(PVOL_RENDER, line);
  ASSERT_EQ(kept.exit, 0) << kept.err;
  const std::string picture = read_text(folder_ / "in/a.exr");
  ASSERT_EQ(run_tool(PVOL_RENDER, line).exit, 0);
  EXPECT_EQ(read_text(folder_ / "in/a.exr"), picture);
}

TEST_F(Root, RefusesWhatScenesNameOutside) {
  write("in/cloud.toml", "[volume]\nfile = \"../out/ball.toml\"\n");
  write("in/absolute.toml", "[volume]\nfile = '" + folder_ / "out/ball.toml" + "'\n");
  const std::string cloud = "[volume]\nfile = \"ball.toml\"\n";
  write("in/mesh.toml", cloud + "[[mesh]]\nfile = \"../out/tri.obj\"\n");
  write("in/phase.toml", cloud + "[medium]\nphase_table = \"../out/phase.txt\"\n");
  fs::create_symlink("../out/ball.toml", folder_.path() / "in/link.toml");
  write("in/linked.toml", "[volume]\nfile = \"link.toml\"\n");
  for (const char* scene : {"in/cloud.toml", "in/absolute.toml", "in/mesh.toml", "in/phase.toml",
                            "in/link.toml", "in/linked.toml", "out/ball.toml"}) {
    refuse(scene);
  }
}

TEST_F(Root, RefusesWhatFilesReferTo) {
  const RunResult vdb =
      run_tool(PVOL_CONVERT, {folder_ / "out/ball.toml", folder_ / "out/ball.vdb"});
  ASSERT_EQ(vdb.exit, 0) << vdb.err;
  const RunResult fit = run_tool(PVOL_FIT, {folder_ / "out/ball.vdb", "--density", "reference",
                                            "-o", folder_ / "in/reference.pvol", "--quiet"});
  ASSERT_EQ(fit.exit, 0) << fit.err;
  refuse("in/reference.pvol");
}

TEST_F(Root, RefusesOutputsElsewhereBeforeTheWork) {
  fs::create_directory_symlink("../out", folder_.path() / "in/away");
  for (const char* picture : {"out/a.exr", "in/../out/a.exr", "in/away/a.exr"}) {
    const RunResult r = run(PVOL_RENDER, render(folder_ / "in/ball.toml", folder_ / picture));
    EXPECT_EQ(r.exit, 1) << picture;
    EXPECT_TRUE(says(r.err, "tools.outside_root", {folder_ / picture}));
    EXPECT_FALSE(fs::exists(folder_ / "out/a.exr")) << picture;
  }
  const RunResult fit = run(PVOL_FIT, {folder_ / "in/ball.toml", "-o", folder_ / "out/a.pvol"});
  EXPECT_EQ(fit.exit, 1);
  EXPECT_TRUE(says(fit.err, "tools.only_below_root"));
  EXPECT_FALSE(fs::exists(folder_ / "out/a.pvol"));
}

TEST_F(Root, MustBeThere) {
  const RunResult r = run_tool(PVOL_RENDER, render(folder_ / "in/ball.toml", folder_ / "in/a.exr") +
                                                Words{"--root", folder_ / "none"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "tools.root_missing"));
}

}  // namespace root_test
}  // namespace pvol
