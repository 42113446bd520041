// The tools where the machine fails: full disks, folders that cannot be written, little memory,
// signals and kills at any moment, two writers of one file. What is there afterwards is whole.
#include <gtest/gtest.h>

#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include "pvol/formats/image.h"
#include "pvol/formats/pvol_file.h"
#include "support/effort.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace faults_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// A recipe whose samples take a few hundred kilobytes.
std::string write_recipe(const ScratchFolder& folder, double radius = 1) {
  const std::string file = folder / "ball.toml";
  std::ofstream(file) << "[recipe]\nresolution = 96\nedge = 0.05\n[[form]]\nshape = \"ellipsoid\"\n"
                      << "centre = [0, 0, 0]\nradii = " << radius << "\n[[displacement]]\n"
                      << "amplitude = 0.1\ncell = 0.3\n";
  return file;
}

std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& e : std::filesystem::directory_iterator(folder)) {
    names.insert(e.path().filename().string());
  }
  return names;
}

/// Runs a tool in a shell that has taken something away.
RunResult run_with(const std::string& limits, const std::string& tool,
                   std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"-c", limits + "; exec \"$0\" \"$@\"", tool});
  return run_tool("/bin/sh", arguments);
}

void expect_failure(const RunResult& r, const std::string& mentions) {
  EXPECT_EQ(r.exit, 1) << r.err << " signal " << r.signal;
  EXPECT_NE(r.err.find(": error: "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find(mentions), std::string::npos) << r.err;
}

/// The command lines that write files, with the file.
struct Writer {
  std::string tool;
  std::vector<std::string> arguments;
  std::string output;
};

std::vector<Writer> writers(const std::string& recipe, const std::filesystem::path& to) {
  const std::string pvol = to / "a.pvol", vdb = to / "a.vdb", exr = to / "a.exr",
                    png = to / "b.png", html = to / "a.html", stats = to / "a.json";
  const std::vector<std::string> small{"--size", "96x96", "--spp", "1", "--quiet"};
  const auto with_small = [&](std::vector<std::string> a) {
    a.insert(a.end(), small.begin(), small.end());
    return a;
  };
  return {{PVOL_FIT, {recipe, "-o", pvol}, pvol},
          {PVOL_CONVERT, {recipe, vdb}, vdb},
          {PVOL_RENDER, with_small({recipe, "-o", exr}), exr},
          {PVOL_RENDER, with_small({recipe, "-o", png}), png},
          {PVOL_STATS, {"bounds", recipe, "--html", html}, html}};
}

TEST(Faults, ALimitOnFilesIsAnErrorAndLeavesTheOldFile) {
  const ScratchFolder folder, out;
  for (const Writer& w : writers(write_recipe(folder), out.path())) {
    std::ofstream(w.output) << "old";
    const auto before = names_in(out.path());
    expect_failure(run_with("ulimit -f 4", w.tool, w.arguments), w.output);
    EXPECT_EQ(names_in(out.path()), before) << w.output;
    EXPECT_TRUE(read_text(w.output) == "old");
  }
}

/// A disk of 8 kB, where the test may mount one.
struct SmallDisk {
  std::string folder;
  bool mounted;

  explicit SmallDisk(const std::string& name) : folder(name) {
    std::filesystem::create_directory(folder);
    mounted = mount("pvol-test", folder.c_str(), "tmpfs", 0, "size=8k") == 0;
  }
  ~SmallDisk() { umount(folder.c_str()); }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
};

TEST(Faults, AFullDiskIsAnErrorAndLeavesTheOldFile) {
  const ScratchFolder folder;
  const std::string disk = folder / "disk";
  const SmallDisk small(disk);
  if (!small.mounted) {
    GTEST_SKIP() << "mounting a small disk takes root; ALimitOnFiles... covers the rest";
  }
  for (const Writer& w : writers(write_recipe(folder), disk)) {
    std::ofstream(w.output) << "old";
    const RunResult r = run_with("TMPDIR='" + disk + "'; export TMPDIR", w.tool, w.arguments);
    EXPECT_EQ(r.exit, 1) << r.err;
    EXPECT_NE(r.err.find(w.output), std::string::npos) << r.err;
    EXPECT_EQ(names_in(disk), std::set{std::filesystem::path(w.output).filename().string()});
    EXPECT_TRUE(read_text(w.output) == "old");
    std::filesystem::remove(w.output);
  }
  ASSERT_EQ(mount("pvol-test", disk.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "size=8k"), 0);
  for (const Writer& w : writers(write_recipe(folder), disk)) {
    expect_failure(run_tool(w.tool, w.arguments), disk);
    EXPECT_TRUE(names_in(disk).empty());
  }
}

/// The disk is full at the end of a render, that of temporary files is not.
TEST(Faults, APictureIsSavedElsewhereWhereItsDiskIsFull) {
  const ScratchFolder folder, elsewhere;
  const std::string disk = folder / "disk", recipe = write_recipe(folder);
  const SmallDisk small(disk);
  if (!small.mounted) GTEST_SKIP() << "mounting a small disk takes root";
  const std::vector<std::string> options{"--size", "96x96", "--spp", "2", "--quiet"};
  for (const char* name : {"a.exr", "a.png"}) {
    const auto arguments_for = [&](const std::string& file) {
      std::vector<std::string> all{recipe, "-o", file};
      all.insert(all.end(), options.begin(), options.end());
      return all;
    };
    ASSERT_EQ(run_tool(PVOL_RENDER, arguments_for(folder / name)).exit, 0);
    const RunResult r = run_with("TMPDIR='" + elsewhere.path().string() + "'; export TMPDIR",
                                 PVOL_RENDER, arguments_for(disk + '/' + name));
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(says(r.err, "faults.saved_elsewhere"));
    EXPECT_TRUE(names_in(disk).empty());
    bool found = false;
    for (const std::string& other : names_in(elsewhere.path())) {
      if (!other.ends_with(name)) continue;
      found = read_text(elsewhere / other) == read_text(folder / name);
    }
    EXPECT_TRUE(found) << name << ": the picture itself";
  }
}

TEST(Faults, PicturesOfOneNameAreSavedElsewhereEach) {
  const ScratchFolder folder, elsewhere;
  const std::string disk = folder / "disk", recipe = write_recipe(folder);
  const SmallDisk small(disk);
  if (!small.mounted) GTEST_SKIP() << "mounting a small disk takes root";
  for (const char* part : {"/flat", "/deep"}) std::filesystem::create_directory(disk + part);
  const RunResult r =
      run_with("TMPDIR='" + elsewhere.path().string() + "'; export TMPDIR", PVOL_RENDER,
               {recipe, "-o", disk + "/flat/a.exr", "--deep", disk + "/deep/a.exr", "--size",
                "96x96", "--spp", "2", "--quiet"});
  EXPECT_EQ(r.exit, 1);
  int pictures = 0;
  for (const std::string& name : names_in(elsewhere.path())) pictures += name.ends_with("a.exr");
  EXPECT_EQ(pictures, 2) << r.err;
}

/// Too little for the samples of the recipe, enough for the tools.
TEST(Faults, LittleMemoryIsAnErrorThatSaysSo) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve address space";
#endif
  // Each thread has a stack and a heap of its own in the address space.
  const unsigned megabytes = 260 + 20 * std::thread::hardware_concurrency();
  if (megabytes > 460) GTEST_SKIP() << "so many threads take more than the samples";
  const ScratchFolder folder;
  const std::string recipe = folder / "large.toml";
  std::ofstream(recipe) << "[recipe]\nresolution = 640\nedge = 1\n[[form]]\n"
                        << "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  for (const Writer& w : writers(recipe, folder.path())) {
    auto arguments = w.arguments;
    arguments.insert(arguments.end(), {"--memory-limit", std::to_string(megabytes) + "M"});
    const RunResult r = run_tool(w.tool, arguments);
    EXPECT_EQ(r.exit, 1) << r.err << " signal " << r.signal;
    EXPECT_TRUE(says(r.err, "tools.error_not_enough"));
    EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"large.toml"});
  }
  const RunResult r = run_tool(PVOL_FIT, {recipe, "-o", folder / "a.pvol", "--memory-limit", "1"});
  EXPECT_EQ(r.exit, 2);
  EXPECT_TRUE(says(r.err, "tools.memory_limit_size_100m"));
}

/// Whether who runs the tests has set a limit of memory, which messages then say to raise.
bool memory_is_limited() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

TEST(Faults, APictureThatDoesNotFitIsRefusedBeforeItsCloudsAreRead) {
  const ScratchFolder folder;
  const RunResult r = run_tool(PVOL_RENDER, {write_recipe(folder), "-o", folder / "a.exr", "--size",
                                             "200000x200000", "--spp", "1"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(
      r.err, memory_is_limited() ? "faults.picture_needs_limit" : "faults.picture_needs_memory"));
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"ball.toml"});
}

/// Whatever the limit, and wherever memory ends: in OpenVDB, in blosc, in a thread.
TEST(Faults, ALimitOfMemoryEndsNoToolByASignal) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve address space";
#endif
  const ScratchFolder folder, out;
  const std::string recipe = folder / "ball.toml", vdb = folder / "ball.vdb";
  std::ofstream(recipe) << "[recipe]\nresolution = 320\nedge = 0.3\n[[form]]\n"
                        << "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  ASSERT_EQ(run_tool(PVOL_CONVERT, {recipe, vdb}).exit, 0);
  int refused_by_counts = 0;
  for (int megabytes = 170; megabytes < 400; megabytes += proof::runs_all() ? 10 : 60) {
    for (const Writer& w : writers(vdb, out.path())) {
      if (w.output.ends_with(".html")) continue;  // as the others, and slower
      auto arguments = w.arguments;
      arguments.insert(arguments.end(), {"--memory-limit", std::to_string(megabytes) + "M"});
      const RunResult r = run_tool(w.tool, arguments);
      EXPECT_EQ(r.signal, 0) << w.tool << ' ' << megabytes << ": " << r.err;
      if (r.exit == 0) continue;
      EXPECT_NE(r.err.find(" memory"), std::string::npos) << megabytes << ": " << r.err;
      refused_by_counts += times_said(r.err, "faults.grid_needs_memory") > 0;
      EXPECT_FALSE(std::filesystem::exists(w.output)) << w.output;
    }
    for (const std::string& name : names_in(out.path())) std::filesystem::remove(out / name);
  }
  EXPECT_GT(refused_by_counts, 0);
}

/// Ends a tool by a signal after so many milliseconds.
RunResult end_after(int milliseconds, int signal, const Writer& w) {
  bool sent = false;
  const auto begin = std::chrono::steady_clock::now();
  return run_tool(w.tool, w.arguments, [&](int pid, const std::string&) {
    if (sent) return;
    sent = true;
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(milliseconds));
    kill(pid, signal);
  });
}

/// At many points between its start and its end; whichever phase that is, the file is the old one,
/// or a whole one, and the next run cleans up.
TEST(Faults, KilledFitsLeaveTheOldFileOrAWholeOne) {
  const ScratchFolder folder, out;
  const Writer w{PVOL_FIT, {write_recipe(folder), "-o", out / "a.pvol", "--quiet"}, out / "a.pvol"};
  ASSERT_EQ(run_tool(w.tool, w.arguments).exit, 0);
  const std::string whole = read_text(w.output);
  const std::string old = "old";
  int litter = 0;
  for (int point = 0; point < 60; point += proof::runs_all() ? 1 : 4) {
    for (const int signal : {SIGKILL, SIGTERM, SIGINT}) {
      std::ofstream(w.output, std::ios::binary | std::ios::trunc) << old;
      (void)end_after(3 * point, signal, w);
      const std::string now = read_text(w.output);
      ASSERT_TRUE(now == old || now == whole) << point << ' ' << signal << ' ' << now.size();
      litter += int(names_in(out.path()).size()) - 1;
    }
  }
  ASSERT_EQ(run_tool(w.tool, w.arguments).exit, 0);
  EXPECT_EQ(names_in(out.path()), std::set<std::string>{"a.pvol"}) << litter;
  EXPECT_EQ(read_text(w.output), whole);
}

TEST(Faults, SignalsLeaveWholePicturesOrNone) {
  const ScratchFolder folder, out;
  const Writer w{PVOL_RENDER,
                 {write_recipe(folder), "-o", out / "a.exr", "--size", "64x64", "--spp", "64",
                  "--guide", "on", "--quiet"},
                 out / "a.exr"};
  for (int point = 0; point < 30; point += proof::runs_all() ? 1 : 4) {
    for (const int signal : {SIGKILL, SIGTERM, SIGINT}) {
      (void)end_after(12 * point, signal, w);
      if (!std::filesystem::exists(w.output)) continue;
      EXPECT_EQ(formats::read_film(w.output).film.pixels.size(), 64u * 64);
      std::filesystem::remove(w.output);
    }
  }
}

TEST(Faults, TwoWritersOfOneFileBothSucceed) {
  const ScratchFolder folder, out;
  const std::string recipe = write_recipe(folder), file = out / "a.pvol";
  const std::vector<std::string> arguments{recipe, "-o", file, "--quiet"};
  for (int round = 0; round < 5; ++round) {
    RunResult other;
    std::thread thread([&] { other = run_tool(PVOL_FIT, arguments); });
    const RunResult r = run_tool(PVOL_FIT, arguments);
    thread.join();
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_EQ(other.exit, 0) << other.err;
    EXPECT_NO_THROW((void)formats::read_pvol(file));
    EXPECT_EQ(names_in(out.path()), std::set<std::string>{"a.pvol"});
  }
}

}  // namespace faults_test
}  // namespace pvol
