// Colour spaces from the command line to the picture.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/formats/image.h"
#include "support/color_shot.h"
#include "support/messages.h"

namespace pvol {
namespace color_space_test {

using testing::run_tool;
using testing::RunResult;

using ColorSpaces = testing::ColorShot;

struct Total {
  Vec3d mean, variance;
};
/// Of the picture's mean colour, after this map.
Total total_of(const Film& film, const Affine& map) {
  Total t;
  for (const PixelSums& p : film.pixels) {
    t.mean += map.vector(mean(p)) / double(film.pixels.size());
    const Vec3d v = variance_of_mean(p);
    for (int c = 0; c < 3; ++c) {  // channels as if they were independent or the same: the larger
      const Vec3d row = map.m[std::size_t(c)];
      const double deviation = std::abs(row.x) * std::sqrt(v.x) + std::abs(row.y) * std::sqrt(v.y) +
                               std::abs(row.z) * std::sqrt(v.z);
      t.variance[c] += deviation * deviation / std::pow(double(film.pixels.size()), 2);
    }
  }
  return t;
}

/// Black bodies, a clear sky, its sun and grey media: the light of one space is that of the other.
TEST_F(ColorSpaces, ThePictureIsTheSameLightByOtherPrimaries) {
  ASSERT_EQ(render("a.exr", {"--seed", "1", "--aov", "variance,samples"}).exit, 0);
  const RunResult aces =
      render("b.exr", {"--seed", "2", "--aov", "variance,samples", "--color-space", "acescg"});
  ASSERT_EQ(aces.exit, 0) << aces.err;
  const Film a = film("a.exr"), b = film("b.exr");
  ASSERT_EQ(a.color_space, ColorSpace::rec709);
  ASSERT_EQ(b.color_space, ColorSpace::acescg);
  const Total wanted = total_of(a, {});
  const Total found = total_of(b, conversion(ColorSpace::acescg, ColorSpace::rec709));
  for (int c = 0; c < 3; ++c) {
    const double deviation = std::sqrt(wanted.variance[c] + found.variance[c]);
    EXPECT_LT(deviation, 0.01 * wanted.mean[c]) << "the test would not see 3 %";
    EXPECT_NEAR(found.mean[c], wanted.mean[c], 4 * deviation) << c;
  }
  const Vec3d raw = total_of(b, {}).mean;
  EXPECT_GT(std::abs(raw.x - wanted.mean.x), 0.03 * wanted.mean.x) << "spaces that differ";
}

TEST_F(ColorSpaces, TheSceneThatIsPrintedHasTheSpace) {
  const RunResult r = render("a.exr", {"--color-space", "aces2065-1", "--print-scene"});
  EXPECT_NE(r.out.find("color_space = \"aces2065-1\""), std::string::npos) << r.out;
  EXPECT_TRUE(says(render("a.exr", {"--color-space", "xyz"}).err, "color.space_unknown"));
}

TEST_F(ColorSpaces, PicturesOfTwoSpacesAreNeitherMergedNorCompared) {
  ASSERT_EQ(render("a.exr", {"--samples", "0:32", "--aov", "variance,samples"}).exit, 0);
  ASSERT_EQ(render("b.exr",
                   {"--samples", "32:64", "--color-space", "acescg", "--aov", "variance,samples"})
                .exit,
            0);
  const RunResult merged = run_tool(
      PVOL_CONVERT, {"merge", folder_ / "a.exr", folder_ / "b.exr", "-o", folder_ / "c.exr"});
  EXPECT_EQ(merged.exit, 1);
  EXPECT_TRUE(says(merged.err, "color.merge_other_scene"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c.exr"));
  ASSERT_EQ(render("a.exr", {"--aov", "variance,samples"}).exit, 0);
  ASSERT_EQ(render("b.exr", {"--color-space", "acescg", "--aov", "variance,samples"}).exit, 0);
  const RunResult compared = run_tool(PVOL_STATS, {"image", folder_ / "a.exr", folder_ / "b.exr"});
  EXPECT_EQ(compared.exit, 1);
  EXPECT_TRUE(says(compared.err, "color.compare_spaces"));
}

/// A sky of a picture, converted from its file's space and from one that is told.
TEST_F(ColorSpaces, SkiesAreConverted) {
  Film sky{4, 2, 0, 0, 4, 2, std::vector<PixelSums>(8)};
  constexpr Vec3d kSky(0.2, 0.4, 0.9);
  for (PixelSums& p : sky.pixels) p = {kSky, {}, 1, 1};
  formats::write_exr(folder_ / "sky.exr", sky, {});
  const std::string file = "environment.file=" + (folder_ / "sky.exr");
  const auto corner = [&](const std::string& from, const std::string& to) {
    const RunResult r =
        render("a.exr", {"--set", "environment={}", "--set", file, "--set",
                         "environment.color_space=\"" + from + "\"", "--color-space", to});
    EXPECT_EQ(r.exit, 0) << r.err;
    return mean(film("a.exr").pixels.front());
  };
  const auto expect_near = [](Vec3d found, Vec3d wanted) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 1e-5) << c;
  };
  const Affine map = conversion(ColorSpace::rec709, ColorSpace::acescg);
  expect_near(corner("", "rec709"), kSky);
  expect_near(corner("", "acescg"), map.vector(kSky));
  expect_near(corner("acescg", "acescg"), kSky);
  expect_near(corner("p3-d65", "acescg"),
              conversion(ColorSpace::p3, ColorSpace::acescg).vector(kSky));
}

TEST_F(ColorSpaces, PartsOfOneSpaceAreMerged) {
  const std::vector<std::string> space{"--color-space", "acescg"};
  for (const char* samples : {"0:32", "32:64"}) {
    std::vector<std::string> more = space;
    more.insert(more.end(), {"--samples", samples});
    ASSERT_EQ(render(std::string(samples[0] == '0' ? "a" : "b") + ".exr", more).exit, 0);
  }
  ASSERT_EQ(render("whole.exr", space).exit, 0);
  ASSERT_EQ(run_tool(PVOL_CONVERT, {"merge", folder_ / "a.exr", folder_ / "b.exr", "-o",
                                    folder_ / "c.exr", "--no-png"})
                .exit,
            0);
  const Film merged = film("c.exr"), whole = film("whole.exr");
  EXPECT_EQ(merged.color_space, ColorSpace::acescg);
  for (std::size_t i = 0; i < whole.pixels.size(); ++i) {
    ASSERT_EQ(mean(merged.pixels[i]), mean(whole.pixels[i]));
  }
}

TEST_F(ColorSpaces, DeepPicturesHaveTheSpaceToo) {
  const RunResult r = run_tool(
      PVOL_RENDER, {folder_ / "ball.toml", "--size", "24x16", "--spp", "4", "--color-space",
                    "acescg", "--deep", folder_ / "d.exr", "--no-png", "-o", folder_ / "a.exr"});
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_EQ(formats::flatten_exr(folder_ / "d.exr").film.color_space, ColorSpace::acescg);
}

TEST_F(ColorSpaces, ToneMapsAreCheckedBeforeAnythingIsRendered) {
  const RunResult r = render("a.exr", {"--tone-map", "none such"});
  EXPECT_EQ(r.exit, 2);
  EXPECT_TRUE(says(r.err, formats::tone_maps().size() > 3 ? "color.tone_map_unknown"
                                                          : "color.tone_map_without"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
}

}  // namespace color_space_test
}  // namespace pvol
