// Shells on the command line: fitted, verified, checked, rendered with, converted.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/pvol_file.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace shells_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

/// A tilted ellipsoid of about 48 voxels, and the .pvol file with its shell.
struct Files {
  ScratchFolder folder;
  std::string recipe = folder / "egg.toml", cloud = folder / "egg.pvol";
  json report;

  explicit Files(const std::vector<std::string>& options) {
    std::ofstream(recipe) << "[recipe]\nresolution = 48\nedge = 0.05\n[[form]]\n"
                             "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [1, 0.2, 0.3]\n"
                             "rotation = [0, 20, 40]\n";
    std::vector<std::string> arguments{recipe, "-o", cloud, "--json"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const RunResult r = run_tool(PVOL_FIT, arguments);
    EXPECT_EQ(r.exit, 0) << r.err;
    report = json::parse(r.out, nullptr, false);
  }
};

void expect_exit(int code, const RunResult& r, const std::string& key) {
  EXPECT_EQ(r.exit, code) << r.err;
  EXPECT_TRUE(says(r.out + r.err, key));
}

TEST(Shells, AreFittedStoredAndVerified) {
  const Files f({"--shells", "4"});
  ASSERT_TRUE(f.report.contains("shell"));
  const json& shell = f.report["shell"];
  EXPECT_EQ(shell["kind"], "hard");
  EXPECT_EQ(shell["perturbations"], 4);
  EXPECT_EQ(shell["bytes"], 88 + 4 * 44);
  EXPECT_LT(shell["volume_ratio"].get<double>(), 0.6 * shell["box_volume_ratio"].get<double>());
  EXPECT_GE(shell["volume_ratio"].get<double>(), 1);
  EXPECT_GE(shell["hit_ratio"].get<double>(), 1);
  EXPECT_GT(shell["certificate"]["bound"].get<double>(), 0);

  const RunResult r = run_tool(PVOL_STATS, {"shells", f.cloud, "--verify", "--json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json verified = json::parse(r.out)["verified"];
  EXPECT_GE(verified["certificate"]["bound"], shell["certificate"]["bound"]);
  EXPECT_NEAR(verified["volume_ratio"], shell["volume_ratio"], 1e-6);
  expect_exit(0, run_tool(PVOL_STATS, {"shells", f.cloud, "--verify"}),
              "shell.verified_proof_again");
}

TEST(Shells, SoftOnesAreTheirOwnKind) {
  const Files f({"--shells", "2", "--shell-kind", "soft"});
  EXPECT_EQ(f.report["shell"]["kind"], "soft");
  expect_exit(0, run_tool(PVOL_STATS, {"shells", f.cloud, "--verify"}),
              "shell.soft_perturbations_b");
}

TEST(Shells, AutoChoosesANumber) {
  const Files f({"--shells", "auto"});
  EXPECT_LE(f.report["shell"]["perturbations"], 64);
}

TEST(Shells, ThatDoNotHoldAreFound) {
  const Files f({"--shells", "2"});
  formats::PvolFile content = formats::read_pvol(f.cloud);
  ASSERT_TRUE(content.shell);
  content.shell->form.base.constant -= 0.125;
  formats::write_pvol(f.cloud, content);
  expect_exit(1, run_tool(PVOL_STATS, {"shells", f.cloud, "--verify"}), "shell.shell_not_proven");
  const std::vector<std::string> render{f.cloud, "-o", f.folder / "a.png", "--size", "8x8",
                                        "--spp", "1",  "--quiet"};
  expect_exit(1, run_tool(PVOL_RENDER, render), "shell.shell_not_contain");
  std::vector<std::string> without = render;
  without.insert(without.end(), {"--shells", "off"});
  EXPECT_EQ(run_tool(PVOL_RENDER, without).exit, 0);
  const RunResult r = run_tool(PVOL_STATS, {"shells", f.cloud, "--check"});
  if (times_said(r.err, "shell.without_cgal") > 0) GTEST_SKIP() << "built without CGAL";
  expect_exit(1, r, "shell.exact_signs_points");
}

TEST(Shells, AreCheckedByCgal) {
  ScratchFolder folder;
  std::ofstream(folder / "a.toml") << "[recipe]\nresolution = 24\n[[form]]\nshape = \"ellipsoid\"\n"
                                      "centre = [0, 0, 0]\nradii = 1\n";
  const RunResult r =
      run_tool(PVOL_FIT, {folder / "a.toml", "-o", folder / "a.pvol", "--shells", "2", "--check"});
  if (times_said(r.err, "shell.without_cgal") > 0) GTEST_SKIP() << "built without CGAL";
  expect_exit(0, r, "shell.contained_no_occupied");
}

TEST(Shells, AreLeftOutWhereNodesAreHomogenised) {
  // Homogeneous nodes have density where the shell was proven to leave none out.
  const Files f({"--shells", "3"});
  for (const std::string use : {"on", "off"}) {
    const RunResult r =
        run_tool(PVOL_RENDER, {f.cloud, "-o", f.folder / (use + ".png"), "--shells", use, "--size",
                               "40x40", "--spp", "4", "--stats", "-", "--set",
                               "medium.extinction=8", "--homogenise", "100"});
    ASSERT_EQ(r.exit, 0) << r.err;
    EXPECT_EQ(json::parse(r.out)["options"]["shell_used"], false);
  }
  EXPECT_EQ(read_text(f.folder / "on.png"), read_text(f.folder / "off.png"));
}

TEST(Shells, ChangeNoPixel) {
  const Files f({"--shells", "3"});
  std::string stats[2];
  for (const std::string use : {"on", "off"}) {
    const RunResult r = run_tool(
        PVOL_RENDER, {f.cloud, "-o", f.folder / (use + ".png"), "--shells", use, "--size", "40x40",
                      "--spp", "4", "--stats", "-", "--set", "medium.extinction=8"});
    ASSERT_EQ(r.exit, 0) << r.err;
    const json j = json::parse(r.out);
    EXPECT_EQ(j["options"]["shell_used"], use == "on");
    EXPECT_EQ(j["shell_rejections"] > 0, use == "on");
    EXPECT_TRUE(says(r.err, use == "on" ? "shell.shell_used" : "shell.shell_left_out"));
  }
  EXPECT_EQ(read_text(f.folder / "on.png"), read_text(f.folder / "off.png"));
}

TEST(Shells, ConvertToMeshesAndSlices) {
  const Files f({"--shells", "3"});
  for (const char* name : {"a.ply", "a.obj", "a.png"}) {
    const RunResult r = run_tool(PVOL_CONVERT, {f.cloud, f.folder / name});
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_GT(std::filesystem::file_size(f.folder / name), 1000u);
  }
  EXPECT_EQ(read_text(f.folder / "a.ply").substr(0, 4), "ply\n");
  const Files without({});
  expect_exit(1, run_tool(PVOL_CONVERT, {without.cloud, f.folder / "b.ply"}),
              "shell.error_egg_holds");
  EXPECT_FALSE(std::filesystem::exists(f.folder / "b.ply"));
}

TEST(Shells, OfRecipesNeedNoSamples) {
  const Files f({"--closed-form", "--shells", "2"});
  EXPECT_EQ(f.report["bytes"]["density"], 0);
  EXPECT_GT(f.report["bounds"]["leaves"], 0);
  // The exact support lies in that of the closed form.
  expect_exit(0, run_tool(PVOL_STATS, {"shells", f.cloud, "--verify"}),
              "shell.verified_proof_again");
  const RunResult r = run_tool(
      PVOL_RENDER, {f.cloud, "-o", f.folder / "a.png", "--size", "24x24", "--spp", "2", "--quiet"});
  EXPECT_EQ(r.exit, 0) << r.err;
  expect_exit(2, run_tool(PVOL_FIT, {f.folder / "a.vdb", "-o", f.cloud, "--closed-form"}),
              "shell.closed_form_recipes");
}

TEST(Shells, MisuseIsRefused) {
  const Files f({});
  expect_exit(1, run_tool(PVOL_STATS, {"shells", f.cloud}), "shell.error_egg_holds");
  expect_exit(2, run_tool(PVOL_STATS, {"shells", f.recipe}), "shell.shells_kept_files");
  expect_exit(2, run_tool(PVOL_FIT, {f.recipe, "-o", f.cloud, "--shells", "65"}),
              "shell.shells_auto_none");
  expect_exit(2, run_tool(PVOL_FIT, {f.recipe, "-o", f.cloud, "--check"}),
              "shell.check_needs_shell");
  expect_exit(
      2, run_tool(PVOL_FIT, {f.recipe, "-o", f.cloud, "--shells", "33", "--shell-kind", "soft"}),
      "shell.shells_expected_most_perturbations");
  expect_exit(2, run_tool(PVOL_RENDER, {f.cloud, "-o", f.folder / "a.png", "--shells", "yes"}),
              "shell.shells_yes_auto_off");
}

}  // namespace shells_test
}  // namespace pvol
