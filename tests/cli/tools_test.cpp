// The command-line tools: what they accept, refuse, print and leave behind.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"
#include "pvol/version.h"
#include "pvol/volume/best_kernel.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace tools_test {

using nlohmann::json;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

const char* const kTools[] = {
#ifdef PVOL_VIEW
    PVOL_VIEW,
#endif
    PVOL_FIT, PVOL_RENDER, PVOL_STATS, PVOL_CONVERT};

/// A ball of radius 12 around (20, 20, 20), density 1 at its centre and 0 at its surface.
VoxelGrid make_ball() {
  const auto samples = std::make_shared<std::vector<std::array<float, kBrickSamples>>>(125);
  VoxelGrid g;
  g.index_to_world = scaling(Vec3d(0.1));
  for (int b = 0; b < 125; ++b) {
    const Vec3i origin = Vec3i(b / 25, b / 5 % 5, b % 5) * kBrickEdge;
    auto& values = (*samples)[std::size_t(b)];
    for (int s = 0; s < kBrickSamples; ++s) {
      const Vec3i p = origin + Vec3i(s / 64, s / 8 % 8, s % 8);
      values[std::size_t(s)] = std::max(0.0f, 1 - length(Vec3f(p) - Vec3f(20)) / 12);
    }
    g.bricks.push_back({origin, values.data()});
  }
  g.owner = samples;
  return g;
}

std::string write_ball(const ScratchFolder& folder) {
  const VoxelGrid ball = make_ball();
  formats::write_vdb(folder / "ball.vdb", {&ball});
  return folder / "ball.vdb";
}

void expect_same_samples(const VoxelGrid& a, const VoxelGrid& b) {
  for (int x = 6; x < 34; ++x) {
    for (int y = 6; y < 34; ++y) {
      for (int z = 6; z < 34; ++z) {
        ASSERT_EQ(sample(a, {x, y, z}), sample(b, {x, y, z})) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

void expect_usage_error(const char* tool, const std::vector<std::string>& arguments,
                        const std::string& key, const std::vector<std::string>& filled = {}) {
  const RunResult r = run_tool(tool, arguments);
  EXPECT_EQ(r.exit, 2) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find(": error: "), std::string::npos) << r.err;
  EXPECT_TRUE(says(r.err, key, filled));
}

void expect_failure(const char* tool, const std::vector<std::string>& arguments,
                    const std::string& key) {
  const RunResult r = run_tool(tool, arguments);
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find(": error: "), std::string::npos) << r.err;
  EXPECT_TRUE(says(r.err, key));
}

RunResult expect_success(const char* tool, const std::vector<std::string>& arguments) {
  RunResult r = run_tool(tool, arguments);
  EXPECT_EQ(r.exit, 0) << r.err << " signal " << r.signal;
  return r;
}

// --- all tools ----------------------------------------------------------------------------------

TEST(Tools, HelpGoesToStdoutAndEndsWithTwoExamples) {
  for (const char* tool : kTools) {
    const RunResult r = expect_success(tool, {"--help"});
    const auto examples = r.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << tool;
    const std::string name = "\n  " + std::filesystem::path(tool).filename().string() + " ";
    const auto first = r.out.find(name, examples);
    EXPECT_NE(first, std::string::npos) << tool;
    EXPECT_NE(r.out.find(name, first + 1), std::string::npos) << tool;
    EXPECT_EQ(r.err, "");
  }
}

TEST(Tools, VersionIsThatOfTheLibrary) {
  for (const char* tool : kTools) {
    const std::string name = std::filesystem::path(tool).filename().string();
    const std::string out = expect_success(tool, {"--version"}).out;
    EXPECT_TRUE(out.starts_with(name + " " PVOL_VERSION " (")) << out;
    EXPECT_TRUE(out.ends_with(std::string(pvol::name(best_kernel())) + ")\n")) << out;
  }
}

TEST(Tools, MisuseIsToldOnStderrWithStatusTwo) {
  for (const char* tool : kTools) {
    expect_usage_error(tool, {}, "tools.error_required");
    expect_usage_error(tool, {"--no-such-option", "x", "y"}, "tools.error");
  }
}

TEST(Tools, MissingFilesAreNamed) {
  const ScratchFolder folder;
  const std::string none = folder / "none.vdb";
  expect_failure(PVOL_FIT, {none, "-o", folder / "x.pvol"}, "tools.file_missing");
  expect_failure(PVOL_RENDER, {none, "-o", folder / "x.exr"}, "tools.file_missing");
  expect_failure(PVOL_CONVERT, {none, folder / "x.vdb"}, "tools.file_missing");
  expect_failure(PVOL_STATS, {"bounds", none}, "tools.file_missing");
  expect_failure(PVOL_STATS, {"bounds", folder / "none.pvol"}, "tools.read_no_such_directory");
  expect_failure(PVOL_RENDER, {folder / "none.toml", "-o", folder / "x.exr"},
                 "tools.read_check_name");
  EXPECT_TRUE(folder.empty());
}

// --- pvol-fit -----------------------------------------------------------------------------------

TEST(Fit, WritesAFileThatHoldsTheSameSamples) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), pvol = folder / "ball.pvol";
  expect_success(PVOL_FIT, {vdb, "-o", pvol});
  expect_same_samples(formats::load_grid(pvol).grid, make_ball());
}

TEST(Fit, ReportsAsJson) {
  const ScratchFolder folder;
  const RunResult r =
      expect_success(PVOL_FIT, {write_ball(folder), "-o", folder / "ball.pvol", "--json"});
  const json j = json::parse(r.out);
  EXPECT_EQ(j["grid"]["name"], "density");
  EXPECT_EQ(j["bytes"]["total"], std::filesystem::file_size(folder / "ball.pvol"));
  EXPECT_GT(j["bounds"]["leaves"], 8);
}

TEST(Fit, QuietPrintsNothing) {
  const ScratchFolder folder;
  const RunResult r =
      expect_success(PVOL_FIT, {write_ball(folder), "-o", folder / "ball.pvol", "--quiet"});
  EXPECT_EQ(r.out + r.err, "");
}

TEST(Fit, GivesTheSameBytesForAnyNumberOfThreads) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  expect_success(PVOL_FIT, {vdb, "-o", folder / "1.pvol", "--threads", "1"});
  expect_success(PVOL_FIT, {vdb, "-o", folder / "3.pvol", "--threads", "3"});
  EXPECT_EQ(read_text(folder / "1.pvol"), read_text(folder / "3.pvol"));
}

TEST(Fit, ByReferenceReadsTheSourceAgainAndRefusesAChangedOne) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), pvol = folder / "ball.pvol";
  expect_success(PVOL_FIT, {vdb, "-o", pvol, "--density", "reference"});
  EXPECT_LT(std::filesystem::file_size(pvol), std::filesystem::file_size(vdb) / 4);
  expect_same_samples(formats::load_grid(pvol).grid, make_ball());

  const std::vector<std::string> stats{"bounds", pvol};
  std::filesystem::rename(vdb, folder / "gone.vdb");
  expect_failure(PVOL_STATS, stats, "tools.density_ball_vdb");
  std::ofstream(vdb, std::ios::binary) << read_text(folder / "gone.vdb") << 'x';
  expect_failure(PVOL_STATS, stats, "tools.density_ball_vdb_changed");
}

TEST(Tools, NameTheOptionThatWasMeant) {
  const auto refused = [](const std::vector<std::string>& words, const char* message) {
    const RunResult r = run_tool(PVOL_RENDER, words);
    EXPECT_EQ(r.exit, 2);
    EXPECT_TRUE(says(r.err, message));
  };
  refused({"a.vdb", "-o", "a.exr", "--exposur=2"}, "tools.option_meant");
  refused({"a.vdb", "-o", "a.exr", "first", "second"}, "tools.unexpected_in_order");
  refused({"a.vdb", "-o", "a.exr", "--sequence-of-frames"}, "tools.unexpected_alone");
}

TEST(Fit, RefusesWrongNamesBeforeAnyWork) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  expect_usage_error(PVOL_FIT, {vdb, "-o", folder / "x.vdb"}, "tools.output_x_vdb");
  expect_usage_error(PVOL_FIT, {folder / "x.obj", "-o", folder / "x.pvol"}, "tools.input_x_obj");
  expect_usage_error(PVOL_FIT, {vdb, "-o", folder / "x.pvol", "--density", "fp7"},
                     "tools.density_fp7_reference_fp32");
  expect_usage_error(PVOL_FIT, {vdb, "-o", folder / "x.pvol", "--threads", "many"},
                     "tools.threads_many_whole_number");
  expect_failure(PVOL_FIT, {vdb, "-o", folder / "no/x.pvol"}, "tools.no_folder_no");
  expect_failure(PVOL_FIT, {vdb, "-o", folder / "x.pvol", "--grid", "heat"},
                 "tools.no_grid_called");
  EXPECT_FALSE(std::filesystem::exists(folder / "x.pvol"));
}

// --- pvol-stats ---------------------------------------------------------------------------------

TEST(Stats, BoundsAgreeBetweenSourceAndFile) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), pvol = folder / "ball.pvol";
  expect_success(PVOL_FIT, {vdb, "-o", pvol});
  json of_vdb = json::parse(expect_success(PVOL_STATS, {"bounds", vdb, "--json"}).out);
  json of_pvol = json::parse(expect_success(PVOL_STATS, {"bounds", pvol, "--json"}).out);
  EXPECT_EQ(of_pvol["bytes"]["total"], std::filesystem::file_size(pvol));
  of_vdb.erase("file");
  of_pvol.erase("file");
  of_pvol.erase("bytes");
  EXPECT_EQ(of_vdb, of_pvol);
}

TEST(Stats, ExtinctionAddsTheCutOfTheCostModel) {
  const ScratchFolder folder;
  const RunResult r =
      expect_success(PVOL_STATS, {"bounds", write_ball(folder), "--json", "--extinction", "10"});
  const json j = json::parse(r.out);
  EXPECT_DOUBLE_EQ(j["volume"]["largest_extinction"].get<double>(), 10);
  const json& lookups = j["lookups_per_collision"];
  EXPECT_LE(lookups["decomposition_cut"]["even"], lookups["delta_cut"]["even"]);
  // The cut may go on into parts of leaves, whose bounds are tighter.
  EXPECT_LE(lookups["delta_cut"]["even"], lookups["delta_global"]["even"]);
  EXPECT_GE(lookups["delta_cut"]["even"], 1);
}

TEST(Stats, TextHasEveryPart) {
  const ScratchFolder folder;
  const std::string out = expect_success(PVOL_STATS, {"bounds", write_ball(folder)}).out;
  for (const char* key :
       {"tools.depth_depth", "tools.classes_space_root", "tools.expected_look_ups"}) {
    EXPECT_TRUE(says(out, key));
  }
}

TEST(Stats, RefusesMisuse) {
  expect_usage_error(PVOL_STATS, {"shape", "x.vdb"}, "tools.shape_bounds_shells");
  expect_usage_error(PVOL_STATS, {"bounds"}, "tools.required");
  expect_usage_error(PVOL_STATS, {"bounds", "x.vdb", "--extinction", "-1"},
                     "tools.extinction_minus_number_above");
}

// --- pvol-convert -------------------------------------------------------------------------------

TEST(Convert, BringsPvolBackToVdbWithItsBounds) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), pvol = folder / "ball.pvol";
  const std::string back = folder / "back.vdb";
  expect_success(PVOL_FIT, {vdb, "-o", pvol});
  expect_success(PVOL_CONVERT, {pvol, back, "--bounds"});
  expect_same_samples(formats::load_grid(back).grid, make_ball());
  const VoxelGrid hi = formats::load_grid(back, {"majorant", false}).grid;
  const VoxelGrid lo = formats::load_grid(back, {"minorant", false}).grid;
  // The centre (20, 20, 20) of the ball lies in the cube [16, 24)^3, a cube's own centre.
  EXPECT_EQ(sample(hi, {2, 2, 2}), 1.0f);
  EXPECT_GT(sample(lo, {2, 2, 2}), 0.0f);
  EXPECT_EQ(sample(lo, {1, 1, 1}), 0.0f);
  EXPECT_NEAR(hi.index_to_world.point({2, 2, 2}).x, 2.0, 1e-6);
}

TEST(Convert, ListsTheConversionsThereAre) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  expect_usage_error(PVOL_CONVERT, {vdb, folder / "x.obj"}, "tools.no_conversion_vdb");
  expect_usage_error(PVOL_CONVERT, {folder / "x.pbrt", folder / "x.vdb"},
                     "tools.no_conversion_pbrt");
  expect_usage_error(PVOL_CONVERT, {vdb, vdb}, "tools.input_output_same");
}

// --- pvol-render --------------------------------------------------------------------------------

std::vector<std::string> small_render(const std::string& input, const std::string& output) {
  return {input, "-o", output, "--size", "12x8", "--spp", "4", "--quiet"};
}

TEST(Render, WritesExrAndPng) {
  const ScratchFolder folder;
  const RunResult r =
      expect_success(PVOL_RENDER, small_render(write_ball(folder), folder / "a.exr"));
  EXPECT_EQ(r.out + r.err, "");
  EXPECT_EQ(read_text(folder / "a.exr").substr(0, 4), "\x76\x2f\x31\x01");
  EXPECT_EQ(read_text(folder / "a.png").substr(1, 3), "PNG");
}

TEST(Render, WritesOnlyWhatIsAskedFor) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  auto arguments = small_render(vdb, folder / "a.exr");
  arguments.push_back("--no-png");
  expect_success(PVOL_RENDER, arguments);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
  expect_success(PVOL_RENDER, small_render(vdb, folder / "b.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "b.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.exr"));
  arguments.insert(arguments.end(), {"--png", folder / "c.png"});
  expect_usage_error(PVOL_RENDER, arguments, "tools.png_no_png");
}

TEST(Render, KeepsLayersThatItIsAskedFor) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const auto film = [&](const std::vector<std::string>& options) {
    auto arguments = small_render(vdb, folder / "a.exr");
    arguments.insert(arguments.end(), options.begin(), options.end());
    expect_success(PVOL_RENDER, arguments);
    return formats::read_film(folder / "a.exr");
  };
  const auto lookups = [](const Film& f) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < f.pixels.size(); ++i) sum += f.count(i, PixelCounter::lookups);
    return sum;
  };
  const formats::StoredFilm plain = film({});
  EXPECT_FALSE(plain.has_variances);
  EXPECT_EQ(plain.attributes.at("pvol:aov"), "none");
  for (const PixelSums& p : plain.film.pixels) EXPECT_EQ(p.alpha, 1) << "a sky is seen";
  EXPECT_EQ(lookups(plain.film), 0u);

  const formats::StoredFilm all =
      film({"--aov", "lights,lookups,variance,samples", "--micro-bounds", "none"});
  EXPECT_TRUE(all.has_variances);
  EXPECT_EQ(all.film.pixels.front().samples, 4u);
  EXPECT_EQ(all.film.layers.size(), 3u);
  EXPECT_GT(lookups(all.film), 0u) << "counting was on";
  for (std::size_t i = 0; i < all.film.pixels.size(); ++i) {
    EXPECT_EQ(mean(plain.film.pixels[i]), mean(all.film.pixels[i])) << "asking changes nothing";
  }

  const Film clear = film({"--background", "off"}).film;
  EXPECT_LT(clear.pixels.front().alpha, 1);
  auto arguments = small_render(vdb, folder / "b.exr");
  arguments.insert(arguments.end(), {"--aov", "samples,varience"});
  expect_usage_error(PVOL_RENDER, arguments, "tools.aov_samples_varience");
  arguments.back() = "samples";
  arguments.insert(arguments.end(), {"--compression", "dwaa"});
  expect_usage_error(PVOL_RENDER, arguments, "tools.compression_multipart_compression");
  EXPECT_FALSE(std::filesystem::exists(folder / "b.exr"));
}

TEST(Render, RefusesForAPngWhatItCannotHold) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const std::vector<std::vector<std::string>> all{{"--aov", "depth"},
                                                  {"--denoise-layers"},
                                                  {"--multipart"},
                                                  {"--pixel-type", "half"},
                                                  {"--compression", "piz"}};
  for (const std::vector<std::string>& more : all) {
    std::vector<std::string> line = small_render(vdb, folder / "a.png");
    line.insert(line.end(), more.begin(), more.end());
    expect_usage_error(PVOL_RENDER, line, "tools.png_holds_colours");
  }
}

/// Before it renders.
TEST(Render, RefusesOutputsThatCannotBeWritten) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const auto refusal = [&](const std::string& name) {
    const RunResult r = run_tool(PVOL_RENDER, small_render(vdb, folder / name));
    EXPECT_EQ(r.exit, 1) << name;
    return r.err;
  };
  ASSERT_EQ(mkfifo((folder / "pipe.exr").c_str(), 0600), 0);
  EXPECT_TRUE(says(refusal("pipe.exr"), "output.is_a_pipe"));
  std::filesystem::create_symlink("/dev/full", folder / "full.exr");
  EXPECT_TRUE(says(refusal("full.exr"), "output.is_a_device"));
  EXPECT_TRUE(says(refusal(std::string(252, 'n') + ".exr"), "output.name_is_long"));
  std::filesystem::create_symlink("loop.exr", folder / "loop.exr");
  EXPECT_TRUE(says(refusal("loop.exr"), "output.links_to_itself"));
}

TEST(Render, WarnsOfWhatHalfDoesNotHold) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a.exr");
  arguments.insert(arguments.end(), {"--pixel-type", "half", "--set",
                                     "environment={type=\"constant\",radiance=1e6}"});
  EXPECT_TRUE(says(expect_success(PVOL_RENDER, arguments).err, "tools.values_exceed_largest"));
}

TEST(Render, LivePageReloadsUntilTheEnd) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a b.exr");
  const std::string reload = "http-equiv=\"refresh\"";
  arguments.push_back("--live");
  expect_success(PVOL_RENDER, arguments);
  const std::string page = read_text(folder / "a b.html");
  EXPECT_EQ(page.find(reload), std::string::npos) << page;
  EXPECT_NE(page.find("<img src=\"a%20b.png?"), std::string::npos) << page;
  EXPECT_TRUE(says(page, "tools.page_done"));
  EXPECT_EQ(read_text(folder / "a b.png").substr(1, 3), "PNG");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()),
                          std::filesystem::directory_iterator{}),
            4)
      << "the cloud, two pictures and the page";
  arguments.push_back("--no-png");
  expect_usage_error(PVOL_RENDER, arguments, "tools.live_needs_png");
}

TEST(Render, LivePageShowsThePictureMeanwhile) {
  const ScratchFolder folder;
  const std::string html = folder / "a.html";
  std::string meanwhile;
  const RunResult r = run_tool(PVOL_RENDER,
                               {write_ball(folder), "-o", folder / "a.png", "--size", "64x48",
                                "--spp", "4000000000", "--live"},
                               [&](int pid, const std::string&) {
                                 if (!meanwhile.empty() || !std::filesystem::exists(html)) return;
                                 meanwhile = read_text(html) + read_text(folder / "a.png");
                                 kill(pid, SIGINT);
                               });
  EXPECT_EQ(r.exit, 1) << r.err;
  for (const char* text : {"http-equiv=\"refresh\"", "IEND"}) {
    EXPECT_NE(meanwhile.find(text), std::string::npos) << text;
  }
  EXPECT_TRUE(says(meanwhile.substr(0, meanwhile.find("</html>")), "tools.page_meanwhile"));
  const std::string page = read_text(html);
  EXPECT_NE(page.find("<p>interrupted: "), std::string::npos) << page;
  EXPECT_EQ(page.find("refresh"), std::string::npos) << page;
}

TEST(Render, SaysWhatItWrote) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), exr = folder / "a.exr", png = folder / "a.png";
  const auto expect_end = [&](const std::string& output, const char* option,
                              const std::string& end) {
    auto arguments = small_render(vdb, output);
    arguments.back() = option;  // instead of --quiet
    const std::string err = expect_success(PVOL_RENDER, arguments).err;
    EXPECT_TRUE(err.ends_with(end)) << err;
  };
  expect_end(exr, "--no-png", "; wrote " + exr + "\n");
  expect_end(png, "--shells=auto", "; wrote " + png + "\n");
  expect_end(exr, "--shells=auto", "; wrote " + exr + " and " + png + "\n");
}

TEST(Render, GivesTheSameBytesForAnyNumberOfThreads) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  for (const char* threads : {"1", "2", "7"}) {
    auto arguments = small_render(vdb, folder / (std::string(threads) + ".exr"));
    arguments.insert(arguments.end(), {"--threads", threads});
    expect_success(PVOL_RENDER, arguments);
  }
  EXPECT_EQ(read_text(folder / "1.exr"), read_text(folder / "2.exr"));
  EXPECT_EQ(read_text(folder / "1.exr"), read_text(folder / "7.exr"));
  EXPECT_EQ(read_text(folder / "1.png"), read_text(folder / "7.png"));
}

TEST(Render, StatsHoldTheNamesThatScriptsRelyOn) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a.exr");
  arguments.insert(arguments.end(), {"--stats", "-"});
  const json j = json::parse(expect_success(PVOL_RENDER, arguments).out);
  for (const char* key :
       {"samples", "cpu_seconds", "wall_seconds", "lookups_path", "lookups_shadow",
        "bounds_tests_path", "bounds_tests_shadow", "segments_path", "segments_shadow",
        "collisions", "null_collisions", "shadow_rays", "mean_rgb", "variance_rgb", "options"}) {
    EXPECT_TRUE(j.contains(key)) << key;
  }
  EXPECT_EQ(j["samples"], 12 * 8 * 4);
  EXPECT_GT(j["collisions"], 0);
  EXPECT_GT(j["mean_rgb"][0], 0);
}

TEST(Render, PrintedSceneMakesTheSamePicture) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), scene = folder / "scene.toml";
  auto arguments = small_render(vdb, folder / "a.png");
  arguments.insert(arguments.end(), {"--set", "medium.g=0.25"});
  expect_success(PVOL_RENDER, arguments);
  arguments.push_back("--print-scene");
  const std::string text = expect_success(PVOL_RENDER, arguments).out;
  EXPECT_NE(text.find("0.25"), std::string::npos);
  std::ofstream(scene) << text;
  expect_success(PVOL_RENDER, {scene, "-o", folder / "b.png", "--quiet"});
  EXPECT_EQ(read_text(folder / "a.png"), read_text(folder / "b.png"));
}

/// Flags for the camera that frames the clouds and values of --set, in either order.
TEST(Render, FlagsOfTheViewGoWithSets) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const auto print = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {vdb, "--print-scene"});
    return expect_success(PVOL_RENDER, arguments).out;
  };
  struct Case {
    const char *flag, *value;
    std::vector<std::string> sets;
  };
  const Case cases[] = {{"--view", "45,20", {"camera.azimuth=45", "camera.elevation=20"}},
                        {"--view", "side", {"camera.azimuth=90", "camera.elevation=0"}},
                        {"--zoom", "1.5", {"camera.zoom=1.5"}},
                        {"--fov", "20", {"camera.fov=20"}},
                        {"--up", "z", {"world.up=\"z\""}}};
  for (const Case& c : cases) {
    std::vector<std::string> all{"--set", "medium.g=0.25"};
    for (const std::string& set : c.sets) all.insert(all.end(), {"--set", set});
    const std::string expected = print(all);
    EXPECT_NE(expected.find("g = 0.25"), std::string::npos) << expected;
    EXPECT_EQ(print({c.flag, c.value, "--set", "medium.g=0.25"}), expected) << c.flag;
    EXPECT_EQ(print({"--set", "medium.g=0.25", c.flag, c.value}), expected) << c.flag;
  }
}

TEST(Render, RefusesViewsThatAreNone) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  for (const char* view : {"foo", "10", "10,", "x,20", "10,91", "400,0", "1,2,3", ""}) {
    expect_usage_error(PVOL_RENDER, {vdb, "--print-scene", "--view", view}, "tools.view");
  }
}

/// A scene of the ball at many places.
std::string write_sky(const ScratchFolder& folder, int count) {
  std::string text = "[volume]\nfile = \"ball.vdb\"\n";
  for (int i = 0; i < count; ++i) {
    text += "[[volume.instance]]\ntranslate = [" + std::to_string(i % 32 * 3) + ", 0, " +
            std::to_string(i / 32 * 3) + "]\n";
  }
  std::ofstream(folder / "sky.toml") << text << "[render]\nsize = [32, 8]\nspp = 2\n";
  return folder / "sky.toml";
}

/// An error names what was typed, not the key that it sets.
TEST(Render, ErrorsNameTheFlagOfTheView) {
  const ScratchFolder folder;
  write_ball(folder);
  std::ofstream(folder / "placed.toml")
      << "[volume]\nfile = \"ball.vdb\"\n[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n";
  for (const std::string flag : {"--view side", "--zoom 2"}) {
    const std::size_t blank = flag.find(' ');
    const RunResult r = run_tool(PVOL_RENDER, {folder / "placed.toml", "-o", folder / "a.exr",
                                               flag.substr(0, blank), flag.substr(blank + 1)});
    EXPECT_EQ(r.exit, 2);
    EXPECT_TRUE(says(r.err, "tools.flag_of_the_view", {flag}));
  }
}

TEST(Render, AThousandInstancesAreOneVolumeInWords) {
  const ScratchFolder folder;
  write_ball(folder);
  const std::string sky = write_sky(folder, 1000);
  const RunResult r =
      run_tool(PVOL_RENDER, {sky, "-o", folder / "a.exr", "--stats", folder / "a.json"});
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "tools.instances_first_x"));
  EXPECT_LT(std::count(r.err.begin(), r.err.end(), '\n'), 30);
  const std::string text = read_text(folder / "a.json");
  EXPECT_EQ(json::parse(text)["options"]["volumes"].at(0)["instances"], 1000);
  EXPECT_LT(text.size(), 10'000u);
  EXPECT_NO_THROW((void)formats::read_film(folder / "a.exr")) << "the header has them all";
  std::ofstream(folder / "printed.toml") << run_tool(PVOL_RENDER, {sky, "--print-scene"}).out;
  ASSERT_EQ(run_tool(PVOL_RENDER, {folder / "printed.toml", "-o", folder / "b.exr"}).exit, 0);
  EXPECT_EQ(read_text(folder / "a.png"), read_text(folder / "b.png"));
}

TEST(Render, AliasesOfAFileAreReadOnce) {
  const ScratchFolder folder;
  write_ball(folder);
  std::ofstream(folder / "two.toml") << "[[volume]]\nfile = \"ball.vdb\"\n[[volume]]\nfile = "
                                        "\"ball.vdb\"\n[volume.medium]\ntranslate = [3, 0, 0]\n"
                                        "scale = 2\n[render]\nsize = [16, 8]\nspp = 2\n";
  const RunResult r = run_tool(PVOL_RENDER, {folder / "two.toml", "-o", folder / "a.exr"});
  ASSERT_EQ(r.exit, 0) << r.err;
  EXPECT_EQ(times_said(r.err, "tools.extinction_chosen"), 2) << "each by its own place: " << r.err;
}

TEST(Render, ErrorsNameTheInstance) {
  const ScratchFolder folder;
  write_ball(folder);
  std::ofstream(folder / "far.toml")
      << "[volume]\nfile = \"ball.vdb\"\n[[volume.instance]]\n[[volume.instance]]\n"
         "translate = [1e15, 0, 0]\n";
  const RunResult r = run_tool(PVOL_RENDER, {folder / "far.toml", "-o", folder / "a.exr"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "tools.cloud_lies_far"));
}

TEST(Render, ChoosesAnExtinctionAndSaysWhich) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const std::vector<std::string> arguments{vdb,     "-o", folder / "a.png", "--size", "2x2",
                                           "--spp", "1"};
  const std::string told = expect_success(PVOL_RENDER, arguments).err;
  EXPECT_TRUE(says(told, "tools.extinction_chosen"));
  EXPECT_TRUE(says(told, "tools.largest_extinction_per"));
  auto given = arguments;
  given.insert(given.end(), {"--set", "medium.extinction=2"});
  EXPECT_EQ(times_said(expect_success(PVOL_RENDER, given).err, "tools.extinction_chosen"), 0);
}

TEST(Render, BiasedOptionsSayThatTheyAre) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const auto report = [&](const std::vector<std::string>& more) {
    auto arguments = small_render(vdb, folder / "a.exr");
    arguments.insert(arguments.end(), {"--stats", "-"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_success(PVOL_RENDER, arguments).out);
  };
  EXPECT_EQ(report({})["options"]["biased"], "no");
  EXPECT_EQ(report({"--max-bounces", "3"})["options"]["biased"], "yes: max_bounces");
  const json homogeneous = report({"--homogenise", "1e9"});
  EXPECT_EQ(homogeneous["options"]["biased"], "yes: homogenise");
  EXPECT_EQ(homogeneous["lookups_path"], 0);
  EXPECT_GT(homogeneous["options"]["homogenised"]["depth_error_bound"], 0);
  const json preview = report({"--preview", "1", "--homogenise", "0.5"});
  EXPECT_EQ(preview["options"]["biased"], "yes: homogenise, preview");
  EXPECT_NE(read_text(folder / "a.exr").find("yes: homogenise, preview"), std::string::npos);
}

TEST(Render, MajorantsCanBeScaledForTrackersThatBearIt) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a.exr");
  arguments.insert(arguments.end(), {"--majorant-scale", "0.5"});
  expect_failure(PVOL_RENDER, arguments, "tools.majorant_scale_outside");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.exr"));
  arguments.insert(arguments.end(), {"--tracker", "weighted-delta"});
  arguments.insert(arguments.end(), {"--set", "medium.extinction=100"});
  expect_failure(PVOL_RENDER, arguments, "tools.weights_grow_without_bound");
  arguments.back() = "medium.extinction=0.5";
  expect_success(PVOL_RENDER, arguments);
}

TEST(Render, NumbersAreNumbers) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  for (const char* option : {"--homogenise", "--majorant-scale", "--density-tolerance"}) {
    for (const char* value : {"nan", "inf", "-1"}) {
      auto arguments = small_render(vdb, folder / "a.exr");
      arguments.insert(arguments.end(), {"--density", "fpn", option, value});
      expect_usage_error(PVOL_RENDER, arguments, "tools.option_not_a_number", {option, value});
    }
  }
  // An option with a value does not take the name that follows.
  expect_success(PVOL_RENDER, {"--set", "medium.g=0.1", vdb, "-o", folder / "b.png", "--size",
                               "4x4", "--spp", "1", "--quiet"});
}

TEST(Render, TakesSamplesUntilANoiseOrATime) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder), exr = folder / "a.exr";
  const auto stats = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {vdb,     "-o",       exr,       "--size",
                                          "24x16", "--no-png", "--stats", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const RunResult r = expect_success(PVOL_RENDER, arguments);
    EXPECT_TRUE(says(r.err, "tools.adaptive_samples_until"));
    return json::parse(r.out);
  };
  const json by_noise = stats({"--noise", "0.03"});
  EXPECT_NEAR(by_noise.at("pixel_noise").get<double>(), 0.03, 0.006);
  EXPECT_GT(by_noise.at("samples"), 24 * 16 * 16);
  const std::string bytes = read_text(exr);
  EXPECT_EQ(stats({"--noise", "0.03", "--threads", "1"}).at("samples"), by_noise.at("samples"));
  const json by_time = stats({"--time", "0.001", "--noise", "0.0001"});
  EXPECT_GE(by_time.at("samples"), 24 * 16) << "a whole picture";
  EXPECT_TRUE(by_time.at("pixel_noise").is_null() || by_time.at("pixel_noise") > 0.0001);
}

TEST(Render, RefusesMisuse) {
  const ScratchFolder folder;
  const std::string vdb = write_ball(folder);
  const auto refuse = [&](const std::vector<std::string>& more, const std::string& mentions) {
    auto arguments = small_render(vdb, folder / "a.exr");
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_usage_error(PVOL_RENDER, arguments, mentions);
  };
  refuse({"--crop", "1,2,3"}, "tools.crop_array_whole");
  refuse({"--size", "64x48", "--crop", "60,40,10,10"}, "tools.crop_outside");
  refuse({"--resume", "--no-resume"}, "tools.resume_both");
  refuse({"--noise", "0"}, "tools.noise_off_number");
  refuse({"--noise", "1.5"}, "tools.noise_off_number");
  refuse({"--time", "-1"}, "tools.time_minus_off_number");
  const RunResult one_pixel =
      run_tool(PVOL_RENDER, {vdb, "-o", folder / "a.exr", "--noise", "0.1", "--size", "1x1"});
  EXPECT_EQ(one_pixel.exit, 2);
  EXPECT_TRUE(says(one_pixel.err, "tools.noise_of_one_pixel"));
  refuse({"--aov", "depht"}, "tools.aov_depht_none_transmittance");
  refuse({"--tracker", "fast"}, "tools.tracker_fast_delta_global");
  refuse({"--max-bounces", "-1"}, "tools.max_bounces_minus_none_whole");
  refuse({"--depth", "24"}, "tools.depth_auto_whole");
  refuse({"--background", "maybe"}, "tools.background_maybe_off");
  refuse({"--seed", "-3"}, "tools.seed_minus_whole_number");
  refuse({"--stats", "counts.txt"}, "tools.output_counts_txt");
  expect_usage_error(PVOL_RENDER, {vdb, "-o", folder / "a.exr", "--size", "0x4"},
                     "tools.size_0x4_whole_number");
  expect_usage_error(PVOL_RENDER, {vdb, "-o", folder / "a.exr", "--spp", "0"},
                     "tools.spp_whole_number");
  expect_usage_error(PVOL_RENDER, {vdb, "-o", folder / "a.jpg"}, "tools.output_jpg_ends");
  expect_usage_error(PVOL_RENDER, {vdb}, "tools.output_required_picture");
  auto arguments = small_render(vdb, folder / "a.exr");
  arguments.insert(arguments.end(), {"--set", "medium.colour=1"});
  expect_usage_error(PVOL_RENDER, arguments, "tools.set_no_key_medium_colour");
}

/// Sends an interruption once a first picture is there, and a pilot has ended if there is one,
/// however long that took: from then on, progress is told in percent.
RunResult interrupt_render(const std::vector<std::string>& arguments) {
  bool sent = false;
  return run_tool(PVOL_RENDER, arguments, [&](int pid, const std::string& err) {
    const std::size_t rendering = err.find("\nrendering ");
    if (sent || rendering == err.npos || err.find("noise ", rendering) == err.npos) return;
    sent = kill(pid, SIGINT) == 0;
  });
}

TEST(Render, InterruptedRenderSavesWhatItHas) {
  const ScratchFolder folder;
  const std::string exr = folder / "a.exr";
  const RunResult r =
      interrupt_render({write_ball(folder), "-o", exr, "--size", "64x48", "--spp", "4000000000"});
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(says(r.err, "tools.interrupted_after_samples"));
  EXPECT_TRUE(std::filesystem::exists(exr));
  EXPECT_NE(read_text(exr).find("pvol:samples"), std::string::npos);
}

TEST(Render, InterruptedRenderAdaptiveSavesAWholePicture) {
  const ScratchFolder folder;
  const std::string exr = folder / "a.exr";
  const RunResult r =
      interrupt_render({write_ball(folder), "-o", exr, "--size", "64x48", "--noise", "1e-6"});
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(says(r.err, "tools.interrupted_after_samples"));
  EXPECT_EQ(r.err.find(" of 0 "), std::string::npos) << r.err;
  EXPECT_TRUE(std::filesystem::exists(exr));
}

TEST(Render, SamplesOfTheCommandLineReplaceANoiseOfTheScene) {
  const ScratchFolder folder;
  const std::string scene = folder / "scene.toml";
  std::ofstream(scene) << "[volume]\nfile = \"" << write_ball(folder)
                       << "\"\n[render]\nsize = [24, 16]\nnoise = 0.5\ntime = 3\n";
  const auto samples = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {scene, "-o", folder / "a.png", "--quiet", "--stats", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_success(PVOL_RENDER, arguments).out).at("samples").get<int>();
  };
  EXPECT_EQ(samples({"--spp", "3"}), 24 * 16 * 3);
  EXPECT_GE(samples({"--spp", "3", "--noise", "0.4"}), 24 * 16 * 16) << "--noise replaces --spp";
}

/// Their readers would wait for a writer, where it is a file that is read from several places.
TEST(Tools, PipesAreRefused) {
  const ScratchFolder folder;
  const std::string ball = write_ball(folder);
  for (const char* name : {"h.pvol", "h.vdb", "h.exr"}) {
    ASSERT_EQ(mkfifo((folder / name).c_str(), 0600), 0);
  }
  for (const char* name : {"h.pvol", "h.vdb"}) {
    expect_failure(PVOL_RENDER, {folder / name, "-o", folder / "x.exr"}, "tools.pipe");
  }
  auto arguments = small_render(ball, folder / "x.exr");
  arguments.insert(arguments.end(), {"--set", "environment.file=" + (folder / "h.exr")});
  expect_failure(PVOL_RENDER, arguments, "tools.pipe");
}

TEST(Tools, FilesThatCannotBeLookedAtAreNamed) {
  const ScratchFolder folder;
  const std::string name = folder / (std::string(300, 'x') + ".vdb");
  expect_failure(PVOL_RENDER, {name, "-o", folder / "x.exr"}, "tools.name_too_long");
  expect_failure(PVOL_RENDER, {folder.path().string(), "-o", folder / "x.exr"}, "tools.is_folder");
}

TEST(Render, WarnsOfABlackPicture) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a.exr");
  EXPECT_FALSE(says(expect_success(PVOL_RENDER, arguments).err, "tools.black"));
  arguments.insert(arguments.end(), {"--set", "ball=[{centre=[0,0,0],radius=1e4}]"});
  EXPECT_TRUE(says(expect_success(PVOL_RENDER, arguments).err, "tools.black"));
}

TEST(Render, TheLastOfRepeatedOptionsCounts) {
  const ScratchFolder folder;
  auto arguments = small_render(write_ball(folder), folder / "a.exr");
  arguments.insert(arguments.end(), {"--spp", "3", "--spp", "5", "--stats", "-"});
  const json j = json::parse(expect_success(PVOL_RENDER, arguments).out);
  EXPECT_EQ(j.at("options").at("spp"), 5) << j.dump(1);
}

TEST(Stats, UnknownVerbsAreNamed) {
  expect_usage_error(PVOL_STATS, {"bouds", "a.vdb"}, "tools.bouds_bounds_shells");
}

TEST(Fit, NamesWhatGzipHides) {
  const ScratchFolder folder;
  const std::string vdb = folder / "a.vdb", nvdb = folder / "a.nvdb";
  for (const std::string& file : {vdb, nvdb}) {
    std::ofstream(file, std::ios::binary) << "\x1f\x8b\x08 and so on";
    expect_failure(PVOL_FIT, {file, "-o", folder / "a.pvol"}, "tools.gzip_content");
  }
  expect_failure(PVOL_RENDER, {folder / "a.vdb.gz", "-o", folder / "a.exr"}, "tools.gzip_name");
}

}  // namespace tools_test
}  // namespace pvol
