// OCIO configurations from the command line to the picture.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "support/color_shot.h"
#include "support/messages.h"

namespace pvol {
namespace ocio_test {

using testing::run_tool;
using testing::RunResult;

using Ocio = testing::ColorShot;

/// Pictures are the same only where names of spaces mean the same.
TEST_F(Ocio, PicturesOfOtherConfigurationsAreOthers) {
  Film sky{4, 2, 0, 0, 4, 2, std::vector<PixelSums>(8)};
  for (PixelSums& p : sky.pixels) p = {Vec3d(0.5), {}, 1, 1};
  formats::write_exr(folder_ / "sky.exr", sky, {});
  std::ofstream(folder_ / "own.ocio")
      << "ocio_profile_version: 1\nroles: {default: lin_rec709}\n"
         "displays:\n  d: [!<View> {name: v, colorspace: lin_rec709}]\n"
         "colorspaces:\n  - !<ColorSpace> {name: lin_rec709}\n  - !<ColorSpace> {name: srgb_tx}\n";
  const auto part = [&](const std::string& output, const std::string& samples) {
    return render(output,
                  {"--set", "environment={}", "--set", "environment.file=" + (folder_ / "sky.exr"),
                   "--set", "environment.color_space=srgb_tx", "--samples", samples});
  };
  ASSERT_EQ(part("a.exr", "0:32").exit, 0) << part("a.exr", "0:32").err;
  setenv("OCIO", (folder_ / "own.ocio").c_str(), 1);
  const RunResult other = part("b.exr", "32:64");
  unsetenv("OCIO");
  ASSERT_EQ(other.exit, 0) << other.err;
  const RunResult merged = run_tool(
      PVOL_CONVERT, {"merge", folder_ / "a.exr", folder_ / "b.exr", "-o", folder_ / "c.exr"});
  EXPECT_TRUE(says(merged.err, "color.merge_other_files"));
}

TEST_F(Ocio, ViewsOfAConfigurationShowThePicture) {
  ASSERT_EQ(render("a.exr", {"--png", folder_ / "a.png", "--tone-map", "ACES 1.0"}).exit, 0);
  ASSERT_EQ(render("b.exr", {"--png", folder_ / "b.png"}).exit, 0);
  formats::write_png(folder_ / "c.png", film("a.exr"), {0, "ACES 1.0"});
  const auto bytes = [&](const char* name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  EXPECT_EQ(bytes("a.png"), bytes("c.png"));
  EXPECT_NE(bytes("a.png"), bytes("b.png"));
}

}  // namespace ocio_test
}  // namespace pvol
