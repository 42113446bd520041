// Clear skies and .hdr pictures from the command line to the picture.
#include <gtest/gtest.h>

#include <fstream>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace sky_test {

using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

class Skies : public ::testing::Test {
 protected:
  Skies() {
    std::ofstream(ball_) << "[recipe]\nresolution = 24\n[[form]]\nshape = \"ellipsoid\"\n"
                            "centre = [0, 0, 0]\nradii = 1\n";
  }

  /// Of a ball, small; arguments of --set.
  RunResult render(const std::vector<std::string>& sets, const char* output = "a.exr",
                   const std::vector<std::string>& more = {}) {
    std::vector<std::string> all{ball_, "-o",    folder_ / output,      "--size", "24x16", "--spp",
                                 "4",   "--set", "medium.extinction=40"};
    for (const std::string& set : sets) all.insert(all.end(), {"--set", set});
    all.insert(all.end(), more.begin(), more.end());
    return run_tool(PVOL_RENDER, all);
  }
  std::string print(const std::vector<std::string>& sets) {
    const RunResult r = render(sets, "a.exr", {"--print-scene"});
    EXPECT_EQ(r.exit, 0) << r.err;
    return r.out;
  }
  void expect_refused(const std::vector<std::string>& sets, int exit, const std::string& key) {
    const RunResult r = render(sets);
    EXPECT_EQ(r.exit, exit) << r.err;
    EXPECT_TRUE(says(r.err, key));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
  }
  std::vector<Vec3d> pixels(const char* picture) {
    std::vector<Vec3d> all;
    for (const PixelSums& p : formats::read_film(folder_ / picture).film.pixels)
      all.push_back(mean(p));
    return all;
  }

  ScratchFolder folder_;
  std::string ball_ = folder_ / "ball.toml";
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Skies, AClearSkyBringsItsSun) {
  const std::string clear = print({"environment.type=clear", "environment.elevation=5"});
  EXPECT_TRUE(has(clear, "type = \"clear\"\nelevation = 5")) << clear;
  EXPECT_FALSE(has(clear, "[[sun]]")) << "the usual sun beside that of the sky";
  EXPECT_FALSE(has(clear, "date")) << clear;
  EXPECT_FALSE(has(print({"environment.elevation=5"}), "[[sun]]")) << "known by its first key";
  EXPECT_TRUE(has(print({"environment.type=clear", "sun.irradiance=1"}), "[[sun]]"));
  EXPECT_TRUE(has(print({"environment.radiance=1"}), "[[sun]]"));
  const std::string z = print({"environment.type=clear", "world.up=z"});
  EXPECT_TRUE(has(z, "up = [0.0, 0.0, 1.0]\nnorth = [0.0, 1.0, 0.0]") ||
              has(z, "up = [0, 0, 1]\nnorth = [0, 1, 0]"))
      << z;
  // The layers say so, too.
  const RunResult r = render({"environment.type=clear"}, "lights.exr", {"--aov", "lights"});
  ASSERT_EQ(r.exit, 0) << r.err;
  double sun = 0, sky = 0;
  for (const Layer& layer : formats::read_film(folder_ / "lights.exr").film.layers) {
    for (const Vec3d& v : layer.sums) (layer.name == "sun_1" ? sun : sky) += v.y;
  }
  EXPECT_GT(sun, 0);
  EXPECT_GT(sky, 0);
}

TEST_F(Skies, ThePictureIsMadeAgainFromItsHeader) {
  const std::vector<std::string> sets{
      "environment.type=clear", "environment.date=2024-06-21T20:20:00+02:00",
      "environment.latitude=41.4", "environment.longitude=2.2", "environment.turbidity=3.5"};
  ASSERT_EQ(render(sets, "first.exr").exit, 0);
  const auto header = formats::read_film(folder_ / "first.exr").attributes;
  ASSERT_TRUE(header.contains("pvol:scene"));
  const std::string scene = header.at("pvol:scene");
  EXPECT_TRUE(has(scene, "date = \"2024-06-21T20:20:00+02:00\"\nlatitude = 41.4")) << scene;
  std::ofstream(folder_ / "again.toml") << scene;
  const RunResult again =
      run_tool(PVOL_RENDER, {folder_ / "again.toml", "-o", folder_ / "again.exr"});
  ASSERT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(pixels("first.exr"), pixels("again.exr"));
}

TEST_F(Skies, WhatIsNoSkyIsRefused) {
  const std::string clear = "environment.type=clear";
  expect_refused({clear, "environment.turbidity=0.5"}, 2, "sky.turbidity_0_5");
  expect_refused({clear, "environment.ozone=-1"}, 2, "sky.ozone_negative");
  expect_refused({clear, "environment.elevation=91"}, 2, "sky.elevation_91");
  expect_refused({clear, "environment.sun=maybe"}, 2, "sky.sun_maybe");
  expect_refused({clear, "environment.date=tomorrow"}, 2, "sky.date_tomorrow");
  expect_refused({clear, "environment.date=2024-06-21T12:00:00Z"}, 2,
                 "sky.date_latitude_longitude");
  expect_refused({clear, "environment.latitude=3"}, 2, "sky.latitude_3");
  expect_refused({clear, "environment.date=2024-06-21T12:00:00Z", "environment.latitude=3",
                  "environment.longitude=4", "environment.azimuth=1"},
                 2, "sky.azimuth_1");
  expect_refused({clear, "environment.north=[0,2,0]"}, 2, "sky.north_direction_not");
  std::ofstream(folder_ / "bad.toml") << "[volume]\nfile = \"a.vdb\"\n[environment]\ntype = "
                                         "\"clear\"\ndate = \"2023-02-29T00:00Z\"\n";
  const RunResult r = run_tool(PVOL_RENDER, {folder_ / "bad.toml", "-o", folder_ / "a.exr"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "sky.environment_date_29t00"));
}

TEST_F(Skies, NightIsBlack) {
  const std::vector<std::string> midnight{"environment.type=clear",
                                          "environment.date=2024-12-21T23:00:00Z",
                                          "environment.latitude=51.5", "environment.longitude=0"};
  const RunResult r = render(midnight, "b.exr");
  EXPECT_EQ(r.exit, 0);
  EXPECT_TRUE(says(r.err, "sky.sky_date_sun"));
  ASSERT_EQ(render({"environment.type=clear", "environment.elevation=-30"}).exit, 0);
  for (const Vec3d& p : pixels("a.exr")) EXPECT_EQ(p, Vec3d(0.0));
}

TEST_F(Skies, RadiancePicturesLightTheCloud) {
  // Red everywhere: 128 x 2^(129 - 136) = 1.
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
  for (int i = 0; i < 8; ++i) bytes += std::string("\x80\0\0\x81", 4);
  std::ofstream(folder_ / "red.hdr", std::ios::binary) << bytes;
  const std::string file = "environment.file=" + (folder_ / "red.hdr");
  ASSERT_EQ(render({file, "sun.irradiance=0"}).exit, 0);
  for (const Vec3d& p : pixels("a.exr")) {
    EXPECT_GT(p.x, 0.2);
    EXPECT_EQ(p.y + p.z, 0);
  }
  std::filesystem::remove(folder_ / "a.exr");
  std::ofstream(folder_ / "red.hdr", std::ios::binary) << bytes.substr(0, bytes.size() - 3);
  expect_refused({file}, 1, "sky.ends_within_pixels");
}

TEST_F(Skies, APictureThatTheSceneReadsIsNoOutput) {
  ASSERT_EQ(render({}, "sky.exr").exit, 0);
  std::filesystem::copy(folder_ / "sky.exr", folder_ / "sky.0007.exr");
  const std::string before = testing::read_text(folder_ / "sky.exr");
  const auto refuse = [&](const std::string& read, const char* output,
                          const std::vector<std::string>& more) {
    const RunResult r = render({"environment.file=" + (folder_ / read)}, output, more);
    EXPECT_EQ(r.exit, 2) << output;
    EXPECT_TRUE(says(r.err, "sky.output_is_read"));
  };
  refuse("sky.exr", "sky.exr", {});
  refuse("sky.exr", "b.exr", {"--no-png", "--deep", folder_ / "sky.exr"});
  refuse("sky.####.exr", "sky.####.exr", {"--frame", "7"});
  EXPECT_TRUE(testing::read_text(folder_ / "sky.exr") == before);
  EXPECT_TRUE(testing::read_text(folder_ / "sky.0007.exr") == before);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.exr"));
}

}  // namespace sky_test
}  // namespace pvol
