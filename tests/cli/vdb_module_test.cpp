// OpenVDB is loaded where a .vdb file asks for it, and missed nowhere else.
#include <gtest/gtest.h>

#include <fstream>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace vdb_module_test {

using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

/// A copy of pvol-render by itself, so deep in a folder that nothing beyond that is looked at.
class VdbModule : public ::testing::Test {
 protected:
  VdbModule() {
    std::filesystem::create_directories(folder_ / "a/b/bin");
    std::filesystem::copy_file(PVOL_RENDER, tool_);
    std::ofstream(folder_ / "ball.toml")
        << "[recipe]\nresolution = 16\n[[form]]\n"
           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
    EXPECT_EQ(run_tool(PVOL_CONVERT, {folder_ / "ball.toml", folder_ / "ball.vdb"}).exit, 0);
  }

  [[nodiscard]] RunResult render(const std::string& cloud) const {
    return run_tool(tool_,
                    {folder_ / cloud, "-o", folder_ / "a.exr", "--size", "6x4", "--spp", "1"});
  }
  /// Renders of a .vdb file fail with a message, and leave nothing.
  void expect_refusal(const std::string& key) const {
    const RunResult r = render("ball.vdb");
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(says(r.err, key)) << r.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
  }

  ScratchFolder folder_;
  std::string tool_ = folder_ / "a/b/bin/pvol-render",
              module_ = folder_ / "a/b/lib/pvol/pvol_vdb.so";
};

TEST_F(VdbModule, IsLoadedByVdbFilesAlone) {
  const RunResult libraries = run_tool("/usr/bin/env", {"LD_TRACE_LOADED_OBJECTS=1", PVOL_RENDER});
  EXPECT_NE(libraries.out.find("libtbb"), std::string::npos) << libraries.out;
  EXPECT_EQ(libraries.out.find("openvdb"), std::string::npos) << libraries.out;
  expect_refusal("tools.no_module");
  EXPECT_EQ(render("ball.toml").exit, 0);
}

TEST_F(VdbModule, IsNamedWhereItCannotBeLoaded) {
  std::filesystem::create_directories(folder_ / "a/b/lib/pvol");
  std::ofstream(module_) << "no library";
  expect_refusal("tools.module_not_loaded");
}

}  // namespace vdb_module_test
}  // namespace pvol
