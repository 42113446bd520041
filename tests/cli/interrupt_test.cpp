// Ctrl-C and its like, in whatever a tool is doing.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <regex>
#include <thread>

#include "support/run_tool.h"

namespace pvol {
namespace interrupt_test {

using testing::read_text;
using testing::run_on_terminal;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

using WhileRunning = std::function<void(int pid, const std::string& err)>;

/// Sends the signals, in their order by number, once stderr holds the text.
WhileRunning at_text(const std::string& text, const std::vector<int>& signals) {
  return [text, signals, sent = false](int pid, const std::string& err) mutable {
    if (sent || err.find(text) == err.npos) return;
    sent = true;
    kill(pid, SIGSTOP);
    for (const int s : signals) kill(pid, s);
    kill(pid, SIGCONT);
  };
}

/// Whether a signal to a process waits for one of its threads to take it.
bool is_pending(int pid, int signal) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("ShdPnd:")) continue;
    return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
  }
  return false;
}

struct Interrupt : ::testing::Test {
  ScratchFolder folder, out;
  std::string ball = folder / "ball.toml", fifo = folder / "cloud.toml", picture = out / "a.exr";
  int writer = -1;  // of the FIFO

  Interrupt() {
    std::ofstream(ball) << "[recipe]\nresolution = 40\nedge = 0.05\n[[form]]\n"
                           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
    mkfifo(fifo.c_str(), 0600);
  }
  ~Interrupt() override {
    if (writer >= 0) close(writer);
  }

  /// Sends the signals once the tool waits for what nobody writes to the FIFO.
  [[nodiscard]] WhileRunning when_it_reads(const std::vector<int>& signals) {
    if (writer >= 0) close(writer);
    writer = -1;
    return [this, signals](int pid, const std::string&) {
      if (writer >= 0) return;
      writer = open(fifo.c_str(), O_WRONLY | O_NONBLOCK);
      for (const int s : signals) {
        if (writer >= 0) kill(pid, s);
      }
    };
  }

  /// A command for each tool that reads a file and writes another.
  [[nodiscard]] std::vector<Words> commands(const std::string& input) const {
    return {{PVOL_FIT, input, "-o", out / "a.pvol"},
            {PVOL_RENDER, input, "-o", picture},
            {PVOL_STATS, "bounds", input},
            {PVOL_CONVERT, input, out / "a.vdb"}};
  }
  /// A picture of the ball, which lasts longer than anybody waits.
  [[nodiscard]] Words long_picture() const {
    return {ball, "-o", picture, "--size", "12x8", "--spp", "4000000000"};
  }
};

Words arguments_of(const Words& command) { return {command.begin() + 1, command.end()}; }

TEST_F(Interrupt, EndsLoadingByTheSignalItself) {
  for (const Words& command : commands(fifo)) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      const RunResult r = run_tool(command[0], arguments_of(command), when_it_reads({signal}));
      EXPECT_EQ(r.signal, signal) << command[0] << ": " << r.err;
      EXPECT_TRUE(r.err.ends_with(": interrupted while reading cloud.toml\n")) << r.err;
      EXPECT_TRUE(out.empty());
    }
  }
}

TEST_F(Interrupt, CoversTheLineOnTheTerminal) {
  const RunResult r =
      run_on_terminal(PVOL_FIT, {fifo, "-o", out / "a.pvol"}, when_it_reads({SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  const std::string line = "reading cloud.toml", blank(line.size(), ' ');
  EXPECT_EQ(r.err, '\r' + line + '\r' + blank + "\rpvol-fit: interrupted while " + line + "\r\n");
}

TEST_F(Interrupt, AWishForACheckpointEndsNothing) {
  for (const Words& command : commands(fifo)) {
    const RunResult r =
        run_tool(command[0], arguments_of(command), when_it_reads({SIGUSR1, SIGTERM}));
    EXPECT_EQ(r.signal, SIGTERM) << command[0] << ": " << r.err;
  }
}

TEST_F(Interrupt, WhatWasIgnoredStaysSo) {
  for (const Words& command : commands(fifo)) {
    Words words{"-c", "trap '' HUP INT USR1; exec \"$@\"", "sh"};
    words.insert(words.end(), command.begin(), command.end());
    const RunResult r =
        run_tool("/bin/sh", words, when_it_reads({SIGHUP, SIGINT, SIGUSR1, SIGTERM}));
    EXPECT_EQ(r.signal, SIGTERM) << command[0] << ": " << r.err;
  }
}

/// Null collisions in hardly any fog around a small dense core, of a hundred clouds at once: paths
/// for the forecast take minutes.
TEST_F(Interrupt, EndsPlanning) {
  const auto ball_of = [](double density, const char* centre, double radius) {
    return fmt::format(
        "[[solid]]\ndensity = {}\n[[solid.form]]\nshape = \"ellipsoid\"\ncentre = {}\n"
        "radii = {}\n",
        density, centre, radius);
  };
  std::ofstream(folder / "core.toml")
      << "[recipe]\nresolution = 64\n"
      << ball_of(1e-3, "[0, 0, 0]", 1) << ball_of(1, "[0.7, 0, 0]", 0.08);
  std::ofstream scene(folder / "scene.toml");
  scene << "[medium]\nextinction = 2.9e5\nalbedo = 1\n[render]\ndepth = 0\n"
        << "[[sun]]\ndirection = [0, 1, 0]\nirradiance = 1\n[[volume]]\nfile = \"core.toml\"\n";
  for (int i = 0; i < 100; ++i) {
    scene << "[[volume.instance]]\ntranslate = [" << 0.001 * i << ", 0, 0]\n";
  }
  scene.close();
  const RunResult r =
      run_on_terminal(PVOL_RENDER, {folder / "scene.toml", "-o", picture, "--force"},
                      at_text("planning", {SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_NE(r.err.find("interrupted while planning"), r.err.npos) << r.err;
  EXPECT_TRUE(out.empty());
}

TEST_F(Interrupt, EndsTheFitOfAShell) {
  const RunResult r = run_on_terminal(
      PVOL_FIT, {ball, "-o", out / "a.pvol", "--shells", "64", "--shell-effort", "10"},
      at_text("fitting the shell", {SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_NE(r.err.find("interrupted while fitting the shell"), r.err.npos) << r.err;
  EXPECT_TRUE(out.empty());
}

TEST_F(Interrupt, TheFirstOneSavesAPictureAndTheSecondEndsTheTool) {
  const RunResult once = run_tool(PVOL_RENDER, long_picture(), at_text("noise ", {SIGHUP}));
  EXPECT_EQ(once.exit, 1) << once.err;
  EXPECT_NE(once.err.find("; the picture so far is saved"), once.err.npos) << once.err;
  EXPECT_FALSE(read_text(picture).empty());
  // What is interrupted on the way into a .png is filtered to the end. A second signal counts a
  // second after the first, during which the tool stands still here: however fast it filters.
  const std::string png = out / "b.png";
  std::ofstream(png) << "old";
  bool sent = false;
  const auto twice_apart = [&](int pid, const std::string& err) {
    if (sent || err.find("noise ") == err.npos) return;
    sent = true;
    kill(pid, SIGINT);
    while (is_pending(pid, SIGINT)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    kill(pid, SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(1200));
    kill(pid, SIGTERM), kill(pid, SIGCONT);
  };
  const RunResult twice = run_tool(
      PVOL_RENDER,
      {ball, "-o", png, "--size", "640x480", "--spp", "1000000", "--denoise", "--threads", "1"},
      twice_apart);
  EXPECT_EQ(twice.signal, SIGTERM) << twice.err;
  EXPECT_NE(twice.err.find("interrupted again"), twice.err.npos) << twice.err;
  EXPECT_EQ(read_text(png), "old");
  for (const auto& entry : std::filesystem::directory_iterator(out.path())) {
    EXPECT_EQ(entry.path().string().find(".tmp-"), std::string::npos) << entry.path();
  }
}

TEST_F(Interrupt, InTheFilterSavesThePictureAsItIs) {
  const RunResult r = run_on_terminal(
      PVOL_RENDER, {ball, "-o", picture, "--size", "800x600", "--spp", "2", "--denoise"},
      at_text("\rfiltering", {SIGINT}));
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_NE(r.err.find("interrupted; the picture is saved unfiltered"), r.err.npos) << r.err;
  EXPECT_TRUE(std::filesystem::exists(picture));
}

TEST_F(Interrupt, BetweenFramesKeepsThoseThatAreDone) {
  std::filesystem::copy_file(ball, folder / "smoke.0001.toml");
  std::filesystem::rename(fifo, folder / "smoke.0002.toml");
  fifo = folder / "smoke.0002.toml";
  const RunResult r =
      run_tool(PVOL_FIT, {folder / "smoke.####.toml", "-o", out / "a.####.pvol", "--frames", "1-2"},
               when_it_reads({SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_NE(r.err.find("interrupted while reading smoke.0002.toml\n"), r.err.npos) << r.err;
  EXPECT_TRUE(r.err.ends_with("pvol-fit: 1 of 2 frames are done\n")) << r.err;
  EXPECT_TRUE(std::filesystem::exists(out / "a.0001.pvol"));
}

TEST_F(Interrupt, StudiesReportWhatTheyMeasured) {
  Words words{"trade", ball, "--size", "16x16", "--budget", "3600"};
  const RunResult early = run_tool(PVOL_STATS, words, at_text("the reference; ", {SIGINT}));
  EXPECT_EQ(early.signal, SIGINT) << early.err;
  EXPECT_EQ(early.out, "");
  words.back() = "40";
  bool sent = false;
  const RunResult late = run_tool(PVOL_STATS, words, [&](int pid, const std::string& err) {
    // There is a round to report by then, also where one took too long and does not count.
    const bool later = std::regex_search(err, std::regex("round [3-9] of"));
    if (!sent && later) sent = kill(pid, SIGINT) == 0;
  });
  EXPECT_EQ(late.exit, 1) << late.err;
  EXPECT_NE(late.err.find("the report contains the measurements so far"), late.err.npos)
      << late.err;
  EXPECT_NE(late.out, "");
}

}  // namespace interrupt_test
}  // namespace pvol
