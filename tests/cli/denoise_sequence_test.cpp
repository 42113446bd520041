// Pictures and sequences filtered after they were rendered, through the tools.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace denoise_sequence_cli {

using testing::operator+;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

class DenoiseFrames : public ::testing::Test {
 protected:
  /// Balls that roll through the picture, and the camera with them.
  DenoiseFrames() {
    for (int frame = 1; frame <= 4; ++frame) {
      const std::string number = std::to_string(frame);
      std::ofstream(folder_ / ("ball." + number + ".toml"))
          << "[recipe]\nresolution = 32\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\n"
             "radii = 1\n[[modulation]]\namplitude = 0.7\ncell = 0.4\noctaves = 3\ngain = 0.5\n"
             "seed = 1\n";
      std::ofstream(folder_ / ("shot." + number + ".toml"))
          << "[volume]\nfile = \"ball." + number +
                 ".toml\"\n[medium]\nextinction = 8\n"
                 "[camera]\nposition = [" +
                 number +
                 ", 1, 6]\ntarget = [0, 0, 0]\n"
                 "[[sun]]\ndirection = [1, 1, 1]\nirradiance = 4\n"
                 "[render]\nsize = [40, 30]\nspp = 16\n";
    }
  }
  RunResult render(const std::string& from, const std::string& to, const Words& more) {
    return run_tool(PVOL_RENDER, Words{folder_ / from, "-o", folder_ / to} + more);
  }
  RunResult denoise(const std::string& from, const std::string& to, const Words& more = {}) {
    return run_tool(PVOL_CONVERT, Words{"denoise", folder_ / from, "-o", folder_ / to} + more);
  }
  void render_all() {
    const RunResult r =
        render("shot.#.toml", "noisy.#.exr", {"--frames", "1-4", "--denoise-layers", "--no-png"});
    ASSERT_EQ(r.exit, 0) << r.err;
  }
  ScratchFolder folder_;
};

bool has_layer(const Film& film, const std::string& name) {
  return std::ranges::find(film.layers, name, &Layer::name) != film.layers.end();
}

TEST_F(DenoiseFrames, MakesOfOnePictureWhatRenderingItSoMakes) {
  ASSERT_EQ(render("shot.1.toml", "noisy.exr", {"--denoise-layers"}).exit, 0);
  ASSERT_EQ(render("shot.1.toml", "clean.exr", {"--denoise"}).exit, 0);
  const RunResult r = denoise("noisy.exr", "later.exr");
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "denoise.later"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "later.png"));
  const auto clean = formats::read_film(folder_ / "clean.exr");
  const auto later = formats::read_film(folder_ / "later.exr");
  for (std::size_t i = 0; i < clean.film.pixels.size(); ++i) {
    const Vec3d a = mean(clean.film.pixels[i]), b = mean(later.film.pixels[i]);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(b[c], a[c], 1e-4 * (a[c] + 0.1));
  }
  EXPECT_EQ(later.attributes.at("pvol:biased"), "yes: denoised");
  EXPECT_EQ(later.attributes.at("pvol:denoise_frames"), "1");
  EXPECT_EQ(later.attributes.at("pvol:samples"), clean.attributes.at("pvol:samples"));
  EXPECT_NEAR(std::stod(later.attributes.at("pvol:estimated_error")),
              std::stod(clean.attributes.at("pvol:estimated_error")), 1e-4);
  EXPECT_TRUE(has_layer(later.film, "noisy"));
  EXPECT_TRUE(has_layer(later.film, "depth"));
  EXPECT_FALSE(has_layer(later.film, "half_1"));
}

TEST_F(DenoiseFrames, TakesLightFromTheFramesAround) {
  render_all();
  const RunResult r = denoise("noisy.#.exr", "clean.#.exr", {"--frames", "1-4", "--no-png"});
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "denoise.frame_with_others"));
  ASSERT_EQ(denoise("noisy.#.exr", "alone.#.exr", {"--frames", "1-4", "--around", "0"}).exit, 0);
  for (const auto& [frame, used] : {std::pair("1", "3"), std::pair("2", "4")}) {
    const auto clean = formats::read_film(folder_ / ("clean." + std::string(frame) + ".exr"));
    const auto alone = formats::read_film(folder_ / ("alone." + std::string(frame) + ".exr"));
    EXPECT_EQ(clean.attributes.at("pvol:denoise_frames"), used);
    EXPECT_LT(std::stod(clean.attributes.at("pvol:estimated_error")),
              0.9 * std::stod(alone.attributes.at("pvol:estimated_error")));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "clean.1.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "alone.1.png"));
  // A task of a farm makes the same bytes of its frame.
  ASSERT_EQ(denoise("noisy.#.exr", "task.#.exr", {"--frames", "1-4", "--frame", "3"}).exit, 0);
  EXPECT_TRUE(read_text(folder_ / "task.3.exr") == read_text(folder_ / "clean.3.exr"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "task.2.exr"));
}

TEST_F(DenoiseFrames, HaveTheVelocitiesOfTheirClouds) {
  std::ofstream(folder_ / "ball.1.toml", std::ios::app)
      << "[flow]\nvelocity = [0, 48, -24]\n";  // a second, at 24 frames
  const RunResult r = render("shot.1.toml", "noisy.exr", {"--denoise-layers", "--no-png"});
  ASSERT_EQ(r.exit, 0) << r.err;
  const Film film = formats::read_film(folder_ / "noisy.exr").film;
  ASSERT_TRUE(has_layer(film, "velocity"));
  const auto layer = std::ranges::find(film.layers, "velocity", &Layer::name);
  int hits = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    if (film.pixels[i].alpha == 0) continue;
    EXPECT_LT(length(value(*layer, film, i) - Vec3d(0, 2, -1)), 2e-3);
    ++hits;
  }
  EXPECT_GT(hits, 100);
  ASSERT_EQ(render("shot.2.toml", "still.exr", {"--denoise-layers", "--no-png"}).exit, 0);
  const Film still = formats::read_film(folder_ / "still.exr").film;
  ASSERT_TRUE(has_layer(still, "velocity"));
  const auto zero = std::ranges::find(still.layers, "velocity", &Layer::name);
  EXPECT_TRUE(std::ranges::all_of(zero->sums, [](Vec3d v) { return v == Vec3d{}; }));
}

TEST_F(DenoiseFrames, SaysWhatIsMissing) {
  render_all();
  const auto expect_refused = [](const RunResult& r, int code, const char* key) {
    EXPECT_EQ(r.exit, code) << r.err;
    EXPECT_TRUE(says(r.err, key));
  };
  std::filesystem::remove(folder_ / "noisy.3.exr");
  expect_refused(denoise("noisy.#.exr", "c.#.exr", {"--frames", "1-4", "--frame", "1"}), 1,
                 "denoise.frame_missing");
  expect_refused(denoise("noisy.#.exr", "c.#.exr"), 2, "denoise.pattern");
  expect_refused(denoise("noisy.#.exr", "c.exr", {"--frames", "1-2"}), 2, "denoise.one_output");
  expect_refused(denoise("noisy.1.exr", "noisy.1.exr"), 2, "denoise.onto_itself");
  expect_refused(denoise("noisy.#.exr", "noisy.#.exr", {"--frames", "1-2"}), 2,
                 "denoise.onto_itself");
  expect_refused(render("shot.1.toml", "a.exr", {"--denoise", "--denoise-layers"}), 2,
                 "denoise.both_flags");
  ASSERT_EQ(render("shot.1.toml", "clean.exr", {"--denoise"}).exit, 0);
  expect_refused(denoise("clean.exr", "c.exr"), 1, "denoise.filtered_already");
  ASSERT_EQ(denoise("noisy.1.exr", "later.exr").exit, 0);
  expect_refused(denoise("later.exr", "c.exr"), 1, "denoise.filtered_already_later");
  ASSERT_EQ(render("shot.1.toml", "plain.exr", {}).exit, 0);
  expect_refused(denoise("plain.exr", "c.exr"), 1, "denoise.no_layers");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c.exr"));
}

}  // namespace denoise_sequence_cli
}  // namespace pvol
