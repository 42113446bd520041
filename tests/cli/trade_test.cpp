// pvol-stats depth and trade as users call them.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/effort.h"
#include "support/html_check.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace trade_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

struct Recipe {
  ScratchFolder folder;
  std::string file = folder / "ball & co.toml";

  Recipe() {
    std::ofstream(file) << "[recipe]\nresolution = 40\nedge = 0.05\n[[form]]\n"
                           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [1, 1, 1]\n";
  }
};

/// Arguments for a small picture that is measured quickly.
std::vector<std::string> quick(const std::string& verb, const std::string& file,
                               std::vector<std::string> more) {
  std::vector<std::string> a{verb, file, "--size", "16x12", "--thickness", "10", "--quiet"};
  a.insert(a.end(), more.begin(), more.end());
  return a;
}

/// Within a short budget, or a longer one where other work slows the machine down too much for
/// that.
RunResult measure_shortly(std::vector<std::string> words) {
  words.insert(words.begin() + 2, {"--budget", ""});
  RunResult r;
  for (const char* const budget : {"6", "30", "150"}) {
    words[3] = budget;
    r = run_tool(PVOL_STATS, words);
    if (r.exit == 0) break;
  }
  return r;
}

void expect_estimate(const json& e) {
  EXPECT_LE(e.at("low"), e.at("value"));
  EXPECT_LE(e.at("value"), e.at("high"));
  EXPECT_GT(e.at("coverage"), 0);
}

TEST(Depth, ReportsEachDepthAgainstTheFirst) {
  const Recipe recipe;
  const std::string page = recipe.folder / "depth.html";
  const RunResult r =
      measure_shortly(quick("depth", recipe.file, {"--spp", "32", "--json", "--html", page}));
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  EXPECT_EQ(j.at("tracker"), "decomposition");
  EXPECT_EQ(j.at("size"), json({16, 12}));
  EXPECT_EQ(j.at("paper").at(1).at("build_ratio"), 11.47);
  ASSERT_EQ(j.at("depths").size(), 4u);
  const json& first = j["depths"][0];
  EXPECT_EQ(first.at("depth"), 0);
  EXPECT_EQ(first.at("effective_depth"), 0);
  EXPECT_EQ(first.at("time_ratio").at("value"), 1);
  for (const json& d : j["depths"]) {
    if (d.contains("left_out")) continue;
    EXPECT_LE(d.at("effective_depth"), d.at("depth"));
    for (const char* key : {"build_ratio", "tree_ratio", "time_ratio", "time_x_variance_ratio"}) {
      expect_estimate(d.at(key));
    }
    for (const char* key :
         {"bounds_cpu_seconds", "tree_cpu_seconds", "lookups_per_sample", "bounds_tests_per_sample",
          "segments_per_sample", "relative_rmse_of_one_sample", "lookups_x_variance"}) {
      EXPECT_GE(d.at(key), 0) << key;
    }
    EXPECT_FALSE(d.at("bias_detected"));
  }
  EXPECT_GT(first.at("lookups_per_sample"), j["depths"][3].at("lookups_per_sample"));
  EXPECT_TRUE(testing::is_page(page));
  const std::string text = read_text(page);
  EXPECT_EQ(text.find("<!DOCTYPE html>"), 0u);
  EXPECT_NE(text.find("ball &amp; co.toml"), std::string::npos);
}

TEST(Depth, PrintsThePaperBesideItsTable) {
  const Recipe recipe;
  const RunResult r = measure_shortly({"depth", recipe.file, "--size", "16x12", "--thickness", "5",
                                       "--depths", "0,16", "--tracker", "delta"});
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_NE(r.out.find("4.92 / 11.47 / 14.31"), std::string::npos);
  std::string unwrapped = r.out;  // lines end where the name of the file leaves room
  std::ranges::replace(unwrapped, '\n', ' ');
  EXPECT_TRUE(says(unwrapped, "trade.albedo_g"));
  EXPECT_NE(r.out.find("16 = 5"), std::string::npos) << r.out;
  EXPECT_NE(r.err.find("left"), std::string::npos);  // says what is measured next
}

TEST(Trade, ReportsEverySettingAgainstTheDefault) {
  const Recipe recipe;
  const std::string page = recipe.folder / "trade.html";
  const RunResult r = measure_shortly(quick(
      "trade", recipe.file, {"--threads", "1", "--json", "--html", page, "--max-error", "0.1"}));
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  EXPECT_EQ(j.at("false_alarm_rate"), 0.01);
  EXPECT_GT(j.at("reference").at("samples"), 0);
  ASSERT_GT(j.at("settings").size(), 15u);
  EXPECT_EQ(j["settings"][0].at("setting"), "default");
  bool any_front = false;
  for (const json& s : j["settings"]) {
    for (const char* key : {"setting", "factor", "biased_by_design"}) EXPECT_TRUE(s.contains(key));
    if (s.contains("left_out")) continue;
    for (const char* key : {"time", "variance", "time_x_variance"}) expect_estimate(s.at(key));
    EXPECT_GT(s.at("counts").at("samples"), 0);
    EXPECT_GT(s.at("bytes").at("file"), 0);
    EXPECT_TRUE(s.at("bias").at("detected").is_boolean());
    EXPECT_TRUE(s.contains("instructions"));  // null where the machine counts none
    any_front = any_front || s.at("on_front");
  }
  EXPECT_TRUE(any_front);
  const json& advice = j.at("goals").at(0).at("advice");
  EXPECT_LE(advice.at("relative_error"), 0.1);
  EXPECT_EQ(advice.at("command").get<std::string>().find("pvol-render '"), 0u);
  EXPECT_TRUE(testing::is_page(page));
  const std::string text = read_text(page);
  EXPECT_NE(text.find("data:image/png"), std::string::npos);
  EXPECT_EQ(testing::without_pictures(text).find("nan"), std::string::npos);
}

void expect_exit(int code, const std::vector<std::string>& arguments, const std::string& key) {
  const RunResult r = run_tool(PVOL_STATS, arguments);
  EXPECT_EQ(r.exit, code) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_TRUE(says(r.err, key));
}

TEST(Trade, RefusesWhatCannotBe) {
  const Recipe recipe;
  expect_exit(2, {"trade", recipe.file, "--max-error", "0.1", "--max-time", "3"},
              "trade.max_error_and_time");
  expect_exit(2, {"trade", recipe.file, "--budget", "0"}, "trade.budget_number");
  expect_exit(2, {"trade", recipe.file, "--size", "0x3"}, "trade.size_0x3_wxh_whole");
  expect_exit(2, {"trade", recipe.file, "--html", "trade.txt"}, "trade.output_trade_txt");
  expect_exit(2, {"depth", recipe.file, "--depths", "3,24"}, "trade.depths_whole_number");
  expect_exit(2, {"depth", recipe.file, "--tracker", "delta-global"}, "trade.tracker_delta_global");
  expect_exit(2, {"depth", recipe.file, "--thickness", "3", "--extinction", "1"},
              "trade.thickness_and_extinction");
  expect_exit(1, {"trade", recipe.folder / "none.vdb"}, "trade.open_none_vdb");
  // A thick cloud without absorption would keep its paths for ever.
  expect_exit(1, {"trade", recipe.file, "--thickness", "1e8", "--set", "medium.albedo=1"},
              "trade.ball_co_toml");
  // Nothing can be measured of a black picture; a fifth of the budget is there to find that out.
  expect_exit(1,
              {"trade", recipe.file, "--set", "environment.type=constant", "--set",
               "environment.radiance=0", "--set", "sun.irradiance=0", "--quiet", "--size", "16x12",
               "--budget", "10"},
              "trade.ball_co_toml_picture");
}

/// A million null collisions a flight, of which each pixel has one.
TEST(Trade, MeasuresWhatHardlyEndsWhereUsersInsist) {
  const Recipe recipe;
  using Verb = std::vector<std::string>;
  std::vector<Verb> verbs{{"depth", "--spp", "4"}};
  if (proof::runs_all()) verbs.push_back({"trade"});
  for (const Verb& verb : verbs) {
    std::vector<std::string> a = verb;
    a.insert(a.begin() + 1, {recipe.file, "--size", "1x1", "--quiet"});
    a.insert(a.end(), {"--extinction", "4e5", "--set", "medium.albedo=0"});
    a.insert(a.end(), {"--set", "render.depth=0"});
    expect_exit(1, a, "trade.ball_co_toml_ray");
    a.emplace_back("--force");
    const RunResult r = measure_shortly(a);
    EXPECT_EQ(r.exit, 0) << verb.front() << ": " << r.err;
  }
}

TEST(Trade, SaysWhereTheBudgetIsTooShort) {
  const Recipe recipe;
  expect_exit(1, {"trade", recipe.file, "--size", "1024x1024", "--budget", "0.1", "--quiet"},
              "trade.budget_too_short");
}

TEST(Trade, MeasuresWhatTheFilterGainsAndFalsifies) {
  const Recipe recipe;
  const std::string page = recipe.folder / "filter.html";
  const RunResult r =
      run_tool(PVOL_STATS, {"trade", recipe.file, "--size", "24x20", "--thickness", "10", "--quiet",
                            "--denoise", "--budget", "4", "--json", "--html", page});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  EXPECT_EQ(j.at("size"), json({24, 20}));
  ASSERT_GE(j.at("denoise").size(), 1u);
  double samples = 4;
  for (const json& f : j["denoise"]) {
    EXPECT_EQ(f.at("samples"), samples);
    EXPECT_GE(f.at("pictures"), 3);
    EXPECT_GT(f.at("noise"), 0);
    EXPECT_LE(f.at("filtered").at("low"), f.at("filtered").at("value"));
    EXPECT_GT(f.at("cpu_seconds").at("filter"), 0);
    EXPECT_GT(f.at("gain"), 0);
    samples *= 4;
  }
  EXPECT_LT(j["denoise"][0]["filtered"]["value"], 0.7 * double(j["denoise"][0]["noise"]));
  ASSERT_EQ(j.at("goals").size(), 3u);
  EXPECT_NE(std::string(j["goals"][0].at("command")).find("--spp "), std::string::npos);
  EXPECT_TRUE(testing::is_page(page));
}

TEST(Trade, OfTheFilterTakesNoTimeForAGoal) {
  const Recipe recipe;
  const RunResult r = run_tool(PVOL_STATS, {"trade", recipe.file, "--denoise", "--max-time", "10"});
  EXPECT_EQ(r.exit, 2);
}

}  // namespace trade_test
}  // namespace pvol
