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

#include "support/messages.h"
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

/// Sends the signals, in their order by number, once stderr has the message of this key.
WhileRunning at_message(const std::string& key, const std::vector<int>& signals) {
  return [key, signals, sent = false](int pid, const std::string& err) mutable {
    if (sent || times_said(err, key) == 0) return;
    sent = true;
    kill(pid, SIGSTOP);
    for (const int s : signals) kill(pid, s);
    kill(pid, SIGCONT);
  };
}

/// What was said last.
std::string last_line(const std::string& err) {
  return err.empty() ? err : err.substr(err.rfind('\n', err.size() - 2) + 1);
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
  /// A picture of hardly any fog without end, which soon knows its noise, and whose filter takes a
  /// while on one thread.
  [[nodiscard]] Words long_filter(const std::string& file) const {
    return {ball,        "-o",      file,        "--size", "320x240",
            "--spp",     "1000000", "--denoise", "--set",  "medium.extinction=0.01",
            "--threads", "1"};
  }
};

/// Sends two signals while the tool renders, once there is enough of the picture to be filtered. A
/// second one counts a second after the first, during which the tool stands still here, however
/// fast it is.
WhileRunning twice_apart(int first, int second) {
  return [first, second, sent = false](int pid, const std::string& err) mutable {
    if (sent || times_said(err, "interrupt.noise_known") == 0) return;
    sent = true;
    kill(pid, first);
    while (is_pending(pid, first)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    kill(pid, SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(1200));
    kill(pid, second), kill(pid, SIGCONT);
  };
}

Words arguments_of(const Words& command) { return {command.begin() + 1, command.end()}; }

TEST_F(Interrupt, EndsLoadingByTheSignalItself) {
  for (const Words& command : commands(fifo)) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      const RunResult r = run_tool(command[0], arguments_of(command), when_it_reads({signal}));
      EXPECT_EQ(r.signal, signal) << command[0] << ": " << r.err;
      EXPECT_TRUE(says(last_line(r.err), "interrupt.interrupted_reading_cloud"));
      EXPECT_TRUE(out.empty());
    }
  }
}

/// A cloud whose file is cut off under a render ends it with a message, not by SIGBUS.
TEST_F(Interrupt, EndsWhereAMappedFileBecomesShorter) {
  const std::string cloud = folder / "ball.pvol";
  ASSERT_EQ(run_tool(PVOL_FIT, {ball, "-o", cloud, "--compression", "none"}).exit, 0);
  Words words = long_picture();
  words[0] = cloud;
  const RunResult r =
      run_on_terminal(PVOL_RENDER, words, [&, cut = false](int, const std::string& err) mutable {
        if (cut || times_said(err, "interrupt.during_rendering") == 0) return;
        cut = true;
        std::filesystem::resize_file(cloud, 0);
      });
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(says(r.err, "interrupt.file_became_shorter")) << r.err;
  EXPECT_NE(r.err.find(cloud), std::string::npos) << r.err;
  EXPECT_TRUE(out.empty());
}

/// One that is written over keeps its length, and nothing else would tell.
TEST_F(Interrupt, SavesNothingWhereAMappedFileIsWrittenOver) {
  const std::string cloud = folder / "ball.pvol", other = folder / "other.pvol";
  ASSERT_EQ(run_tool(PVOL_FIT, {ball, "-o", cloud, "--compression", "none"}).exit, 0);
  std::filesystem::copy(cloud, other);
  Words words = long_picture();
  words[0] = cloud;
  const auto render_while = [&](const auto& act) {
    return run_tool(PVOL_RENDER, words, [&, done = false](int pid, const std::string& err) mutable {
      if (done || err.find("\nrendering ") == err.npos) return;
      done = true;
      act();
      kill(pid, SIGINT);
    });
  };
  const RunResult over = render_while([&] {
    std::fstream(cloud, std::ios::in | std::ios::out | std::ios::binary)
        << testing::read_text(other);
  });
  EXPECT_EQ(over.exit, 1) << over.err;
  EXPECT_TRUE(says(over.err, "interrupt.file_written_over")) << over.err;
  EXPECT_TRUE(out.empty());
  // Where another takes its name, the file that is mapped stays as it is.
  const RunResult renamed = render_while([&] { std::filesystem::rename(other, cloud); });
  EXPECT_FALSE(says(renamed.err, "interrupt.file_written_over")) << renamed.err;
  EXPECT_TRUE(std::filesystem::exists(picture));
}

TEST_F(Interrupt, CoversTheLineOnTheTerminal) {
  const RunResult r =
      run_on_terminal(PVOL_FIT, {fifo, "-o", out / "a.pvol"}, when_it_reads({SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_TRUE(says(r.err, "interrupt.reading_cloud_toml"));
  EXPECT_TRUE(says(r.err, "interrupt.interrupted_reading_cloud_toml"));
  // A line, as many blanks over it, and the message.
  EXPECT_TRUE(std::regex_match(r.err, std::regex("\r(.+)\r( +)\r[^\r]+\r\n"))) << r.err;
  const std::size_t size = r.err.find('\r', 1);
  EXPECT_EQ(r.err.find_first_not_of(' ', size + 1), 2 * size) << r.err;
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
                      at_message("interrupt.during_planning", {SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_TRUE(says(r.err, "interrupt.interrupted_planning"));
  EXPECT_TRUE(out.empty());
}

TEST_F(Interrupt, EndsTheFitOfAShell) {
  const RunResult r = run_on_terminal(
      PVOL_FIT, {ball, "-o", out / "a.pvol", "--shells", "64", "--shell-effort", "10"},
      at_message("interrupt.during_shell", {SIGINT}));
  EXPECT_EQ(r.signal, SIGINT) << r.err;
  EXPECT_TRUE(says(r.err, "interrupt.interrupted_fitting_shell"));
  EXPECT_TRUE(out.empty());
}

TEST_F(Interrupt, TheFirstOneSavesAPictureAndTheSecondEndsTheTool) {
  const RunResult once =
      run_tool(PVOL_RENDER, long_picture(), at_message("interrupt.during_rendering", {SIGHUP}));
  EXPECT_EQ(once.exit, 1) << once.err;
  EXPECT_TRUE(says(once.err, "interrupt.interrupted_after_samples"));
  EXPECT_FALSE(read_text(picture).empty());
  // What is interrupted on the way into a .png is filtered to the end.
  const std::string png = out / "b.png";
  std::ofstream(png) << "old";
  const RunResult twice = run_tool(PVOL_RENDER, long_filter(png), twice_apart(SIGINT, SIGTERM));
  EXPECT_EQ(twice.signal, SIGTERM) << twice.err;
  EXPECT_TRUE(says(twice.err, "interrupt.interrupted_again"));
  EXPECT_EQ(read_text(png), "old");
  for (const auto& entry : std::filesystem::directory_iterator(out.path())) {
    EXPECT_EQ(entry.path().string().find(".tmp-"), std::string::npos) << entry.path();
  }
}

TEST_F(Interrupt, SchedulersAndLimitsSaveAPicture) {
  for (const int signal : {SIGUSR2, SIGXCPU}) {
    std::filesystem::remove(picture);
    const RunResult r =
        run_tool(PVOL_RENDER, long_picture(), at_message("interrupt.during_rendering", {signal}));
    EXPECT_EQ(r.exit, 1) << r.err;
    EXPECT_TRUE(says(r.err, "interrupt.interrupted_after_samples"));
    EXPECT_FALSE(read_text(picture).empty());
  }
}

TEST_F(Interrupt, TheLimitOfCpuTimeIsOneWishHoweverOftenItIsTold) {
  const std::string png = out / "b.png";
  const RunResult r = run_tool(PVOL_RENDER, long_filter(png), twice_apart(SIGXCPU, SIGXCPU));
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_FALSE(read_text(png).empty());
}

TEST_F(Interrupt, AReaderOfTheLogThatIsGoneEndsNothing) {
  const std::string status = out / "status";
  const Words words{"-c",    "( \"$@\"; echo $? > '" + status + "' ) 2>&1 | head -c 1",
                    "sh",    PVOL_RENDER,
                    ball,    "-o",
                    picture, "--size",
                    "64x64", "--spp",
                    "64"};
  (void)run_tool("/bin/sh", words);
  EXPECT_EQ(read_text(status), "0\n");
  EXPECT_FALSE(read_text(picture).empty());
}

TEST_F(Interrupt, AReaderOfTheOutputThatIsGoneEndsTheToolQuietly) {
  const std::string status = out / "status";
  // Lines until one cannot be written: then the reader is gone.
  const std::string wait = "trap '' PIPE; while echo; do :; done 2>/dev/null; trap - PIPE; ";
  const Words words{"-c",     "( " + wait + "\"$@\"; echo $? > '" + status + "' ) | true",
                    "sh",     PVOL_RENDER,
                    ball,     "--print-scene",
                    "--quiet"};
  const RunResult r = run_tool("/bin/sh", words);
  EXPECT_EQ(read_text(status), std::to_string(128 + SIGPIPE) + "\n");
  EXPECT_EQ(r.err, "");
}

TEST_F(Interrupt, InTheFilterSavesThePictureAsItIs) {
  const RunResult r = run_on_terminal(PVOL_RENDER,
                                      {ball, "-o", picture, "--size", "800x600", "--spp", "2",
                                       "--set", "medium.extinction=1", "--denoise"},
                                      at_message("interrupt.during_filter", {SIGINT}));
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(says(r.err, "interrupt.picture_unfiltered"));
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
  EXPECT_TRUE(says(r.err, "interrupt.interrupted_reading_smoke"));
  EXPECT_TRUE(says(last_line(r.err), "interrupt.frames_done"));
  EXPECT_TRUE(std::filesystem::exists(out / "a.0001.pvol"));
}

TEST_F(Interrupt, StudiesReportWhatTheyMeasured) {
  Words words{"trade", ball, "--size", "16x16", "--threads", "1", "--budget", "3600"};
  const RunResult early =
      run_tool(PVOL_STATS, words, at_message("interrupt.during_reference", {SIGINT}));
  EXPECT_EQ(early.signal, SIGINT) << early.err;
  EXPECT_EQ(early.out, "");
  RunResult late;
  // A budget may be too short for a machine that other work slows down in the middle of it.
  for (const char* const budget : {"8", "40", "160"}) {
    words.back() = budget;
    bool sent = false;
    late = run_tool(PVOL_STATS, words, [&](int pid, const std::string& err) {
      // There is a round to report by then, also where one took too long and does not count.
      const bool later = std::regex_search(err, std::regex("round [3-9] of"));
      if (!sent && later) sent = kill(pid, SIGINT) == 0;
    });
    if (!late.out.empty()) break;
  }
  EXPECT_EQ(late.exit, 1) << late.err;
  EXPECT_TRUE(says(late.err, "interrupt.interrupted_report_contains"));
  EXPECT_NE(late.out, "");
}

}  // namespace interrupt_test
}  // namespace pvol
