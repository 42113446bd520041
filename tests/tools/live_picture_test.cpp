// Pictures that refine while their scene is changed: at their end they are those of pvol-render,
// whatever was shown before.
#include "cli/live_picture.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/render.h"
#include "support/temporary_folder.h"

namespace pvol::cli {
namespace live_picture_test {

/// No machine is so slow that a small picture takes longer.
constexpr double kLong = 300;

constexpr const char* kBall = R"([recipe]
resolution = 24
[[form]]
shape = "ellipsoid"
centre = [0, 0, 0]
radii = 1
)";

class Live : public ::testing::Test {
 protected:
  Live() {
    std::ofstream(folder_.file("ball.toml")) << kBall;
    Film sky{4, 2, 0, 0, 4, 2, std::vector<PixelSums>(8)};
    for (PixelSums& p : sky.pixels) p = {{0.2, 0.4, 0.9}, {}, 1, 1};
    formats::write_exr(folder_.file("sky.exr"), sky, {});
  }

  /// A ball under a sun, with values set.
  [[nodiscard]] formats::SceneFile scene(const std::vector<std::string>& sets = {}) const {
    std::vector<std::string> all{"render.size=[80,45]", "render.spp=4", "medium.extinction=8"};
    all.insert(all.end(), sets.begin(), sets.end());
    return read_scene(folder_.file("ball.toml"), all);
  }

  TemporaryFolder folder_;
};

LiveState finished(const LivePicture& picture, std::uint64_t change) {
  LiveState s = picture.state();
  while (s.change < change || !s.finished) s = picture.wait(s.number, kLong);
  return s;
}

/// Of a scene that nothing was in memory for.
Film rendered(formats::SceneFile scene) {
  const RenderJob job = LiveScene({"test", true}).prepare(std::move(scene));
  return render(job.volumes, job.file.scene).film;
}

void expect_same(const Film& a, const Film& b) {
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    ASSERT_EQ(mean(a.pixels[i]), mean(b.pixels[i])) << "pixel " << i;
    ASSERT_EQ(a.pixels[i].alpha, b.pixels[i].alpha) << "pixel " << i;
  }
}

TEST_F(Live, EveryChangeEndsInThePictureOfItsScene) {
  LivePicture picture(LiveScene({"test", true}));
  const std::vector<std::vector<std::string>> changes{
      {},
      {"medium.albedo=0.5"},                      // of the volume as it is
      {"medium.extinction=3"},                    // makes it anew
      {"medium.translate=[0.2,0,0]"},             //
      {"medium.density.power=2"},                 //
      {"camera.azimuth=30", "sun.irradiance=1"},  // leaves it
      {"render.interpolation=tricubic"},          // has the cloud read again
      {"medium.phase_table=[[0,1],[180,2]]"},     //
      {"render.crop=[8,4,40,30]"},
      {"environment.file=" + folder_.file("sky.exr").string()},
      {"environment.file=" + folder_.file("sky.exr").string(), "environment.color_space=acescg"},
      {"environment.file=" + folder_.file("sky.exr").string(), "render.color_space=acescg"},
      {"medium.fire.field=density", "medium.fire.kelvin=2000", "medium.fire.intensity=1"},
      {"medium.fire.field=density", "medium.fire.kelvin=2000", "medium.fire.intensity=1",
       "render.color_space=acescg"},
      {}};
  for (const auto& sets : changes) {
    SCOPED_TRACE(sets.empty() ? "" : sets.front());
    const LiveState s = finished(picture, picture.change(scene(sets)));
    ASSERT_EQ(s.error, "");
    expect_same(*s.film, rendered(scene(sets)));
  }
}

TEST_F(Live, BeginsWithFewPixelsAndDoublesThem) {
  LivePicture picture(LiveScene({"test", true}));
  const auto large = scene({"render.size=[960,540]", "render.spp=1"});
  const std::uint64_t change = picture.change(large);
  std::vector<int> widths;
  LiveState s = picture.state();
  while (s.change < change || !s.finished) {
    s = picture.wait(s.number, kLong);
    ASSERT_TRUE(s.film);
    EXPECT_EQ(s.coarse, s.film->crop_width < 960);
    if (widths.empty() || widths.back() != s.film->crop_width) {
      widths.push_back(s.film->crop_width);
    }
    for (const PixelSums& p : s.film->pixels) ASSERT_GT(p.samples, 0u) << "holes";
  }
  ASSERT_FALSE(widths.empty());
  EXPECT_EQ(widths.back(), 960);
  for (std::size_t i = 1; i < widths.size(); ++i) EXPECT_EQ(widths[i], 2 * widths[i - 1]);
}

TEST_F(Live, CoarsePicturesShowTheSame) {
  LivePicture picture(LiveScene({"test", true}));
  const auto large =
      scene({"render.size=[961,541]", "render.spp=1", "render.crop=[101,50,700,400]"});
  const std::uint64_t change = picture.change(large);
  const auto brightness = [](const Film& film) {
    Vec3d sum;
    for (const PixelSums& p : film.pixels) sum = sum + mean(p);
    return sum.y / double(film.pixels.size());
  };
  std::vector<double> all;
  LiveState s = picture.state();
  while (s.change < change || !s.finished) {
    s = picture.wait(s.number, kLong);
    all.push_back(brightness(*s.film));
  }
  // The window is rounded to whole blocks of pixels, a few per cent of its size.
  for (const double b : all) EXPECT_NEAR(b, all.back(), 0.05 * all.back());
}

TEST_F(Live, WhatIsGivenUpIsNeverShownAsLater) {
  LivePicture picture(LiveScene({"test", true}));
  std::uint64_t last = 0;
  for (int i = 0; i < 40; ++i) {
    last = picture.change(scene({"medium.albedo=" + std::to_string(0.02 * i)}));
  }
  expect_same(*finished(picture, last).film, rendered(scene({"medium.albedo=0.78"})));
}

TEST_F(Live, TellsWhatIsWrongAndGoesOn) {
  LivePicture picture(LiveScene({"test", true}));
  (void)finished(picture, picture.change(scene()));
  formats::SceneFile wrong = scene();
  wrong.volumes.front().file = folder_.file("absent.vdb");
  const LiveState s = finished(picture, picture.change(wrong));
  EXPECT_NE(s.error.find("absent.vdb"), std::string::npos) << s.error;
  EXPECT_TRUE(s.film) << "that of before";
  expect_same(*finished(picture, picture.change(scene())).film, rendered(scene()));
}

TEST_F(Live, FiltersWhatItHas) {
  LivePicture picture(LiveScene({"test", true}));
  const LiveState s = finished(picture, picture.change(scene({"render.spp=8"}), {.filter = true}));
  ASSERT_EQ(s.error, "");
  ASSERT_TRUE(s.filtered);
  EXPECT_GT(s.filtered->relative_error, 0);
  expect_same(*s.film, rendered(scene({"render.spp=8", "render.aov=[\"halves\"]"})));
  const LiveState one =
      finished(picture, picture.change(scene({"render.spp=1"}), {.filter = true}));
  EXPECT_EQ(one.error, "");
  EXPECT_FALSE(one.filtered) << "a sample tells nothing of noise";
}

TEST_F(Live, ClosesWhileItRenders) {
  LivePicture picture(LiveScene({"test", true}));
  (void)picture.change(scene({"render.size=[1920,1080]", "render.spp=100000"}));
  (void)picture.wait(0, kLong);
}

}  // namespace live_picture_test
}  // namespace pvol::cli
