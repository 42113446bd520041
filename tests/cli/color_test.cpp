// Clouds with colours, from fit to picture: what is bound, told, stored and shown.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/image.h"
#include "support/colors.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace color_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

class ColorFiles : public ::testing::Test {
 protected:
  ColorFiles() {
    std::vector<float> samples;
    const auto ball = [](Vec3i p) { return 1 - length(Vec3d(p) - Vec3d(12.0)) / 11; };
    for (int x = 0; x < 24; ++x) {
      for (int y = 0; y < 24; ++y) {
        for (int z = 0; z < 24; ++z) samples.push_back(float(std::max(0.0, ball({x, y, z}))));
      }
    }
    const Affine map = scaling(Vec3d(0.1));
    const VoxelGrid smoke = make_grid({.values = samples.data(), .size = Vec3i(24)}, map);
    // Red to the right, green to the left, black below.
    const ColorGrid colors = test::make_colors(
        {0, 0, 0}, Vec3i(24),
        [&](Vec3i p) -> std::optional<Rgb> {
          if (!(ball(p) > 0)) return std::nullopt;
          if (p.y < 6) return Rgb(0.0f);
          return Rgb(float(p.x) / 24, float(24 - p.x) / 24, 0.125f);
        },
        map);
    formats::write_vdb(folder_ / "smoke.vdb", {&smoke}, {&colors});
  }

  RunResult run(const char* tool, std::vector<std::string> arguments, int exit = 0) {
    RunResult r = run_tool(tool, arguments);
    EXPECT_EQ(r.exit, exit) << r.err;
    return r;
  }

  /// A small picture; returns the log.
  std::string render(const std::string& input, const std::string& output,
                     std::vector<std::string> more = {}) {
    std::vector<std::string> all{
        folder_ / input,       "-o", folder_ / output, "--size", "32x24", "--spp", "16", "--set",
        "medium.extinction=20"};
    all.insert(all.end(), more.begin(), more.end());
    return run(PVOL_RENDER, all).err;
  }

  [[nodiscard]] Film film(const std::string& picture) const {
    return formats::read_film(folder_ / picture).film;
  }

  /// Of all pixels' channels.
  [[nodiscard]] double largest_difference(const std::string& a, const std::string& b) const {
    const Film one = film(a), other = film(b);
    double most = 0;
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      const Vec3d d = mean(one.pixels[i]) - mean(other.pixels[i]);
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(d[c]));
    }
    return most;
  }

  ScratchFolder folder_;
};

constexpr const char* kNone = "medium.albedo_field.grid=none";

TEST_F(ColorFiles, AreBoundAndTold) {
  const std::string log = render("smoke.vdb", "a.exr");
  EXPECT_TRUE(says(log, "albedo.albedo_uses_colours_grid"));
  const std::string without = render("smoke.vdb", "grey.exr", {"--set", kNone});
  EXPECT_EQ(times_said(without, "albedo.albedo_uses_colours_grid"), 0);
  EXPECT_GT(largest_difference("a.exr", "grey.exr"), 0.1);
  // A grid that is named is bound beside its colours all the same.
  render("smoke.vdb", "named.exr", {"--set", "volume.grid=density"});
  EXPECT_EQ(largest_difference("a.exr", "named.exr"), 0);
  // The scene that made it, printed, makes it again.
  const std::string scene =
      run(PVOL_RENDER, {folder_ / "smoke.vdb", "-o", folder_ / "b.exr", "--print-scene", "--size",
                        "32x24", "--spp", "16", "--set", "medium.extinction=20"})
          .out;
  EXPECT_NE(scene.find("[medium.albedo_field]\ngrid = \"Cd\""), std::string::npos) << scene;
  std::ofstream(folder_ / "again.toml") << scene;
  run(PVOL_RENDER, {folder_ / "again.toml", "-o", folder_ / "b.exr"});
  EXPECT_EQ(largest_difference("a.exr", "b.exr"), 0);
}

TEST_F(ColorFiles, FitKeepsThem) {
  render("smoke.vdb", "vdb.exr");
  for (const auto& [precision, most] :
       {std::pair{"fp32", 0.0}, std::pair{"reference", 0.0}, std::pair{"fp16", 0.05}}) {
    const json fit = json::parse(run(PVOL_FIT, {folder_ / "smoke.vdb", "-o", folder_ / "s.pvol",
                                                "--json", "--density", precision})
                                     .out);
    ASSERT_EQ(fit["fields"].size(), 4u);
    EXPECT_EQ(fit["fields"][0]["name"], "Cd.x");
    EXPECT_EQ(fit["fields"][3]["name"], "Cd.black");
    const std::string log = render("s.pvol", "pvol.exr");
    EXPECT_TRUE(says(log, "albedo.albedo_uses_colours"));
    EXPECT_LE(largest_difference("vdb.exr", "pvol.exr"), most) << precision;
  }
  // Rounded samples of 8 bits: other flights, and the same light on average.
  run(PVOL_FIT, {folder_ / "smoke.vdb", "-o", folder_ / "s.pvol", "--density", "fp8"});
  render("s.pvol", "pvol.exr");
  const auto sum = [&](const char* picture) {
    Vec3d all;
    for (const PixelSums& p : film(picture).pixels) all += mean(p);
    return all;
  };
  const Vec3d a = sum("vdb.exr"), b = sum("pvol.exr");
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(b[c] / a[c], 1, 0.02) << c;
  const json none = json::parse(
      run(PVOL_FIT, {folder_ / "smoke.vdb", "-o", folder_ / "n.pvol", "--json", "--fields", "none"})
          .out);
  EXPECT_EQ(none["fields"].size(), 0u);
}

// Velocities by three grids are one field, not four, and of grids of one name there is one.
TEST_F(ColorFiles, FitKeepsAllFieldsOnce) {
  const std::vector<float> ones(512, 1.0f);
  std::vector<VoxelGrid> grids;
  for (const char* name : {"density", "vel.x", "vel.y", "vel.z", "density", "heat"}) {
    grids.push_back(make_grid({.values = ones.data(), .size = Vec3i(8)}));
    grids.back().name = name;
  }
  std::vector<const VoxelGrid*> all;
  for (const VoxelGrid& g : grids) all.push_back(&g);
  formats::write_vdb(folder_ / "all.vdb", all);
  const RunResult r = run(PVOL_FIT, {folder_ / "all.vdb", "--grid", "density[0]", "-o",
                                     folder_ / "all.pvol", "--json", "--fields", "all"});
  EXPECT_TRUE(says(r.err, "grids.further_of_a_name")) << r.err;
  std::vector<std::string> names;
  const json report = json::parse(r.out);
  for (const json& f : report["fields"]) {
    names.push_back(f["name"]);
    EXPECT_EQ(f["active_voxels"], 512) << names.back();
  }
  EXPECT_EQ(names, (std::vector<std::string>{"heat", "vel.x+", "vel.y+", "vel.z+"}));
}

TEST_F(ColorFiles, ConvertGivesThemBack) {
  run(PVOL_FIT, {folder_ / "smoke.vdb", "-o", folder_ / "s.pvol", "--fields", "Cd"});
  const RunResult r = run(PVOL_CONVERT, {folder_ / "s.pvol", folder_ / "back.vdb"});
  EXPECT_TRUE(says(r.out, "albedo.wrote_back_vdb"));
  const auto grids = formats::grids_of(folder_ / "back.vdb");
  ASSERT_EQ(grids.size(), 2u);
  EXPECT_EQ(grids[1].type, "vec3s");
  render("smoke.vdb", "a.exr");
  render("back.vdb", "b.exr");
  EXPECT_EQ(largest_difference("a.exr", "b.exr"), 0);
}

TEST_F(ColorFiles, NumbersGoByARamp) {
  const std::vector<std::string> ramp{
      "--set", "medium.albedo_field.grid=density", "--set",
      "medium.albedo_field.colors=[[0, 0, 1, 0.5], [0.5, 0, 1, 0.5]]"};
  render("smoke.vdb", "ramp.exr", ramp);
  // That ramp is a constant.
  render("smoke.vdb", "constant.exr",
         {"--set", kNone, "--set", "medium.albedo=[0, 0.999, 0.4995]"});
  EXPECT_LT(largest_difference("ramp.exr", "constant.exr"), 1e-6);
  const std::string refused =
      run(PVOL_RENDER,
          {folder_ / "smoke.vdb", "-o", folder_ / "x.exr", "--set", "medium.albedo_field.power=2"},
          1)
          .err;
  EXPECT_TRUE(says(refused, "albedo.grid_cd_colours"));
}

TEST_F(ColorFiles, BoundsAreReportedByChannel) {
  run(PVOL_FIT, {folder_ / "smoke.vdb", "-o", folder_ / "s.pvol"});
  const json all =
      json::parse(run(PVOL_STATS, {"bounds", folder_ / "s.pvol", "--verify", "--json"}).out);
  ASSERT_EQ(all["fields"].size(), 4u);
  EXPECT_EQ(all["fields"][2]["name"], "Cd.z");
  EXPECT_EQ(all["fields"][2]["verified"], true);
}

}  // namespace color_test
}  // namespace pvol
