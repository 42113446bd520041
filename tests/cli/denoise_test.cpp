// Filtered pictures through the tools.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace denoise_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

constexpr const char* kRecipe =
    "[recipe]\nresolution = 40\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n"
    "[[modulation]]\namplitude = 0.7\ncell = 0.4\noctaves = 3\ngain = 0.5\nseed = 1\n";

class DenoiseOption : public ::testing::Test {
 protected:
  DenoiseOption() { std::ofstream(folder_ / "a.toml") << kRecipe; }

  RunResult render(const std::string& image, std::vector<std::string> more) {
    more.insert(more.begin(), {folder_ / "a.toml", "-o", folder_ / image, "--size", "40x30",
                               "--set", "medium.extinction=8"});
    return run_tool(PVOL_RENDER, more);
  }
  formats::StoredFilm film(const std::string& image, const std::vector<std::string>& more) {
    const RunResult r = render(image, more);
    EXPECT_EQ(r.exit, 0) << r.err;
    log_ = r.err;
    return formats::read_film(folder_ / image);
  }

  static std::vector<std::string> layers(const Film& film) {
    std::vector<std::string> all;
    for (const Layer& l : film.layers) all.push_back(l.name);
    std::ranges::sort(all);
    return all;
  }

  ScratchFolder folder_;
  std::string log_;
};

TEST_F(DenoiseOption, KeepsTheNoisyPictureAndSaysThatTheOtherIsBiased) {
  const auto plain = film("plain.exr", {"--spp", "16", "--aov", "variance,samples,halves"});
  const auto clean = film("clean.exr", {"--spp", "16", "--denoise"});
  EXPECT_TRUE(says(log_, "denoise.samples_noise"));
  EXPECT_TRUE(says(log_, "denoise.samples_noise"));
  EXPECT_EQ(layers(clean.film), (std::vector<std::string>{"noisy", "noisy_variance"}));
  EXPECT_TRUE(clean.has_variances);
  EXPECT_EQ(clean.attributes.at("pvol:biased"), "yes: denoised");
  EXPECT_EQ(clean.attributes.at("pvol:denoised"), "on");
  EXPECT_EQ(plain.attributes.at("pvol:biased"), "no");
  EXPECT_EQ(plain.attributes.at("pvol:denoised"), "off");
  EXPECT_LT(std::stod(clean.attributes.at("pvol:estimated_error")),
            0.7 * std::stod(clean.attributes.at("pvol:relative_noise")));
  const Layer* noisy = &clean.film.layers[0];
  const Layer* variance = &clean.film.layers[1];
  if (noisy->name != "noisy") std::swap(noisy, variance);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < plain.film.pixels.size(); ++i) {
    const PixelSums& p = plain.film.pixels[i];
    const Vec3d was = value(*noisy, clean.film, i), is = mean(clean.film.pixels[i]);
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(was[c], mean(p)[c], 1e-6 * mean(p)[c]);
      ASSERT_NEAR(value(*variance, clean.film, i)[c], variance_of_mean(p)[c], 1e-6);
    }
    ASSERT_EQ(clean.film.pixels[i].samples, 16u);
    if (length(is - was) > 1e-5) ++changed;
  }
  EXPECT_GT(changed, plain.film.pixels.size() / 4);
}

TEST_F(DenoiseOption, KeepsLayersThatWereAskedFor) {
  const auto clean = film("clean.exr", {"--spp", "4", "--denoise", "--aov", "depth,halves"});
  EXPECT_EQ(layers(clean.film),
            (std::vector<std::string>{"depth", "half_1", "half_2", "noisy", "noisy_variance"}));
}

/// The light of each source and each number of scatterings, as compositing adds them.
TEST_F(DenoiseOption, FiltersTheLayersThatSumUpToThePicture) {
  const auto clean = film("clean.exr", {"--spp", "8", "--denoise", "--aov", "lights,scattering"});
  for (const std::vector<std::string>& set : {std::vector<std::string>{"sky", "sun_1", "emission"},
                                              {"unscattered", "single", "multiple"}}) {
    for (std::size_t i = 0; i < clean.film.pixels.size(); ++i) {
      Vec3d sum;
      for (const Layer& l : clean.film.layers) {
        if (std::ranges::find(set, l.name) != set.end()) sum += value(l, clean.film, i);
      }
      const Vec3d is = mean(clean.film.pixels[i]);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sum[c], is[c], 1e-6 * is[c]) << set[0];
    }
  }
}

/// Droplets seen against a low sun: few samples have most of the light.
TEST_F(DenoiseOption, SaysHowManyFirefliesItSpread) {
  const std::vector<std::string> low_sun{"--spp",
                                         "4",
                                         "--denoise",
                                         "--set",
                                         "medium.droplet_diameter=14",
                                         "--set",
                                         "sun.direction=[0,0.1,-1]"};
  const auto clean = film("clean.exr", low_sun);
  EXPECT_GT(std::stoi(clean.attributes.at("pvol:fireflies")), 0);
  EXPECT_TRUE(says(log_, "denoise.fireflies"));
  (void)film("calm.exr", {"--spp", "64", "--denoise"});
  EXPECT_EQ(log_.find("fireflies"), std::string::npos);
}

TEST_F(DenoiseOption, ServesCropsSamplesAdaptiveAndPicturesAlone) {
  film("crop.exr", {"--spp", "4", "--denoise", "--crop", "10,5,17,20"});
  film("need.exr", {"--noise", "0.05", "--denoise"});
  const RunResult r = render("clean.png", {"--spp", "4", "--denoise"});
  EXPECT_EQ(r.exit, 0);
  EXPECT_TRUE(says(r.err, "denoise.picture_biased"));
  ASSERT_EQ(render("noisy.png", {"--spp", "4"}).exit, 0);
  EXPECT_NE(read_text(folder_ / "clean.png"), read_text(folder_ / "noisy.png"));
}

TEST_F(DenoiseOption, GivesTheSameBytesForAnyNumberOfThreads) {
  (void)film("one.exr", {"--spp", "4", "--denoise", "--threads", "1"});
  (void)film("three.exr", {"--spp", "4", "--denoise", "--threads", "3"});
  EXPECT_EQ(read_text(folder_ / "one.exr"), read_text(folder_ / "three.exr"));
}

TEST_F(DenoiseOption, IsNamedWherePicturesAreCompared) {
  const std::vector<std::string> more{"--spp", "4", "--aov", "variance,samples"};
  (void)film("noisy.exr", more);
  std::vector<std::string> filtered = more;
  filtered.insert(filtered.end(), {"--denoise", "--seed", "2"});
  (void)film("clean.exr", filtered);
  const auto compare = [&](const char* b) {
    return run_tool(PVOL_STATS, {"image", folder_ / "noisy.exr", folder_ / b}).err;
  };
  EXPECT_TRUE(says(compare("clean.exr"), "denoise.filtered_denoise_pixels"));
  EXPECT_EQ(compare("noisy.exr").find("filtered"), std::string::npos);
}

TEST_F(DenoiseOption, IsReportedAndRefusedWhereNoiseIsNotKnown) {
  const RunResult r = render("a.exr", {"--spp", "4", "--denoise", "--stats", "-", "--quiet"});
  const json stats = json::parse(r.out);
  EXPECT_GT(stats["denoised"]["estimated_error"], 0);
  EXPECT_GE(stats["denoised"]["fireflies"], 0);
  EXPECT_EQ(stats["options"]["biased"], "yes: denoised");
  const RunResult one = render("b.exr", {"--spp", "1", "--denoise"});
  EXPECT_EQ(one.exit, 2);
  EXPECT_TRUE(says(one.err, "denoise.denoise_needs_spp"));
}

}  // namespace denoise_test
}  // namespace pvol
