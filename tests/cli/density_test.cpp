// Densities of less precision and stored micro-bounds through the tools.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/cloud.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace density_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

constexpr const char* kRecipe =
    "[recipe]\nresolution = 40\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n"
    "[[modulation]]\namplitude = 0.7\ncell = 0.4\noctaves = 3\ngain = 0.5\nseed = 1\n";

/// A .vdb, and pictures of clouds beside it.
class Density : public ::testing::Test {
 protected:
  Density() : vdb_(folder_ / "a.vdb") {
    std::ofstream(folder_ / "a.toml") << kRecipe;
    expect_success(PVOL_CONVERT, {folder_ / "a.toml", vdb_});
  }

  static RunResult expect_success(const char* tool, const std::vector<std::string>& arguments) {
    RunResult r = run_tool(tool, arguments);
    EXPECT_EQ(r.exit, 0) << r.err;
    return r;
  }
  static void expect_error(int exit, const char* tool, const std::vector<std::string>& arguments,
                           const std::string& key) {
    const RunResult r = run_tool(tool, arguments);
    EXPECT_EQ(r.exit, exit) << r.err;
    EXPECT_TRUE(says(r.err, key));
  }

  json fit(const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {vdb_, "-o", folder_ / name, "--json"});
    return json::parse(expect_success(PVOL_FIT, more).out);
  }

  [[nodiscard]] std::vector<std::string> render(const std::string& cloud, const std::string& image,
                                                std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {cloud, "-o", folder_ / image, "--size", "16x12", "--spp", "64",
                               "--set", "medium.extinction=4"});
    return more;
  }

  json stats(const std::string& cloud, const std::string& image,
             std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--stats", "-", "--quiet"});
    return json::parse(expect_success(PVOL_RENDER, render(cloud, image, more)).out);
  }

  ScratchFolder folder_;
  std::string vdb_;
};

TEST_F(Density, FileAndLoadTimeMakeTheSamePicture) {
  const json exact = stats(vdb_, "exact.png");
  for (const std::string p : {"fp16", "fp8", "fpn"}) {
    const json report = fit(p + ".pvol", {"--density", p});
    const json of_file = stats(folder_ / (p + ".pvol"), p + "_file.png");
    const json of_vdb = stats(vdb_, p + "_vdb.png", {"--density", p});
    EXPECT_EQ(read_text(folder_ / (p + "_file.png")), read_text(folder_ / (p + "_vdb.png"))) << p;
    EXPECT_EQ(of_file["mean_rgb"], of_vdb["mean_rgb"]);
    // Rounding decides a collision among thousands, more often the fewer the bits.
    if (p == "fp8") {
      EXPECT_NE(of_file["mean_rgb"], exact["mean_rgb"]);
    }
    EXPECT_EQ(of_file["options"]["density"], of_vdb["options"]["density"]);
    const json& density = of_file["options"]["density"][0];
    EXPECT_EQ(density["precision"], p);
    EXPECT_EQ(density["absolute_error"], report["density"]["absolute_error"]);
    EXPECT_EQ(density["mass_error"], report["density"]["mass_error"]);
    EXPECT_GT(density["absolute_error"], 0);
    EXPECT_EQ(density.contains("tolerance"), p == "fpn");
  }
}

/// Samples in a mapped file, or copies of them, decide what those of the source do.
TEST_F(Density, MappedSamplesMakeTheSamePicture) {
  const json packed = fit("packed.pvol", {}), plain = fit("plain.pvol", {"--compression", "none"});
  EXPECT_LT(packed["bytes"]["density"], plain["bytes"]["density"]);
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{}, {"--transmittance", "ratio"}}) {
    const json source = stats(vdb_, "source.png", more);
    for (const std::string file : {"packed", "plain"}) {
      const json of_file = stats(folder_ / (file + ".pvol"), file + ".png", more);
      EXPECT_EQ(of_file["mean_rgb"], source["mean_rgb"]) << file;
      EXPECT_EQ(read_text(folder_ / (file + ".png")), read_text(folder_ / "source.png")) << file;
    }
  }
}

TEST_F(Density, PicturesSayThatTheyAreBiased) {
  const auto bias = [&](const std::vector<std::string>& more) {
    expect_success(PVOL_RENDER, render(vdb_, "a.exr", more));
    const std::string exr = read_text(folder_ / "a.exr");
    const auto at = exr.find("pvol:biased");
    const auto value = exr.find_first_of("ny", exr.find("string", at) + 6);
    return exr.substr(value, 40);
  };
  EXPECT_EQ(bias({}).find("no"), 0u);
  EXPECT_EQ(bias({"--density", "fp32"}).find("no"), 0u);
  EXPECT_EQ(bias({"--density", "fp8"}).find("yes: density fp8"), 0u);
  EXPECT_EQ(
      bias({"--density", "fp16", "--max-bounces", "3"}).find("yes: max_bounces, density fp16"), 0u);
  const std::string log =
      expect_success(PVOL_RENDER, render(vdb_, "a.png", {"--density", "fpn"})).err;
  EXPECT_TRUE(says(log, "density.density_fpn_biased"));
}

/// Two values fit into eight bits as they are.
TEST_F(Density, ThatLosesNothingIsNotBiased) {
  std::vector<float> samples(kBrickSamples, 0.25f);
  samples[77] = 0.7f;
  VoxelGrid grid;
  grid.bricks.push_back({{0, 0, 0}, samples.data()});
  formats::write_vdb(vdb_, {&grid});
  EXPECT_EQ(fit("a.pvol", {"--density", "fp8"})["density"]["absolute_error"], 0);
  const RunResult r = expect_success(PVOL_RENDER, render(folder_ / "a.pvol", "a.exr"));
  EXPECT_TRUE(says(r.err, "density.density_fp8_exact"));
  EXPECT_EQ(read_text(folder_ / "a.exr").find("yes: density"), std::string::npos);
}

TEST_F(Density, ToleranceIsKept) {
  const json loose = fit("a.pvol", {"--density", "fpn", "--density-tolerance", "0.1"});
  const json tight = fit("b.pvol", {"--density", "fpn", "--density-tolerance", "0.0001"});
  const double largest = loose["grid"]["largest"];
  EXPECT_LE(loose["density"]["absolute_error"], 0.1 * largest);
  EXPECT_LE(tight["density"]["absolute_error"], 0.0001 * largest);
  EXPECT_LT(loose["bytes"]["density"], tight["bytes"]["density"]);
  expect_success(PVOL_RENDER, render(folder_ / "a.pvol", "a.png",
                                     {"--density", "fpn", "--density-tolerance", "0.1"}));
  expect_error(1, PVOL_RENDER, render(folder_ / "a.pvol", "a.png", {"--density", "fpn"}),
               "density.density_stored_fpn");
}

TEST_F(Density, OfAFileIsNotRoundedTwice) {
  fit("a.pvol", {"--density", "fp8"});
  expect_success(PVOL_RENDER, render(folder_ / "a.pvol", "a.png", {"--density", "fp8"}));
  for (const char* other : {"fp32", "fp16", "fpn"}) {
    expect_error(1, PVOL_RENDER, render(folder_ / "a.pvol", "a.png", {"--density", other}),
                 "density.density_stored_fp8");
  }
}

TEST_F(Density, PrintedScenesKeepIt) {
  const std::vector<std::string> more{"--density", "fpn", "--density-tolerance", "0.2"};
  (void)stats(vdb_, "a.png", more);
  auto arguments = render(vdb_, "b.png", more);
  arguments.push_back("--print-scene");
  std::ofstream(folder_ / "scene.toml") << expect_success(PVOL_RENDER, arguments).out;
  expect_success(PVOL_RENDER, {folder_ / "scene.toml", "-o", folder_ / "b.png"});
  EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "b.png"));
  expect_error(2, PVOL_RENDER, render(vdb_, "c.png", {"--set", "render.density=fp7"}),
               "density.no_precision_fp7");
  expect_error(2, PVOL_RENDER, render(vdb_, "c.png", {"--set", "render.density_tolerance=0.1"}),
               "density.tolerance_without_fpn");
}

TEST_F(Density, MisuseIsRefused) {
  const std::vector<std::string> to{vdb_, "-o", folder_ / "a.pvol"};
  const auto refuse = [&](std::vector<std::string> more, const std::string& part) {
    more.insert(more.begin(), to.begin(), to.end());
    expect_error(2, PVOL_FIT, more, part);
  };
  refuse({"--micro-bounds", "1"}, "density.micro_bounds_bounds");
  refuse({"--micro-bounds", "4"}, "density.micro_bounds_none");
  refuse({"--density", "fp8", "--density-tolerance", "0.1"}, "density.error_density_tolerance");
  refuse({"--density", "fpn", "--density-tolerance", "0"}, "density.density_tolerance_number");
  refuse({"--density", "reference", "--compression", "none"}, "density.compression_of_nothing");
  refuse({"--shell-kind", "soft"}, "density.shell_options_without_shell");
  refuse({"--shell-effort", "7"}, "density.shell_options_without_shell");
  expect_error(2, PVOL_FIT, {folder_ / "a.toml", "-o", folder_ / "a.pvol", "--fields", "heat"},
               "density.fields_of_a_recipe");
  expect_error(2, PVOL_FIT,
               {folder_ / "a.toml", "-o", folder_ / "a.pvol", "--closed-form", "--density", "fp8"},
               "density.closed_form_takes");
  expect_error(
      2, PVOL_FIT,
      {folder_ / "a.toml", "-o", folder_ / "a.pvol", "--closed-form", "--micro-bounds", "2"},
      "density.closed_form_takes");
  expect_error(2, PVOL_RENDER, render(vdb_, "a.png", {"--density", "reference"}),
               "density.density_reference_stored_fp32");
  expect_error(2, PVOL_RENDER, render(vdb_, "a.png", {"--density-tolerance", "0.1"}),
               "density.error_density_tolerance");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.pvol"));
}

TEST_F(Density, ACloudByReferenceIsNotConvertedOntoItsSource) {
  fit("r.pvol", {"--density", "reference"});
  const std::string before = read_text(vdb_);
  expect_error(2, PVOL_CONVERT, {folder_ / "r.pvol", vdb_}, "density.output_is_source");
  EXPECT_TRUE(read_text(vdb_) == before);
  expect_success(PVOL_CONVERT, {folder_ / "r.pvol", folder_ / "other.vdb"});
  expect_success(PVOL_CONVERT, {folder_ / "r.pvol", folder_ / "other.vdb"});
}

// --- micro-bounds -------------------------------------------------------------------------------

TEST_F(Density, StoredMicroBoundsAreUsedAndChangeNoPixel) {
  const json report = fit("micro.pvol", {"--micro-bounds", "2"});
  EXPECT_GT(report["bytes"]["micro"], 0);
  EXPECT_EQ(fit("plain.pvol", {})["bytes"]["micro"], 0);
  const auto from = [&](const std::string& cloud, const std::string& use) {
    const json j = stats(folder_ / cloud, cloud + use + ".png", {"--micro-bounds", use});
    return j["options"]["micro_bounds_from"].get<std::string>();
  };
  EXPECT_EQ(from("micro.pvol", "2"), "2^3 from the file");
  EXPECT_EQ(from("plain.pvol", "2"), "2^3 built at load");
  EXPECT_EQ(from("micro.pvol", "1"), "single voxels, built at load");
  EXPECT_EQ(from("micro.pvol", "none"), "none");
  EXPECT_EQ(from("micro.pvol", "codes"), "codes");
  EXPECT_EQ(from("micro.pvol", "auto"), "codes");
  for (const std::string other :
       {"plain.pvol2", "micro.pvol1", "micro.pvolnone", "micro.pvolcodes"}) {
    EXPECT_EQ(read_text(folder_ / "micro.pvol2.png"), read_text(folder_ / (other + ".png")));
  }
  const std::string log =
      expect_success(PVOL_RENDER, render(folder_ / "micro.pvol", "a.png", {"--micro-bounds", "2"}))
          .err;
  EXPECT_TRUE(says(log, "density.mean_optical_thickness"));
}

TEST_F(Density, StoredMicroBoundsThatDoNotHoldAreRefused) {
  fit("a.pvol", {"--micro-bounds", "2"});
  formats::PvolFile content = formats::read_pvol(folder_ / "a.pvol");
  ASSERT_TRUE(content.micro);
  auto& codes = content.micro->by_leaf.codes;
  ++std::find_if(codes.begin(), codes.end(), [](auto c) { return c.lo < c.hi; })->lo;
  formats::write_pvol(folder_ / "a.pvol", content);
  expect_error(1, PVOL_RENDER, render(folder_ / "a.pvol", "a.png", {"--micro-bounds", "2"}),
               "density.micro_bounds_leaf");
  expect_success(PVOL_RENDER, render(folder_ / "a.pvol", "a.png", {"--micro-bounds", "none"}));
}

TEST_F(Density, MicroBoundsGoWithEveryPrecision) {
  for (const std::string p : {"fp16", "fp8", "fpn", "reference"}) {
    fit("a.pvol", {"--density", p, "--micro-bounds", "2"});
    const json j = stats(folder_ / "a.pvol", "a.png", {"--micro-bounds", "2"});
    EXPECT_EQ(j["options"]["micro_bounds_from"], "2^3 from the file") << p;
  }
  // Rounded at load, the density is another one, and so are its micro-bounds.
  const json j = stats(folder_ / "a.pvol", "b.png", {"--micro-bounds", "2", "--density", "fp8"});
  EXPECT_EQ(j["options"]["micro_bounds_from"], "2^3 built at load");
}

}  // namespace density_test
}  // namespace pvol
