// Deep pictures through pvol-render.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace deep_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

struct Deep : ::testing::Test {
  ScratchFolder folder;
  std::string ball = folder / "ball.toml";

  Deep() {
    std::ofstream(ball) << "[recipe]\nresolution = 40\nedge = 0.3\n[[form]]\n"
                           "shape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n";
  }

  [[nodiscard]] RunResult render(const std::string& image,
                                 const std::vector<std::string>& more) const {
    std::vector<std::string> all{ball, "-o",    folder / image,       "--size", "24x16", "--spp",
                                 "20", "--set", "medium.extinction=2"};
    all.insert(all.end(), more.begin(), more.end());
    return run_tool(PVOL_RENDER, all);
  }
  void expect_refused(int exit, const std::vector<std::string>& more,
                      const std::string& key) const {
    const RunResult r = render("refused.exr", more);
    EXPECT_EQ(r.exit, exit) << r.err;
    EXPECT_TRUE(says(r.err, key));
    EXPECT_FALSE(std::filesystem::exists(folder / "refused.exr"));
  }
};

TEST_F(Deep, IsWrittenBesideAPictureThatDoesNotChange) {
  EXPECT_EQ(render("plain.exr", {}).exit, 0);
  const RunResult r = render("a.exr", {"--deep", folder / "a.deep.exr"});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_NE(r.err.find("a.deep.exr, "), std::string::npos) << r.err;
  EXPECT_TRUE(says(r.err, "deep.wrote_deep_exr"));
  EXPECT_EQ(read_text(folder / "plain.exr"), read_text(folder / "a.exr"));
  // Coarser, it is smaller.
  EXPECT_EQ(render("b.exr", {"--deep", folder / "b.exr.exr", "--deep-error", "0.2"}).exit, 0);
  EXPECT_EQ(render("c.exr", {"--deep", folder / "c.deep.exr", "--deep-bins", "2"}).exit, 0);
  const auto size = [&](const char* name) { return std::filesystem::file_size(folder / name); };
  EXPECT_LT(size("b.exr.exr"), size("a.deep.exr"));
  EXPECT_LT(size("c.deep.exr"), size("a.deep.exr"));
}

TEST_F(Deep, FlattenedItIsThePictureWithoutBackground) {
  if (std::system("oiiotool --version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "needs oiiotool; install openimageio-tools";
  }
  for (const char* deep_error : {"0", "0.1"}) {
    ASSERT_EQ(render("a.exr", {"--deep", folder / "a.deep.exr", "--deep-error", deep_error}).exit,
              0);
    ASSERT_EQ(render("b.exr", {"--background", "off"}).exit, 0);
    const std::string command = "oiiotool '" + folder / "a.deep.exr" +
                                "' --flatten --ch R,G,B,A -o '" + folder / "flat.exr" + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const Film flat = formats::read_film(folder / "flat.exr").film;
    const Film wanted = formats::read_film(folder / "b.exr").film;
    ASSERT_EQ(flat.pixels.size(), wanted.pixels.size());
    double light = 0;
    for (std::size_t i = 0; i < flat.pixels.size(); ++i) {
      ASSERT_LE(length(mean(flat.pixels[i]) - mean(wanted.pixels[i])), 1e-5);
      ASSERT_NEAR(flat.pixels[i].alpha, wanted.pixels[i].alpha, 1e-6);
      light += wanted.pixels[i].alpha;
    }
    EXPECT_GT(light, 10);
  }
}

TEST_F(Deep, ConvertFlattensIt) {
  ASSERT_EQ(render("a.exr", {"--deep", folder / "a.deep.exr", "--background", "off"}).exit, 0);
  const RunResult r =
      run_tool(PVOL_CONVERT, {folder / "a.deep.exr", folder / "flat.exr", "--json"});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_NE(r.out.find("flat.exr"), std::string::npos) << r.out;
  const formats::StoredFilm flat = formats::read_film(folder / "flat.exr");
  const formats::StoredFilm wanted = formats::read_film(folder / "a.exr");
  EXPECT_EQ(flat.attributes, wanted.attributes);
  ASSERT_EQ(flat.film.pixels.size(), wanted.film.pixels.size());
  for (std::size_t i = 0; i < wanted.film.pixels.size(); ++i) {
    ASSERT_LE(length(mean(flat.film.pixels[i]) - mean(wanted.film.pixels[i])), 1e-5);
    ASSERT_NEAR(flat.film.pixels[i].alpha, wanted.film.pixels[i].alpha, 1e-6);
  }
  const RunResult again = run_tool(PVOL_CONVERT, {folder / "flat.exr", folder / "b.exr"});
  EXPECT_EQ(again.exit, 1);
  EXPECT_TRUE(says(again.err, "deep.flat_picture_given"));
}

TEST_F(Deep, MisuseIsToldBeforeAnythingIsRendered) {
  const std::string deep = folder / "deep.exr";
  expect_refused(2, {"--deep", folder / "refused.exr"}, "deep.deep_output_same");
  expect_refused(2, {"--deep", folder / "deep.png"}, "deep.output_deep_png");
  expect_refused(2, {"--deep-bins", "8"}, "deep.deep_bins_deep");
  expect_refused(2, {"--deep-error", "0.1"}, "deep.deep_bins_deep");
  expect_refused(2, {"--deep", deep, "--deep-bins", "0"}, "deep.deep_bins_whole_number");
  expect_refused(1, {"--deep", deep, "--tracker", "weighted-delta"},
                 "deep.deep_pictures_count_collisions");
  expect_refused(1, {"--deep", deep, "--size", "1000x1000", "--spp", "1000", "--deep-bins", "1024"},
                 "deep.deep_picture_pixels_bins");
  EXPECT_FALSE(std::filesystem::exists(deep));
}

TEST_F(Deep, ComparisonsOfPicturesSayWhatToDo) {
  ASSERT_EQ(render("a.exr", {"--deep", folder / "a.deep.exr"}).exit, 0);
  const RunResult r = run_tool(PVOL_STATS, {"image", folder / "a.deep.exr", folder / "a.exr"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "deep.deep_pixels_several_samples"));
}

}  // namespace deep_test
}  // namespace pvol
