// pvol-stats image, and what bounds and shells can do beyond their tables.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/image.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/vdb.h"
#include "support/html_check.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace stats_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

void expect_exit(int code, const RunResult& r, const std::string& key) {
  EXPECT_EQ(r.exit, code) << r.err;
  EXPECT_TRUE(says(r.out + r.err, key));
}

void expect_page(const std::string& file) {
  ASSERT_TRUE(std::filesystem::exists(file));
  EXPECT_TRUE(testing::is_page(file));
}

/// A ball of about 32 voxels with a shell.
struct Ball {
  ScratchFolder folder;
  std::string recipe = folder / "ball.toml", cloud = folder / "ball.pvol";

  Ball() {
    std::ofstream(recipe) << "[recipe]\nresolution = 32\nedge = 0.3\n[[form]]\n"
                             "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
    static const std::string fitted = fit();  // once for all tests
    std::ofstream(cloud, std::ios::binary) << fitted;
  }

  [[nodiscard]] std::string fit() const {
    const RunResult r = run_tool(PVOL_FIT, {recipe, "-o", cloud, "--shells", "2", "--quiet"});
    EXPECT_EQ(r.exit, 0) << r.err;
    return read_text(cloud);
  }

  /// Renders a small picture and returns its file.
  [[nodiscard]] std::string render(const std::string& name, const std::vector<std::string>& options,
                                   const std::string& samples = "32") const {
    std::vector<std::string> all{cloud,
                                 "-o",
                                 folder / name,
                                 "--size",
                                 "32x32",
                                 "--spp",
                                 samples,
                                 "--quiet",
                                 "--no-png",
                                 "--set",
                                 "medium.extinction=8",
                                 "--aov",
                                 "variance,samples"};
    all.insert(all.end(), options.begin(), options.end());
    const RunResult r = run_tool(PVOL_RENDER, all);
    EXPECT_EQ(r.exit, 0) << r.err;
    return folder / name;
  }
};

TEST(StatsImage, AnUnbiasedSettingIsNotFlaggedAndABiasedOneIs) {
  const Ball ball;
  const std::string reference = ball.render("reference.exr", {"--seed", "1"});
  const std::string same = ball.render("same.exr", {"--seed", "2", "--tracker", "delta"});
  const std::string biased = ball.render("biased.exr", {"--seed", "3", "--max-bounces", "2"});

  RunResult r = run_tool(PVOL_STATS, {"image", same, reference, "--fail-on-bias"});
  expect_exit(0, r, "comparison.no_bias_detected");
  r = run_tool(PVOL_STATS, {"image", biased, reference, "--fail-on-bias"});
  expect_exit(1, r, "comparison.bias_detected");
  expect_exit(0, run_tool(PVOL_STATS, {"image", biased, reference}), "comparison.bias_detected");

  r = run_tool(PVOL_STATS, {"image", biased, reference, "--json", "--confidence", "0.9"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  EXPECT_EQ(j.at("confidence"), 0.9);
  EXPECT_EQ(j.at("size"), json({32, 32}));
  EXPECT_TRUE(j.at("verdict").at("bias_detected"));
  EXPECT_LT(j.at("verdict").at("p_value"), 1e-3);
  EXPECT_EQ(j.at("verdict").at("worst_region").at("rectangle").size(), 4u);
  const json& luminance = j.at("luminance");
  EXPECT_LT(luminance.at("bias").get<double>() + luminance.at("bias_half_width").get<double>(), 0);
  EXPECT_NEAR(luminance.at("mse").get<double>() - luminance.at("explained_mse").get<double>(),
              luminance.at("systematic_mse").get<double>(), 1e-12);
  for (const char* channel : {"R", "G", "B"}) EXPECT_TRUE(j.at("channels").contains(channel));
  EXPECT_EQ(j.at("tails").size(), 3u);
  EXPECT_TRUE(j.at("largest_pixel").contains("sigmas"));
}

TEST(StatsImage, WritesAPageAndMaps) {
  const Ball ball;
  const std::string a = ball.render("a & <b>.exr", {"--seed", "1"});
  const std::string b = ball.render("b.exr", {"--seed", "2"});
  const std::string page = ball.folder / "page.html", map = ball.folder / "map.exr";
  ASSERT_EQ(run_tool(PVOL_STATS, {"image", a, b, "--html", page, "--map", map}).exit, 0);
  expect_page(page);
  const Film fa = formats::read_film(a).film, fb = formats::read_film(b).film;
  const Film difference = formats::read_film(map).film;
  for (std::size_t i = 0; i < fa.pixels.size(); ++i) {
    const double expected = mean(fa.pixels[i]).y - mean(fb.pixels[i]).y;
    EXPECT_NEAR(mean(difference.pixels[i]).y, expected, 1e-6);
    const double variance = variance_of_mean(fa.pixels[i]).y + variance_of_mean(fb.pixels[i]).y;
    EXPECT_NEAR(variance_of_mean(difference.pixels[i]).y, variance, 1e-6 * variance + 1e-14);
  }
  ASSERT_EQ(run_tool(PVOL_STATS, {"image", a, b, "--map", ball.folder / "map.png"}).exit, 0);
  EXPECT_GT(std::filesystem::file_size(ball.folder / "map.png"), 500u);
}

TEST(StatsImage, SaysWhatItCannotKnow) {
  const Ball ball;
  const std::string a = ball.render("a.exr", {"--seed", "1"});
  const std::string b = ball.render("b.exr", {"--seed", "1", "--tracker", "delta"});
  expect_exit(0, run_tool(PVOL_STATS, {"image", a, b}), "comparison.both_pictures_rendered");
  const std::string one = ball.render("one.exr", {"--seed", "2"}, "1");
  const RunResult r = run_tool(PVOL_STATS, {"image", one, a, "--html", ball.folder / "p.html"});
  expect_exit(0, r, "comparison.whether_bias_not_known");
  expect_page(ball.folder / "p.html");
  expect_exit(1, run_tool(PVOL_STATS, {"image", one, a, "--fail-on-bias"}),
              "comparison.fail_bias_needs");
  const json j = json::parse(run_tool(PVOL_STATS, {"image", one, a, "--json"}).out);
  EXPECT_TRUE(j.at("verdict").is_null());
  EXPECT_TRUE(j.at("luminance").at("bias_half_width").is_null());
  EXPECT_TRUE(j.at("luminance").at("rmse").is_number());
}

/// Pictures as pvol-render writes them where nothing is asked for have no variances.
TEST(StatsImage, ComparesPlainPicturesAndSaysHowToKnowMore) {
  const Ball ball;
  const std::string a = ball.render("a.exr", {"--seed", "1"});
  const std::string plain = ball.render("plain.exr", {"--seed", "2", "--aov", "none"});
  const RunResult r = run_tool(PVOL_STATS, {"image", plain, a, "--html", ball.folder / "p.html",
                                            "--map", ball.folder / "map.exr"});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "comparison.no_variances", {plain}));
  EXPECT_EQ(times_said(r.err, "comparison.no_variances"), 1) << "the other has some: " << r.err;
  for (const char* key :
       {"comparison.relative_bias", "comparison.rmse", "comparison.whether_bias_not_known",
        "comparison.whether_bias_not_known"}) {
    EXPECT_TRUE(says(r.out + r.err, key));
  }
  expect_page(ball.folder / "p.html");
  EXPECT_FALSE(formats::read_film(ball.folder / "map.exr").has_variances);
  expect_exit(1, run_tool(PVOL_STATS, {"image", a, plain, "--fail-on-bias"}),
              "comparison.whether_bias_not_known");
}

/// A file of parts and half colour is the same picture, up to its rounding.
TEST(StatsImage, ComparesFilesOfEveryLayout) {
  const Ball ball;
  const std::string a = ball.render("a.exr", {});
  const std::string parts = ball.render("parts.exr", {"--multipart", "--compression", "piz"});
  const json j = json::parse(run_tool(PVOL_STATS, {"image", a, parts, "--json"}).out);
  EXPECT_EQ(j.at("luminance").at("rmse"), 0);
  EXPECT_FALSE(j.at("verdict").is_null());
  const std::string half = ball.render("half.exr", {"--pixel-type", "half"});
  const json k = json::parse(run_tool(PVOL_STATS, {"image", half, a, "--json"}).out);
  EXPECT_GT(k.at("luminance").at("rmse"), 0);
  EXPECT_LT(k.at("luminance").at("relative_rmse"), 1e-3);
}

TEST(StatsImage, MisuseIsRefused) {
  const Ball ball;
  const std::string a = ball.render("a.exr", {});
  const std::string crop = ball.render("crop.exr", {"--crop", "4,4,8,8"});
  expect_exit(1, run_tool(PVOL_STATS, {"image", a, crop}), "comparison.pictures_show_different");
  expect_exit(1, run_tool(PVOL_STATS, {"image", a, ball.folder / "absent.exr"}),
              "comparison.open_absent_exr");
  expect_exit(2, run_tool(PVOL_STATS, {"image", a}), "comparison.b_required");
  expect_exit(2, run_tool(PVOL_STATS, {"image", a, a, "--level", "2"}), "comparison.level_number");
  expect_exit(2, run_tool(PVOL_STATS, {"image", a, a, "--map", "m.jpg"}),
              "comparison.output_m_jpg");
  expect_exit(2, run_tool(PVOL_STATS, {"image", a, a, "--html", "m.txt"}),
              "comparison.output_m_txt");
}

TEST(StatsImage, DoesNotWriteOverItsPictures) {
  const Ball ball;
  const std::string a = ball.render("a.exr", {}), b = ball.render("b.exr", {"--seed", "2"});
  const std::string before = testing::read_text(a);
  expect_exit(2, run_tool(PVOL_STATS, {"image", a, b, "--map", a}), "comparison.map_exr_pictures");
  EXPECT_EQ(testing::read_text(a), before);
}

TEST(StatsBounds, WrongMicroBoundsAreFound) {
  const Ball ball;
  ASSERT_EQ(run_tool(PVOL_FIT, {ball.recipe, "-o", ball.cloud, "--micro-bounds", "2"}).exit, 0);
  expect_exit(0, run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify"}),
              "comparison.verified_bounds_leaves");
  formats::PvolFile content = formats::read_pvol(ball.cloud);
  ASSERT_TRUE(content.micro);
  for (MicroBounds::Codes& c : content.micro->by_leaf.codes) c.hi = c.lo;
  formats::write_pvol(ball.cloud, content);
  expect_exit(1, run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify"}),
              "comparison.micro_bounds_leaf");
}

TEST(StatsBounds, AWrongBoundIsFoundAndNamed) {
  const Ball ball;
  expect_exit(0, run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify"}),
              "comparison.verified_bounds_leaves");
  // A majorant 10 % too low, in a file whose sums are right.
  formats::PvolFile content = formats::read_pvol(ball.cloud);
  auto& leaves = content.pyramid.levels[0];
  std::size_t broken = 0;
  while (leaves[broken].hi > 0.8f || leaves[broken].hi < 0.2f) ++broken;
  const float scale = content.pyramid.scale, true_hi = leaves[broken].hi;
  leaves[broken].hi = decode(encode_down(0.9f * true_hi, scale), scale);
  for (std::size_t level = content.pyramid.levels.size(); level-- > 1;) {
    ASSERT_TRUE(std::none_of(content.pyramid.levels[level].begin(),
                             content.pyramid.levels[level].end(), [&](const PyramidNode& n) {
                               return is_uniform(content.pyramid, level,
                                                 *find(content.pyramid.levels[level], n.code));
                             }));
  }
  for (std::size_t level = 1; level < content.pyramid.levels.size(); ++level) {
    content.pyramid.levels[level].clear();
  }
  complete_levels(content.pyramid);
  formats::write_pvol(ball.cloud, content);

  const Vec3l cell = content.pyramid.origin + Vec3l(morton_decode(leaves[broken].code)) * kLeafEdge;
  const RunResult text = run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify"});
  expect_exit(1, text, "comparison.cubes_wrong_belong");
  expect_exit(1, text, "comparison.leaf_depth_cells");
  expect_exit(1, text, "comparison.leaf_depth_cells");
  const RunResult r = run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify", "--json"});
  EXPECT_EQ(r.exit, 1);
  const json verified = json::parse(r.out).at("verified");
  EXPECT_FALSE(verified.at("holds"));
  ASSERT_EQ(verified.at("wrong").size(), 1u);
  const json& wrong = verified["wrong"][0];
  EXPECT_EQ(wrong.at("kind"), "leaf");
  EXPECT_EQ(wrong.at("cells").at(0), json({cell.x, cell.y, cell.z}));
  EXPECT_NEAR(wrong.at("off"), 0.1, 0.002);
  EXPECT_LT(wrong.at("stored").at(1), wrong.at("found").at(1));
  // Without --verify the table is still made, and what would render refuses.
  EXPECT_EQ(run_tool(PVOL_STATS, {"bounds", ball.cloud}).exit, 0);
  expect_exit(1, run_tool(PVOL_STATS, {"bounds", ball.cloud, "--extinction", "1"}),
              "comparison.cube_voxels");
}

TEST(StatsBounds, MeasuresWhatItExpects) {
  const Ball ball;
  const RunResult r =
      run_tool(PVOL_STATS, {"bounds", ball.cloud, "--measure", "--verify", "--json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  EXPECT_TRUE(j.at("verified").at("holds"));
  const json& measured = j.at("measured");
  EXPECT_EQ(measured.at("extinction"), j.at("extinction"));
  const json& costs = measured.at("per_collision");
  EXPECT_GT(costs.at("delta").at("lookups"), 1);
  EXPECT_GT(costs.at("delta").at("lookups_half_width"), 0);
  EXPECT_LE(costs.at("squeezed").at("lookups"), costs.at("decomposition").at("lookups"));
  EXPECT_GT(measured.at("memory_bytes").at("micro_bounds"), 0);
  EXPECT_GE(j.at("skipped_share_of_box"), 0);
  std::uint64_t bytes = 0;
  for (const auto& [part, size] : j.at("bytes").items()) {
    if (part != "total") bytes += size.get<std::uint64_t>();
  }
  EXPECT_EQ(bytes, std::filesystem::file_size(ball.cloud));
  EXPECT_EQ(j.at("bytes").at("total"), bytes);
  for (const json& d : j.at("depths")) {
    for (const char* ratio : {"hi_over_mean", "lo_over_mean", "gap_over_mean"}) {
      const json& by_mass = d.at(ratio).at("by_mass");
      EXPECT_EQ(by_mass.at("quantiles").size(), 5u);
      double sum = by_mass.at("below").get<double>() + by_mass.at("above").get<double>();
      for (const json& share : by_mass.at("shares")) sum += share.get<double>();
      EXPECT_NEAR(sum, 1, 1e-9);
    }
  }
  expect_exit(0, run_tool(PVOL_STATS, {"bounds", ball.recipe, "--measure"}),
              "comparison.even_dense_measured");
}

TEST(StatsPages, OfBoundsAndShellsAreWellFormed) {
  const Ball ball;
  const std::string bounds = ball.folder / "bounds.html", shell = ball.folder / "shell.html";
  ASSERT_EQ(run_tool(PVOL_STATS, {"bounds", ball.cloud, "--verify", "--html", bounds}).exit, 0);
  expect_page(bounds);
  ASSERT_EQ(run_tool(PVOL_STATS, {"shells", ball.cloud, "--verify", "--html", shell}).exit, 0);
  expect_page(shell);
}

// --- info ---------------------------------------------------------------------------------------

/// A half-dense box of 4 x 5 x 6 samples of 0.25 to 2 from (-3, 8, 1) on, in voxels of 0.5 at an
/// offset.
VoxelGrid small_box(const char* name) {
  std::vector<float> values;
  for (int i = 0; i < 4 * 5 * 6; ++i) values.push_back(i == 0 ? 0.25f : i == 7 ? 2.0f : 1.0f);
  VoxelGrid grid =
      make_grid(DenseArray{.values = values.data(), .size = {4, 5, 6}, .origin = {-3, 8, 1}},
                translation({10, 20, 30}) * scaling({0.5, 0.5, 0.5}));
  grid.name = name;
  return grid;
}

TEST(StatsInfo, SaysWhereGridsLieAndWhatTheyHold) {
  const ScratchFolder folder;
  const VoxelGrid density = small_box("density"), heat = small_box("heat"),
                  warmth = small_box("temperature");
  const std::string file = folder / "a.vdb", fire = folder / "b.vdb", smoke = folder / "c.vdb",
                    twins = folder / "d.vdb";
  formats::write_vdb(file, {&density, &heat});
  formats::write_vdb(fire, {&heat});
  formats::write_vdb(smoke, {&density, &warmth});
  formats::write_vdb(twins, {&density, &density});
  const RunResult r = run_tool(PVOL_STATS, {"info", file, fire, smoke, twins, "--json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const json j = json::parse(r.out);
  ASSERT_EQ(j.size(), 4u);
  EXPECT_EQ(j[0]["file"], file);
  EXPECT_EQ(j[0]["bytes"], std::filesystem::file_size(file));
  ASSERT_EQ(j[0]["grids"].size(), 2u);
  const json& g = j[0]["grids"][0];
  EXPECT_EQ(g["name"], "density");
  EXPECT_EQ(g["type"], "float");
  EXPECT_EQ(g["use"], "density");
  EXPECT_EQ(g["active_voxels"], 120);
  EXPECT_EQ(g["values"], json({0.25, 2.0}));
  EXPECT_EQ(g["voxels"]["first"], json({-3, 8, 1}));
  EXPECT_EQ(g["voxels"]["last"], json({0, 12, 6}));
  EXPECT_EQ(g["world"]["low"], json({8.0, 23.5, 30.0})) << "a voxel wider";
  EXPECT_EQ(g["world"]["high"], json({10.5, 26.5, 33.5}));
  EXPECT_EQ(g["voxel_size"], json({0.5, 0.5, 0.5}));
  EXPECT_EQ(g["rotated"], false);
  EXPECT_EQ(j[0]["grids"][1]["use"], "fire") << "as a render of the file shows it";
  EXPECT_EQ(j[1]["grids"][0]["use"], "density, fire") << "the only grid";
  EXPECT_EQ(j[2]["grids"][1]["use"], "fire, if asked for") << "smoke has temperatures, too";
  EXPECT_EQ(j[3]["grids"][0]["use"], "density") << "the first of two of one name";
  EXPECT_EQ(j[3]["grids"][1]["use"], "");
}

/// Names of files and grids come from anywhere.
TEST(StatsInfo, NamesDoNothingToTerminals) {
  const ScratchFolder folder;
  const VoxelGrid density = small_box("\x1b]0;title\a");
  const std::string file = folder / "\x1b[31m.vdb";
  formats::write_vdb(file, {&density});
  for (const RunResult& r :
       {run_tool(PVOL_STATS, {"info", file}), run_tool(PVOL_STATS, {"bounds", file}),
        run_tool(PVOL_RENDER, {file, "-o", folder / "a.exr", "--size", "4x4", "--spp", "1"})}) {
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_EQ((r.out + r.err).find_first_of("\x1b\a"), std::string::npos) << r.out << r.err;
    EXPECT_NE((r.out + r.err).find("\\x1b[31m.vdb"), std::string::npos);
  }
}

TEST(StatsInfo, GoesOnAfterAFileThatCannotBeRead) {
  const ScratchFolder folder;
  const VoxelGrid density = small_box("density");
  const std::string file = folder / "a.vdb", none = folder / "none.vdb";
  formats::write_vdb(file, {&density});
  const RunResult r = run_tool(PVOL_STATS, {"info", none, file});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "stats.info_no_file"));
  EXPECT_TRUE(says(r.out, "stats.info_head"));
  EXPECT_TRUE(says(r.out, "stats.info_places"));
}

TEST(StatsInfo, OfADamagedFileIsAFailure) {
  const ScratchFolder folder;
  const VoxelGrid density = small_box("density");
  const std::string vdb = folder / "a.vdb", pvol = folder / "a.pvol";
  formats::write_vdb(vdb, {&density});
  ASSERT_EQ(run_tool(PVOL_FIT, {vdb, "-o", pvol, "--density", "reference"}).exit, 0);
  std::filesystem::remove(vdb);
  const RunResult r = run_tool(PVOL_STATS, {"info", pvol});
  EXPECT_EQ(r.exit, 1) << r.out << r.err;
  EXPECT_NE(r.out.find("cannot be read"), std::string::npos) << r.out;
}

}  // namespace stats_test
}  // namespace pvol
