// Files with several grids, from fit to picture: what is bound, told, stored and shown.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace fire_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;
using testing::operator+;

/// 24^3 samples of value(p) in voxels of 0.1, under a name.
VoxelGrid grid_of(const char* name, const std::function<double(Vec3d)>& value) {
  std::vector<float> samples;
  for (int x = 0; x < 24; ++x) {
    for (int y = 0; y < 24; ++y) {
      for (int z = 0; z < 24; ++z)
        samples.push_back(float(std::max(0.0, value({double(x), double(y), double(z)}))));
    }
  }
  VoxelGrid g = make_grid({.values = samples.data(), .size = {24, 24, 24}}, scaling(Vec3d(0.1)));
  g.name = name;
  return g;
}

class FireFiles : public ::testing::Test {
 protected:
  FireFiles() {
    const auto ball = [](Vec3d centre, double radius) {
      return [=](Vec3d p) { return 1 - length(p - centre) / radius; };
    };
    const VoxelGrid smoke = grid_of("density", ball({14, 14, 12}, 8));
    const VoxelGrid flames = grid_of("flames", ball({9, 6, 12}, 6));
    const VoxelGrid heat = grid_of("temperature", [=](Vec3d p) {
      return 1.2 * ball({9, 8, 12}, 9)(p);
    });
    formats::write_vdb(folder_ / "all.vdb", {&smoke, &flames, &heat});
    formats::write_vdb(folder_ / "fire.vdb", {&flames, &heat});
  }

  RunResult run(const char* tool, std::vector<std::string> arguments, int exit = 0) {
    RunResult r = run_tool(tool, arguments);
    EXPECT_EQ(r.exit, exit) << r.err;
    return r;
  }

  /// A small picture; returns the log.
  std::string render(const std::string& input, const std::string& output,
                     std::vector<std::string> more = {}) {
    std::vector<std::string> all{folder_ / input, "-o", folder_ / output, "--size", "32x24",
                                 "--spp",         "16"};
    all.insert(all.end(), more.begin(), more.end());
    return run(PVOL_RENDER, all).err;
  }

  [[nodiscard]] Vec3d mean_of(const std::string& picture) const {
    const Film film = formats::read_film(folder_ / picture).film;
    Vec3d sum;
    for (const PixelSums& p : film.pixels) sum += mean(p) / double(film.pixels.size());
    return sum;
  }

  ScratchFolder folder_;
};

TEST_F(FireFiles, WithoutDensityIsAFireByNight) {
  const std::string log = render("fire.vdb", "a.exr");
  for (const char* key :
       {"fire.no_grid_called_density", "fire.fire_uses_grid", "fire.colour_uses_grid",
        "fire.kelvin_change_set", "fire.no_intensity_set", "fire.fire_without_smoke"}) {
    EXPECT_TRUE(says(log, key));
  }
  const Vec3d mean = mean_of("a.exr");
  EXPECT_GT(mean.x, 0.001);
  EXPECT_GT(mean.x, 2 * mean.z) << "of the colour of flames";
  render("fire.vdb", "none.exr", {"--grid", "none"});
  EXPECT_EQ(mean_of("none.exr"), mean) << "the same, said";
  // What the log advises changes the fire, and not the night around it.
  render("fire.vdb", "other.exr", {"--set", "medium.fire.intensity=1e-9"});
  EXPECT_LT(mean_of("other.exr").z, 1e-3 * mean.z);
  // The scene that made it, printed, makes it again.
  const std::string scene = run(PVOL_RENDER, {folder_ / "fire.vdb", "-o", folder_ / "b.exr",
                                              "--print-scene", "--size", "32x24", "--spp", "16"})
                                .out;
  EXPECT_NE(scene.find("grid = \"none\""), std::string::npos) << scene;
  std::ofstream(folder_ / "again.toml") << scene;
  run(PVOL_RENDER, {folder_ / "again.toml", "-o", folder_ / "b.exr"});
  EXPECT_EQ(mean_of("b.exr"), mean);
}

/// Frames of a fire share what is chosen for it, whatever else the scene says.
TEST_F(FireFiles, FramesShareColourAndIntensity) {
  const VoxelGrid flames = grid_of("flames", [](Vec3d p) { return 6 - length(p - Vec3d(12)); });
  const VoxelGrid heat = grid_of("temperature", [](Vec3d) { return 0.4; });
  formats::write_vdb(folder_ / "f.0002.vdb", {&flames, &heat});
  std::filesystem::copy(folder_ / "fire.vdb", folder_ / "f.0001.vdb");
  const auto chosen = [&](int frame) {
    const auto file = folder_ / fmt::format("f.{:04}.exr", frame);
    std::istringstream scene(formats::read_picture_header(file).attributes.at("pvol:scene"));
    std::string lines;
    for (std::string line; std::getline(scene, line);) {
      const bool asked = line.starts_with("kelvin") || line.starts_with("intensity");
      if (asked) lines += line + '\n';
    }
    return lines;
  };
  const std::vector<std::string> camera{"--set", "camera.position=[1.2,1.2,9]", "--set",
                                        "camera.target=[1.2,1.2,1.2]"};
  std::vector<std::string> intensity = camera;
  intensity.insert(intensity.end(), {"--set", "medium.fire.intensity=3"});
  for (const auto& given : {std::vector<std::string>{}, camera, intensity}) {
    std::vector<std::string> more{"--frames", "1-2", "--no-resume"};
    more.insert(more.end(), given.begin(), given.end());
    const std::string log = render("f.####.vdb", "f.####.exr", more);
    EXPECT_TRUE(says(log, given == intensity ? "fire.colour_for_all_frames"
                          : given == camera  ? "fire.colour_and_intensity_for_all_frames"
                                             : "fire.all_for_all_frames"));
    EXPECT_NE(chosen(1), "");
    EXPECT_EQ(chosen(1), chosen(2));
  }
}

/// A shot that starts to burn: files of smoke alone, and then of smoke and flames.
class FireThatStarts : public FireFiles {
 protected:
  FireThatStarts() {
    const VoxelGrid smoke = grid_of("density", [](Vec3d p) { return 6 - length(p - Vec3d(12)); });
    formats::write_vdb(folder_ / "f.0001.vdb", {&smoke});
    std::filesystem::copy(folder_ / "all.vdb", folder_ / "f.0002.vdb");
  }

  /// Renders the shot in small; returns the log.
  std::string render_shot(const Words& more, int exit = 0) {
    const Words all{folder_ / "f.####.vdb", "-o", folder_ / "f.####.exr"};
    return run(PVOL_RENDER, all + Words{"--size", "32x24", "--spp", "16"} + more, exit).err;
  }

  /// The scene in the header of a frame's picture, without its seed and the name of its cloud.
  [[nodiscard]] std::string scene_of(int frame) const {
    const auto file = folder_ / fmt::format("f.{:04}.exr", frame);
    std::istringstream scene(formats::read_picture_header(file).attributes.at("pvol:scene"));
    std::string kept;
    for (std::string line; std::getline(scene, line);) {
      if (!line.starts_with("seed") && !line.starts_with("file")) kept += line + '\n';
    }
    return kept;
  }
  /// The scene of a frame, for all frames.
  void write_scene(int frame, const std::string& from, const std::string& to) {
    std::string scene =
        run(PVOL_RENDER, {folder_ / "f.####.vdb", "-o", folder_ / "f.####.exr", "--frames",
                          std::to_string(frame), "--print-scene", "--size", "32x24", "--spp", "16"})
            .out;
    scene.replace(scene.find("f.0002.vdb"), 10, "f.####.vdb");
    const std::size_t at = scene.find(from);
    ASSERT_NE(at, scene.npos) << scene;
    std::ofstream(folder_ / "shot.toml") << scene.replace(at, from.size(), to);
  }
};

TEST_F(FireThatStarts, HasOneLookInAllFrames) {
  EXPECT_TRUE(says(render_shot({"--frames", "1-2"}, 1), "fire.frame_does_not_burn"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "f.0001.exr"));
  const Words all{"--frames", "1-2", "--lock-frame", "2"};
  render_shot(all);
  // The smoke before it burns is lit as that beside the fire.
  std::string burning = scene_of(2);
  const std::size_t fire = burning.find("[medium.fire]");
  ASSERT_NE(fire, burning.npos) << burning;
  burning.erase(fire, burning.find("\n\n", fire) + 2 - fire);
  EXPECT_EQ(scene_of(1), burning);
  const Vec3d first = mean_of("f.0001.exr"), second = mean_of("f.0002.exr");
  EXPECT_GT(second.x, 2 * first.x);
  EXPECT_LT(first.x, first.z) << "in the light of dusk";
  // A task of a farm makes the same picture.
  render_shot(all + Words{"--frame", "1", "--no-resume"});
  EXPECT_EQ(mean_of("f.0001.exr"), first);
}

TEST_F(FireThatStarts, IsOutWhereAFileOfTheSceneHasNoGridForIt) {
  write_scene(2, "intensity", "intensity");
  const std::string log = render("shot.toml", "f.####.exr", {"--frames", "1-2"});
  EXPECT_TRUE(says(log, "fire.out"));
  EXPECT_EQ(log.find("f.0002.vdb: the file has no grid"), log.npos) << log;
  EXPECT_GT(mean_of("f.0002.exr").x, 2 * mean_of("f.0001.exr").x);
  EXPECT_TRUE(
      says(render("shot.toml", "f.####.exr", {"--frames", "1-2", "--frame", "1"}), "fire.out"));
  // Whatever part of the shot is asked for.
  for (const std::vector<std::string>& part :
       {std::vector<std::string>{"--frame", "1", "--lock-frame", "2"},
        {"--frames", "1-1", "--lock-frame", "2"}}) {
    EXPECT_TRUE(says(render("shot.toml", "f.####.exr", part), "fire.out")) << part[0];
  }
  run(PVOL_RENDER,
      {folder_ / "shot.toml", "-o", folder_ / "f.####.exr", "--frames", "1-2", "--split", "2"});
  // A name that no frame has is wrong.
  write_scene(2, "field = \"flames\"", "field = \"flame_\"");
  const RunResult r =
      run(PVOL_RENDER, {folder_ / "shot.toml", "-o", folder_ / "g.####.exr", "--frames", "1-2"}, 1);
  EXPECT_TRUE(says(r.err, "fire.no_field_in_any_frame"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "g.0001.exr"));
}

/// Smoke is there in frames of smoke, whatever the frame has whose choices they share.
TEST_F(FireThatStarts, KeepsItsSmokeWhereTheReferenceHasNone) {
  std::filesystem::copy(folder_ / "fire.vdb", folder_ / "f.0003.vdb");
  const Words all{"--frames", "1-3", "--lock-frame", "3"};
  EXPECT_TRUE(says(render_shot(all, 1), "fire.no_density_to_choose_for"));
  render_shot(all + Words{"--set", "medium.extinction=14"});
  for (const int frame : {1, 2}) {
    const Film film = formats::read_film(folder_ / fmt::format("f.{:04}.exr", frame)).film;
    double alpha = 0;
    for (const PixelSums& p : film.pixels) alpha += p.alpha / (16 * double(film.pixels.size()));
    EXPECT_GT(alpha, 0.02) << "frame " << frame;
  }
}

/// Grids of a fire that are 0 everywhere give no more to choose by than none.
TEST_F(FireThatStarts, IsNotChosenForAFrameWithoutLight) {
  const VoxelGrid smoke = grid_of("density", [](Vec3d p) { return 6 - length(p - Vec3d(12)); });
  const VoxelGrid flames = grid_of("flames", [](Vec3d) { return 0.0; });
  const VoxelGrid heat = grid_of("temperature", [](Vec3d) { return 0.0; });
  formats::write_vdb(folder_ / "f.0001.vdb", {&smoke, &flames, &heat});
  EXPECT_TRUE(says(render_shot({"--frames", "1-2"}, 1), "fire.frame_does_not_burn_itself"));
  render_shot({"--frames", "1-2", "--lock-frame", "2"});
  EXPECT_NE(scene_of(1).find("[medium.fire]"), std::string::npos);
}

TEST_F(FireFiles, WithDensityBurnsInItsSmoke) {
  const std::string log = render("all.vdb", "a.exr");
  for (const char* key : {"fire.burns", "fire.fire_uses_grid_all", "fire.kelvin_change_set",
                          "fire.no_intensity_set", "tools.extinction_chosen"}) {
    EXPECT_TRUE(says(log, key)) << key;
  }
  const Vec3d mean = mean_of("a.exr");
  EXPECT_GT(mean.x, 2 * mean.z) << "of the colour of flames";
  EXPECT_GT(mean.z, 0.01) << "in the light of dusk";
  // What the log advises changes the brightness and not the colour.
  render("all.vdb", "dim.exr", {"--set", "medium.fire.intensity=1e-3"});
  EXPECT_LT(mean_of("dim.exr").x, mean_of("dim.exr").z);
  // The scene that made it, printed, makes it again.
  std::ofstream(folder_ / "again.toml")
      << run(PVOL_RENDER, {folder_ / "all.vdb", "-o", folder_ / "b.exr", "--print-scene", "--size",
                           "32x24", "--spp", "16"})
             .out;
  run(PVOL_RENDER, {folder_ / "again.toml", "-o", folder_ / "b.exr"});
  EXPECT_EQ(mean_of("b.exr"), mean);
}

TEST_F(FireFiles, AreSmokeByDayWhereTheGridIsNamed) {
  const std::string log = render("all.vdb", "a.exr", {"--grid", "density"});
  EXPECT_EQ(log.find("fire"), std::string::npos) << log;
  const Vec3d day = mean_of("a.exr");
  EXPECT_GT(day.z, day.x) << "under a blue sky";
  EXPECT_GT(day.z, 0.1);
}

/// Temperatures drive smoke as well: they are no flames.
TEST_F(FireFiles, SmokeWithATemperatureIsSmoke) {
  const VoxelGrid smoke = formats::load_grid(folder_ / "all.vdb", {"density"}).grid;
  const VoxelGrid heat = formats::load_grid(folder_ / "all.vdb", {"temperature"}).grid;
  formats::write_vdb(folder_ / "warm.vdb", {&smoke, &heat});
  EXPECT_TRUE(says(render("warm.vdb", "a.exr"), "fire.temperature"));
  EXPECT_GT(mean_of("a.exr").z, mean_of("a.exr").x);
}

TEST_F(FireFiles, ScenesTellOfTheGridsThatCouldBurn) {
  std::ofstream(folder_ / "smoke.toml") << "[volume]\nfile = \"all.vdb\"\n";
  const std::string log = render("smoke.toml", "a.exr");
  EXPECT_TRUE(says(log, "fire.flames_temperature"));
  const std::vector<std::string> night{
      "--set", "environment.type=constant", "--set", "environment.radiance=0",
      "--set", "sun.irradiance=0",          "--set", "medium.extinction=3"};
  render("smoke.toml", "dark.exr", night);
  EXPECT_EQ(mean_of("dark.exr"), Vec3d{});
  std::vector<std::string> lit = night;
  lit.insert(lit.end(), {"--set", "medium.fire.kelvin=1800", "--set", "medium.fire.intensity=5"});
  render("smoke.toml", "lit.exr", lit);
  const Vec3d once = mean_of("lit.exr");
  EXPECT_GT(once.x, once.z);
  lit.back() = "medium.fire.intensity=10";
  render("smoke.toml", "lit.exr", lit);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean_of("lit.exr")[c], 2 * once[c], 1e-4 * once[c]);
}

TEST_F(FireFiles, TheLogSaysHowTheirLightIsGathered) {
  const auto log_of = [&](const char* field, const char* lines) {
    return render("all.vdb", "a.exr",
                  {"--set", std::string("medium.fire.field=") + field, "--set",
                   "medium.fire.intensity=2", "--line-emission", lines});
  };
  EXPECT_TRUE(says(log_of("density", "auto"), "fire.emission_at_collisions"));
  EXPECT_TRUE(says(log_of("flames", "auto"), "fire.emission_beside_smoke"));
  EXPECT_TRUE(says(log_of("density", "on"), "fire.emission_along_flights"));
}

TEST_F(FireFiles, FitKeepsTheGridsThatFiresGoBy) {
  const json fit =
      json::parse(run(PVOL_FIT, {folder_ / "all.vdb", "-o", folder_ / "all.pvol", "--json"}).out);
  ASSERT_EQ(fit["fields"].size(), 2u);
  EXPECT_EQ(fit["fields"][0]["name"], "flames");
  EXPECT_EQ(fit["fields"][1]["name"], "temperature");
  EXPECT_GT(fit["bytes"]["fields"], 0);
  const std::vector<std::string> fire{"--set", "medium.extinction=3",
                                      "--set", "medium.fire.kelvin=1800",
                                      "--set", "medium.fire.intensity=5"};
  render("all.vdb", "vdb.exr", fire);
  render("all.pvol", "pvol.exr", fire);
  EXPECT_EQ(mean_of("vdb.exr"), mean_of("pvol.exr"));
  run(PVOL_FIT, {folder_ / "fire.vdb", "-o", folder_ / "fire.pvol"});
  render("fire.vdb", "vdb.exr");
  render("fire.pvol", "pvol.exr");
  EXPECT_EQ(mean_of("vdb.exr"), mean_of("pvol.exr"));
}

TEST_F(FireFiles, FitKeepsTheGridsThatAreAskedFor) {
  const auto fields = [&](const char* what) {
    const json fit = json::parse(
        run(PVOL_FIT, {folder_ / "all.vdb", "-o", folder_ / "a.pvol", "--json", "--fields", what})
            .out);
    return fit["fields"].size();
  };
  EXPECT_EQ(fields("none"), 0u);
  EXPECT_EQ(fields("all"), 2u);
  EXPECT_EQ(fields("temperature"), 1u);
  const RunResult r =
      run(PVOL_FIT, {folder_ / "all.vdb", "-o", folder_ / "b.pvol", "--fields", "heat"}, 1);
  EXPECT_TRUE(says(r.err, "fire.no_grid_called"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.pvol"));
}

TEST_F(FireFiles, BoundsAreReportedAndVerifiedByField) {
  run(PVOL_FIT, {folder_ / "all.vdb", "-o", folder_ / "all.pvol"});
  const json all =
      json::parse(run(PVOL_STATS, {"bounds", folder_ / "all.pvol", "--verify", "--json"}).out);
  ASSERT_EQ(all["fields"].size(), 2u);
  EXPECT_EQ(all["fields"][0]["name"], "flames");
  EXPECT_EQ(all["fields"][0]["verified"], true);
  EXPECT_GT(all["fields"][0]["majorant_over_mean"], 1);
  const std::string text = run(PVOL_STATS, {"bounds", folder_ / "all.pvol", "--verify"}).out;
  EXPECT_NE(text.find("temperature"), std::string::npos) << text;
  const json one = json::parse(
      run(PVOL_STATS, {"bounds", folder_ / "all.pvol", "--grid", "flames", "--json"}).out);
  EXPECT_EQ(one["grid"], "flames");
}

TEST_F(FireFiles, ConvertTakesAField) {
  run(PVOL_FIT, {folder_ / "all.vdb", "-o", folder_ / "all.pvol"});
  run(PVOL_CONVERT, {folder_ / "all.pvol", folder_ / "flames.vdb", "--grid", "flames"});
  const auto grids = formats::grids_of(folder_ / "flames.vdb");
  ASSERT_EQ(grids.size(), 1u);
  EXPECT_EQ(grids[0].name, "flames");
  const VoxelGrid a = formats::load_grid(folder_ / "all.vdb", {"flames"}).grid;
  const VoxelGrid b = formats::load_grid(folder_ / "flames.vdb").grid;
  for (int x = 0; x < 24; ++x) {
    for (int y = 0; y < 24; ++y) EXPECT_EQ(sample(a, {x, y, 12}), sample(b, {x, y, 12}));
  }
}

TEST_F(FireFiles, ConvertTakesAllGridsOfAFile) {
  const auto names = [&](const char* input) {
    run(PVOL_FIT, {folder_ / input, "-o", folder_ / "a.pvol"});
    run(PVOL_CONVERT, {folder_ / "a.pvol", folder_ / "back.vdb"});
    std::vector<std::string> all;
    for (const auto& g : formats::grids_of(folder_ / "back.vdb")) all.push_back(g.name);
    return all;
  };
  EXPECT_EQ(names("all.vdb"), (std::vector<std::string>{"density", "flames", "temperature"}));
  EXPECT_EQ(names("fire.vdb"), (std::vector<std::string>{"flames", "temperature"}));
}

TEST_F(FireFiles, RampsCutThinSmokeAway) {
  const auto alpha = [&](const std::string& picture) {
    const Film film = formats::read_film(folder_ / picture).film;
    double sum = 0;
    for (const PixelSums& p : film.pixels) sum += double(p.alpha) / p.samples;
    return sum;
  };
  const std::vector<std::string> thick{"--grid",       "density", "--set", "medium.extinction=200",
                                       "--background", "off"};
  render("all.vdb", "whole.exr", thick);
  std::vector<std::string> cut = thick;
  cut.insert(cut.end(), {"--set", "medium.density.ramp=[[0,0],[0.5,0],[1,1]]"});
  render("all.vdb", "cut.exr", cut);
  // Radius 8 becomes 4: about a quarter of the area.
  EXPECT_LT(alpha("cut.exr"), 0.4 * alpha("whole.exr"));
  EXPECT_GT(alpha("cut.exr"), 0.1 * alpha("whole.exr"));
}

}  // namespace fire_test
}  // namespace pvol
