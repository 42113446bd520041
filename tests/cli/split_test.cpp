// pvol-render --split, and arrays of pvol-stats: what is printed, for whom, and what is refused.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace split_test {

using nlohmann::json;
using testing::operator+;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

struct Split : ::testing::Test {
  ScratchFolder folder;
  std::string ball = folder / "ball & co.toml", exr = folder / "whole.exr";

  Split() {
    write(ball, 1);
    for (const int frame : {1, 2}) write(folder / fmt::format("smoke.{:04}.toml", frame), frame);
  }
  static void write(const std::string& file, double density) {
    std::ofstream(file) << "[recipe]\nresolution = 20\ndensity = " << density
                        << "\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  }

  RunResult split(const Words& more, int exit = 0) const {
    RunResult r =
        run_tool(PVOL_RENDER, Words{ball, "-o", exr, "--size", "96x64", "--spp", "32"} + more);
    EXPECT_EQ(r.exit, exit) << r.err;
    return r;
  }
  [[nodiscard]] json parts(const Words& more) const {
    return json::parse(split(more + Words{"--for", "json"}).out);
  }
  void refuse(const Words& more, const std::string& key) const {
    const RunResult r = split(more, 2);
    EXPECT_EQ(r.out, "");
    EXPECT_TRUE(says(r.err, key));
  }
  [[nodiscard]] RunResult bash(const std::string& script, const Words& flags = {}) const {
    std::ofstream(folder / "script.sh") << script;
    return run_tool("/bin/bash", flags + Words{folder / "script.sh"});
  }
};

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// The word after a flag.
std::string after(const json& command, const std::string& flag) {
  const auto at = std::find(command.begin(), command.end(), flag);
  return at == command.end() || at + 1 == command.end() ? "" : (at + 1)->get<std::string>();
}

TEST_F(Split, RendersNothingAndSaysWhatToExpect) {
  const RunResult r = split({"--split", "5"});
  EXPECT_EQ(count(r.out, "--crop "), 5u);
  EXPECT_EQ(count(r.out, " merge "), 1u);
  EXPECT_TRUE(says(r.err, "split.parts_cpu_time_forecast"));
  EXPECT_TRUE(says(r.err, "split.parts_cpu_time"));
  EXPECT_FALSE(std::filesystem::exists(exr) || std::filesystem::exists(folder / "whole.parts"));
  EXPECT_EQ(bash(r.out, {"-n"}).exit, 0) << "the text is a script for bash";
}

TEST_F(Split, EchoesTheOptionsToEachPart) {
  const json j = parts({"--split", "3", "--set", "medium.g=0.25", "--png=look.png", "--exposure",
                        "1.5", "--guide", "off", "--aov=variance"});
  ASSERT_EQ(j.at("parts").size(), 3u);
  double share = 0;
  for (const json& p : j["parts"]) {
    const json& c = p.at("command");
    EXPECT_EQ(c.at(0), PVOL_RENDER);
    EXPECT_EQ(c.at(1), ball) << "as given";
    EXPECT_EQ(after(c, "--size"), "96x64");
    EXPECT_EQ(after(c, "--set"), "medium.g=0.25");
    EXPECT_EQ(after(c, "--guide"), "off");
    EXPECT_EQ(after(c, "-o"), p.at("output"));
    EXPECT_EQ(after(c, "--samples"), "0:32");
    EXPECT_EQ(after(c, "--sums"), "on");
    EXPECT_EQ(after(c, "--checkpoint"), "10");
    EXPECT_EQ(p.at("samples"), json({0, 32}));
    EXPECT_EQ(after(c, "--crop"),
              fmt::format("{},{},{},{}", p["crop"][0].get<int>(), p["crop"][1].get<int>(),
                          p["crop"][2].get<int>(), p["crop"][3].get<int>()));
    const std::string words = c.dump();
    for (const char* flag : {"--aov=variance", "--resume", "--no-png"}) {
      EXPECT_EQ(count(words, flag), 1u) << flag;
    }
    for (const char* flag : {"--split", "--for", "--exposure", "--png="}) {
      EXPECT_EQ(count(words, flag), 0u) << flag;
    }
    share += p.at("share").get<double>();
  }
  EXPECT_NEAR(share, 1, 1e-9);
  const json& merge = j.at("merge").at("command");
  EXPECT_EQ(merge.at(1), "merge");
  for (const json& p : j["parts"]) {
    EXPECT_NE(std::find(merge.begin(), merge.end(), p["output"]), merge.end());
  }
  EXPECT_EQ(after(merge, "-o"), exr);
  EXPECT_EQ(after(merge, "--png"), "look.png");
  EXPECT_EQ(after(merge, "--exposure"), "1.5");
  EXPECT_EQ(after(merge, "--crop"), "") << "it is the whole image";
}

TEST_F(Split, PutsTheConverterBesideTheRenderer) {
  const std::string merge = parts({"--split", "2"})["merge"]["command"][0];
  EXPECT_TRUE(std::filesystem::equivalent(merge, PVOL_CONVERT)) << merge;
}

TEST_F(Split, StaysWithinACrop) {
  int samples = 0;
  const json j = parts({"--crop", "10,20,50,30", "--split", "4"});
  for (const json& p : j.at("parts")) {
    const json& c = p["crop"];
    EXPECT_GE(c[0], 10);
    EXPECT_GE(c[1], 20);
    EXPECT_LE(c[0].get<int>() + c[2].get<int>(), 60);
    EXPECT_LE(c[1].get<int>() + c[3].get<int>(), 50);
    samples += c[2].get<int>() * c[3].get<int>() *
               (p["samples"][1].get<int>() - p["samples"][0].get<int>());
  }
  EXPECT_EQ(samples, 50 * 30 * 32);
  EXPECT_EQ(after(j["merge"]["command"], "--crop"), "10,20,50,30");
}

TEST_F(Split, CutsSamplesWherePixelsAreFew) {
  const json j = parts({"--size", "16x16", "--split", "4"});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(j["parts"][std::size_t(i)]["samples"], json({8 * i, 8 * i + 8}));
  }
}

TEST_F(Split, AdaptiveHasPilotsFirst) {
  const json j = parts({"--spp=1", "--noise", "0.02", "--split", "6"});
  ASSERT_TRUE(j.contains("pilots"));
  for (const json& p : j["pilots"].at("parts")) {
    EXPECT_EQ(after(p["command"], "--samples"), "0:16");
    EXPECT_EQ(after(p["command"], "--noise"), "0.02");
  }
  const json& merge = j["pilots"].at("merge");
  EXPECT_NE(merge["command"].dump().find("--partial"), std::string::npos);
  EXPECT_EQ(j["parts"].size(), 6u);
  for (const json& p : j["parts"]) {
    EXPECT_EQ(after(p["command"], "--pilot"), merge["output"]);
    EXPECT_EQ(after(p["command"], "--samples"), "");
    EXPECT_FALSE(p.contains("samples"));
  }
}

TEST_F(Split, OfASequenceHasPartsOfEachFrame) {
  const Words frames{folder / "smoke.####.toml",
                     "-o",
                     folder / "a.####.exr",
                     "--frames",
                     "1-2",
                     "--size",
                     "96x64",
                     "--split",
                     "3",
                     "--for"};
  const RunResult r = run_tool(PVOL_RENDER, frames + Words{"json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out).at("frames");
  ASSERT_EQ(j.size(), 2u);
  for (const json& f : j) {
    const int number = f.at("frame");
    EXPECT_EQ(f["parts"].size(), 3u);
    for (const json& p : f["parts"]) {
      EXPECT_EQ(after(p["command"], "--frame"), std::to_string(number));
      EXPECT_EQ(after(p["command"], "--frames"), "1-2") << "choices are those of the sequence";
      EXPECT_EQ(
          p["output"],
          std::filesystem::path(after(p["command"], "-o"))
              .replace_filename(std::filesystem::path(p["output"].get<std::string>()).filename())
              .string());
    }
    EXPECT_EQ(after(f["merge"]["command"], "-o"), folder / fmt::format("a.{:04}.exr", number));
  }
  const RunResult slurm = run_tool(PVOL_RENDER, frames + Words{"slurm"});
  EXPECT_NE(slurm.out.find("submit parts 6 "), std::string::npos) << slurm.out;
  EXPECT_NE(slurm.out.find("submit merges 2 "), std::string::npos) << slurm.out;
}

TEST_F(Split, ForSlurmIsAScriptThatSubmitsArrays) {
  const RunResult r = split({"--split", "5", "--for", "slurm", "--at-once", "2", "--noise", "0.1"});
  EXPECT_EQ(bash(r.out, {"-n"}).exit, 0);
  for (const char* line : {"submit pilots ", "submit pilot-merges 1 '' ", "submit parts 5 '%2' ",
                           "submit merges 1 '' ", "afterok$jobs"}) {
    EXPECT_NE(r.out.find(line), std::string::npos) << line << r.out;
  }
  EXPECT_EQ(count(r.out, " --threads \"${SLURM_CPUS_ON_NODE:-0}\"\n"), count(r.out, "--crop "));
  const RunResult told = split({"--split", "5", "--for", "slurm", "--threads", "3"});
  EXPECT_EQ(count(told.out, "SLURM_CPUS_ON_NODE"), 0u);
}

TEST_F(Split, RefusesWhatCannotBe) {
  refuse({"--split", "0"}, "split.split_whole_number");
  refuse({"--split", "100001"}, "split.split_100001_whole_number");
  refuse({"--size", "2x2", "--spp", "2", "--split", "9"}, "split.split_picture_x");
  refuse({"--split", "4", "--time", "10"}, "split.split_time_exclude");
  refuse({"--split", "4", "-o", folder / "a.png"}, "split.split_output_png");
  refuse({"--split", "4", "--deep", folder / "deep.exr"}, "split.split_deep_exclude");
  refuse({"--split", "4", "--stats", folder / "s.json"}, "split.split_stats_exclude");
  refuse({"--split", "4", "--live"}, "split.split_live_exclude");
  refuse({"--split", "4", "--denoise"}, "split.split_denoise_exclude");
  refuse({"--split", "4", "--print-scene"}, "split.split_print_scene");
  refuse({"--for", "json"}, "split.needs_split_n");
  refuse({"--at-once", "3"}, "split.at_once_without_split");
  refuse({"--split", "4", "--at-once", "3"}, "split.at_once_without_slurm");
  refuse({"--split", "4", "--for", "condor"}, "split.condor_text_json");
}

// --- copies of clouds ---------------------------------------------------------------------------

struct Copies : Split {
  std::string pvol = folder / "ball.pvol", there = folder / "local";
  [[nodiscard]] std::string copy_of(const std::string& file) const {
    return there + std::filesystem::absolute(file).string();
  }
  void fit(const Words& more = {}) const {
    const RunResult c = run_tool(PVOL_CONVERT, {ball, folder / "ball.vdb"});
    EXPECT_EQ(c.exit, 0) << c.err;
    const RunResult r = run_tool(PVOL_FIT, Words{folder / "ball.vdb", "-o", pvol} + more);
    EXPECT_EQ(r.exit, 0) << r.err;
  }
  std::string render(const Words& more) const {
    const RunResult r =
        run_tool(PVOL_RENDER, Words{pvol, "-o", exr, "--size", "12x8", "--spp", "2"} + more);
    EXPECT_EQ(r.exit, 0) << r.err;
    return read_text(exr);
  }
};

TEST_F(Copies, AreReadInPlaceOfTheFilesAndNotRecorded) {
  fit();
  const std::string plain = render({});
  EXPECT_EQ(render({"--local-copies", there}), plain) << "names in the header are the own ones";
  ASSERT_TRUE(std::filesystem::exists(copy_of(pvol)));
  EXPECT_EQ(read_text(copy_of(pvol)), read_text(pvol));
  struct stat folder_info = {};
  ASSERT_EQ(stat(there.c_str(), &folder_info), 0);
  EXPECT_EQ(folder_info.st_mode & 0777, 0700u);
  // What was made once is read again.
  const auto made = std::filesystem::last_write_time(copy_of(pvol));
  EXPECT_EQ(render({"--local-copies", there}), plain);
  EXPECT_EQ(std::filesystem::last_write_time(copy_of(pvol)), made);
}

/// Also where size and time are the same, of the file or of its copy.
TEST_F(Copies, AreMadeAgainWhereTheFileIsAnother) {
  fit();
  (void)render({"--local-copies", there});
  const auto time = std::filesystem::last_write_time(pvol);
  write(ball, 3);
  fit();
  std::filesystem::last_write_time(pvol, time);
  const std::string plain = render({});
  EXPECT_EQ(render({"--local-copies", there}), plain);
  EXPECT_EQ(read_text(copy_of(pvol)), read_text(pvol));

  const auto copied = std::filesystem::last_write_time(copy_of(pvol));
  std::ofstream(copy_of(pvol)) << std::string(std::filesystem::file_size(pvol), 'x');
  std::filesystem::last_write_time(copy_of(pvol), copied);
  EXPECT_EQ(render({"--local-copies", there}), plain);
}

/// A folder that is another's, or may be: nothing is read from it, and nothing is written to it.
TEST_F(Copies, AreNotSoughtWhereOthersCanWrite) {
  fit();
  const std::string plain = render({}), elsewhere = folder / "elsewhere";
  const auto expect_original = [&](const char* key) {
    const RunResult r = run_tool(
        PVOL_RENDER, {pvol, "-o", exr, "--size", "12x8", "--spp", "2", "--local-copies", there});
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_TRUE(says(r.err, key));
    EXPECT_EQ(read_text(exr), plain);
    EXPECT_TRUE(std::filesystem::is_empty(there));
  };
  std::filesystem::create_directory(elsewhere);
  std::filesystem::create_directory_symlink(elsewhere, there);
  expect_original("split.copies_in_link");
  std::filesystem::remove(there);
  std::filesystem::create_directory(there);
  ASSERT_EQ(chmod(there.c_str(), 0777), 0);
  expect_original("split.copies_open_to_others");
  ASSERT_EQ(chmod(there.c_str(), 0755), 0);
  if (chown(there.c_str(), 12345, gid_t(-1)) == 0) expect_original("split.copies_of_another");
}

TEST_F(Copies, BringADensityAlongThatIsInAnotherFile) {
  fit({"--density", "reference"});
  const std::string plain = render({});
  EXPECT_EQ(render({"--local-copies", there}), plain);
  EXPECT_TRUE(std::filesystem::exists(copy_of(folder / "ball.vdb")));
}

TEST_F(Copies, ThatCannotBeMadeAreNotNeeded) {
  fit();
  std::ofstream(folder / "file") << "no folder";
  const RunResult r = run_tool(PVOL_RENDER, {pvol, "-o", exr, "--size", "12x8", "--spp", "2",
                                             "--local-copies", folder / "file"});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "split.copies_in_file"));
}

// --- arrays of pvol-stats -----------------------------------------------------------------------

TEST_F(Split, OfStatisticsIsATaskForEachCloud) {
  const Words clouds{"depth", ball, folder / "smoke.0001.toml", "--budget", "10", "--size", "8x8",
                     "--spp", "4"};
  const RunResult r = run_tool(PVOL_STATS, clouds + Words{"--for", "json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json tasks = json::parse(r.out).at("tasks");
  ASSERT_EQ(tasks.size(), 2u);
  EXPECT_EQ(tasks[0]["command"], json({PVOL_STATS, "depth", ball, "--budget", "10", "--size", "8x8",
                                       "--spp", "4", "--json", "--quiet"}));
  EXPECT_EQ(tasks[0]["stdout"], "ball & co.depth.json");
  EXPECT_EQ(tasks[1]["stdout"], "smoke.0001.depth.json");

  const RunResult text = run_tool(PVOL_STATS, clouds + Words{"--for", "text"});
  const RunResult run = bash("cd '" + folder.path().string() + "'\n" + text.out);
  EXPECT_EQ(run.exit, 0) << run.err;
  EXPECT_TRUE(json::accept(read_text(folder / "ball & co.depth.json")));

  EXPECT_EQ(run_tool(PVOL_STATS, clouds).exit, 2) << "several without --for";
  EXPECT_EQ(run_tool(PVOL_STATS, clouds + Words{"--for", "text", "--html", "a.html"}).exit, 2);
  EXPECT_EQ(run_tool(PVOL_STATS, {"depth", ball, ball, "--for", "text"}).exit, 2) << "one name";
}

}  // namespace split_test
}  // namespace pvol
