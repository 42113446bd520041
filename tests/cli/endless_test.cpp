// Pictures that would hardly end: refused, printed to be put right, or stopped by a signal.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace endless_test {

using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

struct Endless : ::testing::Test {
  ScratchFolder folder;
  std::string ball = folder / "ball.toml", picture = folder / "a.exr";

  Endless() {
    std::ofstream(ball) << "[recipe]\nresolution = 40\nedge = 0.05\n[[form]]\n"
                           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  }

  /// A picture of the ball under these settings.
  [[nodiscard]] std::vector<std::string> picture_of(const std::vector<std::string>& sets) const {
    std::vector<std::string> words{ball, "-o", picture, "--size", "12x8", "--spp", "4"};
    for (const std::string& s : sets) words.insert(words.end(), {"--set", s});
    return words;
  }
};

/// Scatters for hours, and meets null collisions for hours: a wrong unit, and a wrong depth as
/// well; flights of colours are others.
const std::vector<std::string> kLongPaths{"medium.extinction=1e8", "medium.albedo=1"};
const std::vector<std::string> kLongFlights{"medium.extinction=1e11", "render.depth=0"};
const std::vector<std::string> kLongColours{"medium.extinction=1e11", "render.depth=0",
                                            "medium.extinction_color=[1, 0.5, 0]"};

TEST_F(Endless, IsRefusedUnlessLimited) {
  std::vector<std::string> words = picture_of({"medium.extinction=5e6", "medium.albedo=1"});
  const RunResult refused = run_tool(PVOL_RENDER, words);
  EXPECT_EQ(refused.exit, 1);
  EXPECT_NE(refused.err.find("--max-bounces"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(picture));
  words.insert(words.end(), {"--max-bounces", "3"});
  EXPECT_EQ(run_tool(PVOL_RENDER, words).exit, 0);
}

TEST_F(Endless, IsToldWhichExtinctionWouldMakeSense) {
  for (const auto& sets : {kLongPaths, kLongFlights}) {
    const RunResult r = run_tool(PVOL_RENDER, picture_of(sets));
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(says(r.err, "plan.about_expected_most_medium"));
  }
}

TEST_F(Endless, IsPrintedToBePutRight) {
  for (const auto& sets : {kLongPaths, kLongFlights}) {
    std::vector<std::string> words = picture_of(sets);
    words.emplace_back("--print-scene");
    const RunResult r = run_tool(PVOL_RENDER, words);
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_NE(r.out.find("extinction = 1e+"), std::string::npos) << r.out;
  }
}

TEST_F(Endless, IsEndedBySignalsWithinPathsAndFlights) {
  for (const auto& sets : {kLongPaths, kLongFlights, kLongColours}) {
    for (const int signal : {SIGINT, SIGTERM}) {
      std::vector<std::string> words = picture_of(sets);
      words.emplace_back("--force");
      bool sent = false;
      const RunResult r = run_tool(PVOL_RENDER, words, [&](int pid, const std::string& err) {
        // The sign of life of the first second.
        if (sent || err.find("rendering   0 %") == std::string::npos) return;
        sent = true;
        kill(pid, signal);
      });
      EXPECT_TRUE(sent) << r.err;
      EXPECT_EQ(r.exit, 1) << r.err;
      EXPECT_NE(r.err.find("interrupted "), std::string::npos) << r.err;
    }
  }
}

}  // namespace endless_test
}  // namespace pvol
