// Parts of pictures through the tools: rendered anywhere, merged to the bytes of one render.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "pvol/formats/film_file.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace merge_test {

using testing::operator+;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

class Merge : public ::testing::Test {
 protected:
  Merge() {
    std::ofstream(ball_) << "[recipe]\nresolution = 40\n[[form]]\nshape = \"ellipsoid\"\n"
                            "centre = [0, 0, 0]\nradii = 1\n";
  }

  /// Renders to NAME.exr.
  void render(const std::string& name, const Words& more) {
    const RunResult r = run_tool(PVOL_RENDER, Words{ball_, "-o", exr(name), "--size", "40x30",
                                                    "--set", "medium.extinction=8", "--quiet"} +
                                                  more);
    ASSERT_EQ(r.exit, 0) << r.err;
  }
  RunResult merge(const std::string& name, const Words& parts, const Words& more = {}) {
    Words line{"merge"};
    for (const std::string& p : parts) line.push_back(exr(p));
    return run_tool(PVOL_CONVERT, line + Words{"-o", exr(name)} + more);
  }
  void expect_refused(const Words& parts, const std::string& key, const Words& more = {}) {
    const RunResult r = merge("refused", parts, more);
    EXPECT_EQ(r.exit, 1) << r.err;
    EXPECT_TRUE(says(r.err, key));
    EXPECT_FALSE(std::filesystem::exists(exr("refused")));
  }
  [[nodiscard]] std::string exr(const std::string& name) const { return folder_ / (name + ".exr"); }
  void expect_same(const std::string& a, const std::string& b) {
    EXPECT_TRUE(read_text(exr(a)) == read_text(exr(b))) << a << ' ' << b;
  }

  ScratchFolder folder_;
  std::string ball_ = folder_ / "ball.toml";
};

/// Samples in three ranges, one of them in two rectangles.
const Words kParts[] = {{"--samples", "0:3"},
                        {"--samples", "3:4"},
                        {"--samples", "4:12", "--crop", "0,0,17,30"},
                        {"--samples", "4:12", "--crop", "17,0,23,30"}};

std::string part_name(std::size_t k) { return {'p', char('0' + k)}; }

TEST_F(Merge, GivesTheBytesOfOneRenderInAnyOrderAndGrouping) {
  const std::pair<const char*, Words> kinds[] = {
      {"plain", {}},
      {"layers",
       {"--aov", "lights,halves,depth,nearest,position,variance,samples,lookups", "--pixel-type",
        "half"}},
      {"multipart", {"--multipart", "--aov", "variance", "--compression", "piz"}},
      {"guided", {"--guide", "on", "--kernel", "scalar", "--background", "off"}},
      {"denoised", {"--denoise"}}};
  for (const auto& [kind, given] : kinds) {
    const Words options = given + Words{"--spp", "12"};
    render("one", options);
    for (std::size_t k = 0; k < std::size(kParts); ++k) {
      render(part_name(k), options + kParts[k]);
    }
    ASSERT_EQ(merge("all", {"p3", "p0", "p2", "p1"}).exit, 0);
    expect_same("all", "one");
    EXPECT_TRUE(read_text(folder_ / "all.png") == read_text(folder_ / "one.png")) << kind;
    ASSERT_EQ(merge("a", {"p3", "p0"}, {"--partial"}).exit, 0);
    ASSERT_EQ(merge("b", {"p1", "a"}, {"--partial"}).exit, 0);
    ASSERT_EQ(merge("grouped", {"p2", "b"}).exit, 0);
    expect_same("grouped", "one");
    render("sums", options + Words{"--sums", "on"});
    ASSERT_EQ(merge("all_sums", {"p2", "b"}, {"--sums", "on"}).exit, 0);
    expect_same("all_sums", "sums");
  }
}

TEST_F(Merge, OfSamplesAdaptiveGoesByAPilotOfTheWhole) {
  const Words noise{"--noise", "0.04"};
  render("one", noise);
  render("pilot_1", noise + Words{"--samples", "0:16", "--crop", "0,0,40,11"});
  render("pilot_2", noise + Words{"--samples", "0:16", "--crop", "0,11,40,19"});
  expect_refused({"pilot_1", "pilot_2"}, "parts.no_part_adaptive");
  ASSERT_EQ(merge("pilot", {"pilot_2", "pilot_1"}, {"--partial"}).exit, 0);
  const Words go_on = noise + Words{"--pilot", exr("pilot")};
  render("p1", go_on + Words{"--crop", "0,0,13,30"});
  render("p2", go_on + Words{"--crop", "13,0,27,7"});
  render("p3", go_on + Words{"--crop", "13,7,27,23"});
  ASSERT_EQ(merge("whole", {"p2", "p1", "p3"}).exit, 0);
  expect_same("whole", "one");
  expect_refused({"p2", "p1"}, "parts.no_part_adaptive_samples");
  expect_refused({"p2", "p1", "p3", "pilot"}, "parts.pilot_exr_both_adaptive");
}

TEST_F(Merge, OfSeedsHasTheVarianceOfTheWhole) {
  const Words options{"--spp", "8", "--aov", "variance,samples"};
  for (const char* seed : {"1", "2", "3"}) {
    render(std::string("seed").append(seed), options + Words{"--seed", seed, "--sums", "on"});
  }
  ASSERT_EQ(merge("whole", {"seed3", "seed1", "seed2"}).exit, 0);
  const formats::StoredFilm whole = formats::read_film(exr("whole"));
  EXPECT_EQ(whole.attributes.at("pvol:seeds"), "[1,2,3]");
  EXPECT_EQ(whole.attributes.at("pvol:samples"), "28800 of 28800");
  Film sum = formats::read_film_file(exr("seed1")).film;
  for (const char* name : {"seed2", "seed3"}) {
    add_samples(sum, formats::read_film_file(exr(name)).film);
  }
  for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
    EXPECT_EQ(whole.film.pixels[i].samples, 24u);
    EXPECT_EQ(Vec3f(mean(whole.film.pixels[i])), Vec3f(mean(sum.pixels[i])));
    const Vec3d found = variance_of_mean(whole.film.pixels[i]),
                expected = variance_of_mean(sum.pixels[i]);
    EXPECT_NEAR(found.y, expected.y, 1e-5 * expected.y);
  }
}

TEST_F(Merge, AddsSamplesToAFinishedPicture) {
  const Words options{"--guide", "off", "--aov", "variance"};
  render("first", options + Words{"--spp", "5", "--sums", "on"});
  render("more", options + Words{"--spp", "12", "--samples", "5:12"});
  render("one", options + Words{"--spp", "12"});
  expect_refused({"more"}, "parts.no_part_samples_pixel");
  ASSERT_EQ(merge("whole", {"more", "first"}).exit, 0);
  expect_same("whole", "one");
}

TEST_F(Merge, RefusesPartsOfOtherPictures) {
  const Words options{"--spp", "12", "--samples", "0:3"};
  render("a", options);
  render("other_scene", options + Words{"--set", "medium.g=0.2"});
  render("other_size", options + Words{"--size", "41x30"});
  render("other_layers", options + Words{"--aov", "depth"});
  render("filtered", options + Words{"--denoise"});
  render("adaptive", {"--noise", "0.1", "--samples", "0:16"});
  render("plain", {"--spp", "12"});
  expect_refused({"a", "other_scene"}, "parts.other_scene");
  expect_refused({"a", "other_size"}, "parts.other_size_exr_not_parts");
  expect_refused({"a", "other_layers"}, "parts.other_layers_exr_not_parts");
  expect_refused({"a", "filtered"}, "parts.filtered_exr_not_parts");
  expect_refused({"a", "adaptive"}, "parts.adaptive_exr_not_parts");
  expect_refused({"a", "plain"}, "parts.no_exact_sums");
  std::ofstream(ball_, std::ios::app) << "# the same cloud, another file\n";
  render("changed", {"--spp", "12", "--samples", "3:12"});
  expect_refused({"a", "changed"}, "parts.not_parts_picture");
}

TEST_F(Merge, RefusesSamplesThatAreMissingOrThereTwice) {
  const Words options{"--spp", "12"};
  for (std::size_t k = 0; k < std::size(kParts); ++k) {
    render(part_name(k), options + kParts[k]);
  }
  expect_refused({"p0", "p1", "p2"}, "parts.no_part_of_pixel");
  expect_refused({"p0", "p2", "p3"}, "parts.no_part_samples_3");
  expect_refused({"p0", "p1", "p2", "p3", "p1"}, "parts.p1_exr_both_samples");
  render("late", options + Words{"--samples", "11:12"});
  expect_refused({"p0", "p1", "p2", "p3", "late"}, "parts.late_exr_both_samples", {"--partial"});
  // Other random numbers do not overlap, but have to be whole, too.
  render("seed", options + Words{"--seed", "2", "--samples", "0:3"});
  expect_refused({"p0", "p1", "p2", "p3", "seed"}, "parts.no_part_of_seed");
}

TEST_F(Merge, OfWhatIsThereSaysHowMuch) {
  render("p0", {"--spp", "12", "--samples", "0:3", "--crop", "5,6,10,8"});
  ASSERT_EQ(merge("some", {"p0"}, {"--partial"}).exit, 0);
  const formats::PictureHeader h = formats::read_picture_header(exr("some"));
  EXPECT_EQ(h.attributes.at("pvol:samples"), "240 of 14400");
  EXPECT_TRUE(h.has_sums);
  EXPECT_EQ(h.window.crop_width, 10);
  EXPECT_EQ(h.window.width, 40);
}

TEST_F(Merge, OfACropMakesThatCrop) {
  const Words options{"--spp", "4"};
  render("one", options + Words{"--crop", "4,4,20,10"});
  render("left", options + Words{"--crop", "4,4,9,10"});
  render("right", options + Words{"--crop", "13,4,11,10"});
  expect_refused({"left", "right"}, "parts.no_part_samples");
  ASSERT_EQ(merge("crop", {"right", "left"}, {"--crop", "4,4,20,10"}).exit, 0);
  expect_same("crop", "one");
  EXPECT_EQ(merge("x", {"left"}, {"--crop", "4,4,90,10"}).exit, 2);
}

TEST_F(Merge, TellsWrongUse) {
  render("p0", {"--spp", "12", "--samples", "0:3"});
  const std::pair<Words, const char*> lines[] = {
      {{"merge"}, "parts.convert_merge_error_part"},
      {{"merge", exr("p0")}, "parts.convert_merge_error"},
      {{"merge", exr("p0"), "-o", folder_ / "a.vdb"}, "parts.output_vdb_ends"},
      {{"merge", exr("p0"), "-o", exr("p0")}, "parts.both_part_output"},
      {{"merge", exr("p0"), "-o", exr("a"), "--png", folder_ / "a.png", "--no-png"},
       "parts.png_no_png"}};
  for (const auto& [line, key] : lines) {
    const RunResult r = run_tool(PVOL_CONVERT, line);
    EXPECT_EQ(r.exit, 2) << r.err;
    EXPECT_TRUE(says(r.err, key));
  }
  EXPECT_EQ(run_tool(PVOL_CONVERT, {"merge", exr("none"), "-o", exr("a")}).exit, 1);
  EXPECT_NE(run_tool(PVOL_CONVERT, {"merge", "--help"}).out.find("--partial"), std::string::npos);
}

}  // namespace merge_test
}  // namespace pvol
