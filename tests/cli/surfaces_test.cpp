// Scenes with surfaces from the command line: samples, catchers, holdouts and what goes wrong.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace surfaces_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

class SurfaceScenes : public ::testing::Test {
 protected:
  RunResult render(const std::string& input, std::vector<std::string> more, int exit = 0) {
    std::vector<std::string> all{
        input, "-o",      folder_ / "a.exr", "--size",           "32x24", "--spp",
        "16",  "--quiet", "--stats",         folder_ / "a.json", "--set", "render.guide=off"};
    all.insert(all.end(), more.begin(), more.end());
    RunResult r = run_tool(PVOL_RENDER, all);
    EXPECT_EQ(r.exit, exit) << r.err;
    return r;
  }
  json stats() { return json::parse(read_text(folder_ / "a.json")); }
  Film film() { return formats::read_film(folder_ / "a.exr").film; }
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// A sample among copies of all, whose recipes have no more than 64 samples along an axis.
  std::string sample(const std::string& name) {
    const std::filesystem::path copies = folder_ / "samples";
    if (std::filesystem::create_directory(copies)) {
      for (const auto& file : std::filesystem::directory_iterator(PVOL_SAMPLES)) {
        if (file.path().extension() != ".toml" && file.path().extension() != ".obj") continue;
        std::ofstream(copies / file.path().filename()) << std::regex_replace(
            read_text(file.path()), std::regex("resolution = [0-9]+"), "resolution = 64");
      }
    }
    return copies / name;
  }

  ScratchFolder folder_;
  const std::string ground_ = sample("ground.toml");
};

TEST_F(SurfaceScenes, SamplesMeetTheirSurfaces) {
  for (const char* name : {"ground.toml", "solid_in_cloud.toml"}) {
    (void)render(sample(name), {});
    const json j = stats();
    EXPECT_GT(j["surface_hits"], 32 * 24 * 16 / 2) << name;
    EXPECT_GT(j["collisions"], 1000) << name;
    EXPECT_EQ(j["options"]["biased"], "no");
  }
}

TEST_F(SurfaceScenes, ShadowsAndHolesHaveTheirAlpha) {
  (void)render(ground_, {"--background", "off", "--set", "plane.look=shadow-catcher", "--set",
                         "mesh.look=holdout", "--filter", "box"});
  const Film f = film();
  const auto alpha = [&](double x, double y) {
    const PixelSums& p = f.at(int(x * 32), int(y * 24));
    return p.alpha / p.samples;
  };
  EXPECT_GT(alpha(0.5, 0.25), 0.95) << "the cloud";
  EXPECT_GT(alpha(0.72, 0.6), 0.5) << "its shadow";
  EXPECT_LT(std::abs(alpha(0.1, 0.2)), 0.25) << "the ground in the sun";
  EXPECT_EQ(alpha(0.5, 0.9), 0) << "the cube";
}

TEST_F(SurfaceScenes, APlaneIsAddedToACloudAlone) {
  (void)render(sample("cumulus.toml"), {"--set", "plane=[{point=[0,-0.3,0],albedo=0.2}]"});
  EXPECT_GT(stats()["surface_hits"], 1000);
}

TEST_F(SurfaceScenes, WhatGoesWrongIsToldWithItsFile) {
  const auto expect_error = [&](std::vector<std::string> sets, int exit, const std::string& key) {
    std::vector<std::string> more;
    for (const std::string& set : sets) more.insert(more.end(), {"--set", set});
    const std::string err = render(ground_, more, exit).err;
    EXPECT_TRUE(says(err, key));
    EXPECT_EQ(err.find("terminate"), std::string::npos) << err;
  };
  expect_error({"mesh.file=" + write("empty.obj", "v 0 0 0\n")}, 1, "surfaces.vertices_no_face");
  expect_error({"mesh.file=" + (folder_ / "none.ply")}, 1, "surfaces.open_none_ply");
  expect_error({"mesh.file=" + write("a.stl", "solid a\n")}, 1, "surfaces.meshes_read_obj");
  const std::string flow =
      "[recipe]\n[[form]]\nshape = \"half-space\"\npoint = [0, 0, 0]\n"
      "inward = [0, 1, 0]\n[[cut]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\n"
      "radii = 1\n";
  expect_error(
      {"solid=[{file=\"" +
       write("nested.toml",
             flow + "[[cut.perturbation]]\nshape = \"ellipsoid\"\ncentre = [0, 1, 0]\nradii = 0.3\n"
                    "strength = 0.2\n[[cut.perturbation.perturbation]]\nshape = \"ellipsoid\"\n"
                    "centre = [0, 1, 0]\nradii = 0.1\nstrength = 1\n") +
       "\"}]"},
      1, "surfaces.solid_perturbation_itself_perturbed");
  expect_error({"plane.albedo=1.5"}, 2, "surfaces.set_plane_albedo_1_5");
  (void)render(ground_, {"--set", "solid=[{file=\"" + write("half.toml", flow) + "\"}]"});
}

TEST_F(SurfaceScenes, FilesThatAreMissingAreToldWithWhereTheSceneNamesThem) {
  const std::string ball = sample("cumulus.toml");
  const auto fault = [&](const std::string& text) {
    const std::string scene = write("shot.toml", text);
    return render(scene, {}, 1).err;
  };
  const std::string volume = "[volume]\nfile = \"" + ball + "\"\n[[mesh]]\n";
  EXPECT_TRUE(says(fault("[volume]\nfile = \"none.vdb\"\n"), "surfaces.place_of_volume"));
  EXPECT_TRUE(says(fault(volume + "file = \"none.ply\"\n"), "surfaces.place_of_mesh"));
  EXPECT_TRUE(says(fault(volume + "file = \"" + folder_.path().string() + "\"\n"),
                   "surfaces.place_of_folder"));
  EXPECT_TRUE(
      says(run_tool(PVOL_STATS, {"trade", folder_ / "shot.toml"}).err, "surfaces.place_in_stats"));
  // What a file says is its own affair, and what --set names has no place in the scene.
  write("empty.obj", "v 0 0 0\n");
  EXPECT_TRUE(says(fault(volume + "file = \"empty.obj\"\n"), "surfaces.vertices_no_face"));
  EXPECT_TRUE(says(render(ground_, {"--set", "volume.file=" + (folder_ / "none.vdb")}, 1).err,
                   "tools.file_missing"));
}

}  // namespace surfaces_test
}  // namespace pvol
