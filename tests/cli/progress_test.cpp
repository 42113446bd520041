// What the tools show while they are at work, on a terminal and in files.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace progress_test {

using testing::run_on_terminal;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

struct Progress : ::testing::Test {
  ScratchFolder folder;
  std::string ball = folder / "ball.toml";

  Progress() {
    std::ofstream(ball) << "[recipe]\nresolution = 40\nedge = 0.05\n[[form]]\n"
                           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  }

  [[nodiscard]] std::vector<std::vector<std::string>> commands() const {
    return {{PVOL_FIT, ball, "-o", folder / "ball.pvol"},
            {PVOL_RENDER, ball, "-o", folder / "ball.exr", "--size", "8x8", "--spp", "1"},
            {PVOL_STATS, "bounds", ball},
            {PVOL_CONVERT, ball, folder / "ball.vdb", "--bounds"}};
  }
};

std::vector<std::string> arguments_of(const std::vector<std::string>& command) {
  return {command.begin() + 1, command.end()};
}

TEST_F(Progress, TerminalsShowWhatLoadsAndForgetIt) {
  for (const std::vector<std::string>& command : commands()) {
    const RunResult r = run_on_terminal(command[0], arguments_of(command));
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_TRUE(says(r.err, "progress.reading_ball_toml")) << command[0];
    EXPECT_TRUE(says(r.err, "progress.building_bounds")) << command[0];
    EXPECT_LT(r.err.find("\rreading"), r.err.find("\rbuilding")) << command[0] << ": " << r.err;
    // Each line is covered by as many blanks, and a return goes to its begin.
    const std::regex covered("\\r([a-z][^\\r]*[^\\r ]) *\\r( +)(?=\\r)");
    EXPECT_TRUE(std::regex_search(r.err, covered)) << command[0] << ": " << r.err;
    for (std::sregex_iterator at(r.err.begin(), r.err.end(), covered), end; at != end; ++at) {
      EXPECT_EQ((*at)[1].length(), (*at)[2].length()) << command[0] << ": " << r.err;
    }
  }
}

TEST_F(Progress, FilesAndQuietTerminalsAreSpared) {
  for (std::vector<std::string> command : commands()) {
    EXPECT_EQ(run_tool(command[0], arguments_of(command)).err.find("reading"), std::string::npos);
    if (command[0] == PVOL_STATS) continue;
    command.emplace_back("--quiet");
    EXPECT_EQ(run_on_terminal(command[0], arguments_of(command)).err, "") << command[0];
  }
}

TEST_F(Progress, ErrorsStandOnALineOfTheirOwn) {
  std::ofstream(folder / "bad.vdb") << "no grids";
  const RunResult r = run_on_terminal(PVOL_STATS, {"bounds", folder / "bad.vdb"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "progress.error_on_its_line"));
}

TEST_F(Progress, BarsAreDrawnOverEachOtherOnTerminals) {
  const RunResult r = run_on_terminal(PVOL_RENDER, arguments_of(commands()[1]));
  EXPECT_NE(r.err.find("\rrendering 100 % [##############################]"), std::string::npos)
      << r.err;
}

}  // namespace progress_test
}  // namespace pvol
