// What the tools show while they are at work, on a terminal and in files.
#include <gtest/gtest.h>

#include <fstream>

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
    const std::size_t reading = r.err.find("\rreading ball.toml");
    const std::size_t bounds = r.err.find("\rbuilding bounds", reading);
    ASSERT_NE(bounds, std::string::npos) << command[0] << ": " << r.err;
    // Blanks and a return to the line's begin.
    const std::string blank = '\r' + std::string(std::string("building bounds").size(), ' ') + '\r';
    EXPECT_NE(r.err.find(blank, bounds), std::string::npos) << command[0] << ": " << r.err;
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
  EXPECT_NE(r.err.find(" \rpvol-stats: error: "), std::string::npos) << r.err;
}

TEST_F(Progress, BarsAreDrawnOverEachOtherOnTerminals) {
  const RunResult r = run_on_terminal(PVOL_RENDER, arguments_of(commands()[1]));
  EXPECT_NE(r.err.find("\rrendering 100 % [##############################]"), std::string::npos)
      << r.err;
}

}  // namespace progress_test
}  // namespace pvol
