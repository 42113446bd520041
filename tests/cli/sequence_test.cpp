// Sequences of frames through the tools: names, choices that all frames share, and what stays where
// one of them fails.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "pvol/formats/film_file.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace sequence_test {

using nlohmann::json;
using testing::operator+;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

/// A cloud that grows and becomes denser from frame to frame.
std::string recipe(int frame) {
  return fmt::format(
      "[recipe]\nresolution = 20\ndensity = {}\n[[form]]\nshape = \"ellipsoid\"\n"
      "centre = [0, 0, 0]\nradii = {}\n",
      0.5 * frame, frame);
}

/// smoke.0001.toml to smoke.0003.toml, and runs of the tools on them.
struct Sequence : ::testing::Test {
  ScratchFolder folder;
  std::string smoke = folder / "smoke.####.toml", exr = folder / "a.####.exr";

  Sequence() {
    for (const int frame : {1, 2, 3}) std::ofstream(at("smoke", frame, "toml")) << recipe(frame);
  }

  /// The name of a file of a frame.
  [[nodiscard]] std::string at(const std::string& name, int frame, const std::string& kind) const {
    return folder / fmt::format("{}.{:04}.{}", name, frame, kind);
  }
  [[nodiscard]] bool exists(const std::string& file) const {
    return std::filesystem::exists(folder / file);
  }

  RunResult run(const char* tool, const Words& arguments, int exit = 0) const {
    RunResult r = run_tool(tool, arguments);
    EXPECT_EQ(r.exit, exit) << r.err << " signal " << r.signal;
    return r;
  }
  RunResult render(const std::string& input, const Words& more, int exit = 0) const {
    return run(PVOL_RENDER, Words{input, "--size", "12x8", "--spp", "2"} + more, exit);
  }

  /// Nothing but this error, and no new file.
  void refuse(const char* tool, const Words& arguments, int exit, const std::string& key,
              const Words& filled = {}) const {
    const auto before = names();
    const RunResult r = run(tool, arguments, exit);
    EXPECT_EQ(r.out, "");
    EXPECT_NE(r.err.find("error: "), std::string::npos) << r.err;
    EXPECT_TRUE(says(r.err, key, filled));
    EXPECT_EQ(names(), before);
  }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> all;
    for (const auto& e : std::filesystem::directory_iterator(folder.path())) {
      all.insert(e.path().filename().string());
    }
    return all;
  }

  [[nodiscard]] std::map<std::string, std::string> header(const std::string& file) const {
    return formats::read_film(file).attributes;
  }
  /// What the scene in the header has of the camera.
  [[nodiscard]] std::string camera(const std::string& file) const {
    const std::string scene = header(file).at("pvol:scene");
    const std::size_t begin = scene.find("[camera]");
    return scene.substr(begin, scene.find("\n\n", begin) - begin);
  }
};

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// --- pvol-fit and pvol-convert ------------------------------------------------------------------

TEST_F(Sequence, OfVdbFilesIsConvertedAndFittedAsEachFileAlone) {
  run(PVOL_CONVERT, {smoke, folder / "smoke.%04d.vdb", "--frames", "1-3"});
  const RunResult r = run(
      PVOL_FIT, {folder / "smoke.####.vdb", "-o", folder / "smoke.####.pvol", "--frames", "1-3"});
  EXPECT_EQ(count(r.out, "\n"), 3u) << "a line a frame: " << r.out;
  EXPECT_EQ(r.err, "");
  for (const int frame : {1, 2, 3}) {
    EXPECT_TRUE(says(r.out, "frames.fitted", {std::to_string(frame), std::to_string(frame), "3"}));
    EXPECT_NE(r.out.find("wrote " + at("smoke", frame, "pvol") + "\n"), std::string::npos) << r.out;
    run(PVOL_FIT, {at("smoke", frame, "vdb"), "-o", at("alone", frame, "pvol")});
    EXPECT_EQ(read_text(at("smoke", frame, "pvol")), read_text(at("alone", frame, "pvol")));
  }
  EXPECT_NE(read_text(at("smoke", 1, "pvol")), read_text(at("smoke", 2, "pvol")));
}

TEST_F(Sequence, IsMadeOfTheFramesThatAreNamed) {
  const std::string pvol = folder / "s.##.pvol";
  run(PVOL_FIT, {smoke, "-o", pvol, "--frames", "1-3x2", "--quiet"});
  EXPECT_TRUE(exists("s.01.pvol") && !exists("s.02.pvol") && exists("s.03.pvol"));
  run(PVOL_FIT, {smoke, "-o", pvol, "--frames", "1-3", "--frame", "2", "--quiet"});
  EXPECT_TRUE(exists("s.02.pvol"));
  const json j =
      json::parse(run(PVOL_FIT, {smoke, "-o", folder / "x.pvol", "--frame", "2", "--json"}).out);
  EXPECT_EQ(j.at("frame"), 2);
  EXPECT_EQ(j.at("input"), at("smoke", 2, "toml"));

  std::ofstream(folder / "smoke.-005.toml") << recipe(1);
  run(PVOL_FIT, {smoke, "-o", pvol, "--frames", "-5--5", "--quiet"});
  run(PVOL_FIT, {smoke, "-o", folder / "t.#.pvol", "--frame", "-5", "--quiet"});
  EXPECT_TRUE(exists("s.-5.pvol") && exists("t.-5.pvol"));
}

TEST_F(Sequence, IsCheckedBeforeAnyWork) {
  const std::string pvol = folder / "s.####.pvol";
  const auto refuse_fit = [&](const Words& arguments, int exit, const std::string& mentions) {
    refuse(PVOL_FIT, arguments, exit, mentions);
  };
  refuse_fit({smoke, "-o", pvol}, 2, "frames.pattern_to_fit");
  refuse_fit({smoke, "-o", folder / "s.pvol", "--frames", "1-3"}, 2, "frames.one_pvol_for_all");
  refuse_fit({smoke, "-o", folder / "s.pvol", "--frames", "1-3", "--frame", "2"}, 2,
             "frames.one_pvol_for_all");
  refuse_fit({at("smoke", 1, "toml"), "-o", pvol, "--frames", "1-3"}, 2,
             "frames.frames_frame_need");
  refuse_fit({smoke, "-o", pvol, "--frames", "3-1"}, 2, "frames.option_range_descends");
  refuse_fit({smoke, "-o", pvol, "--frames", "all"}, 2, "frames.frames_frame_such");
  refuse_fit({smoke, "-o", pvol, "--frame", "1-3"}, 2, "frames.frame_frame_such");
  refuse_fit({smoke, "-o", pvol, "--frames", "1-3", "--frame", "7"}, 2, "frames.frame_not_among");
  refuse_fit({at("smoke", 1, "toml"), "-o", pvol, "--skip-existing"}, 2,
             "frames.skip_existing_needs");
  refuse_fit({smoke, "-o", pvol, "--frames", "0-5"}, 1, "frames.some_missing");
  refuse_fit({smoke, "-o", pvol, "--frames", "1-100"}, 1, "frames.many_missing");
  refuse(PVOL_CONVERT, {smoke, folder / "s.vdb", "--frames", "1-3"}, 2, "frames.one_vdb_for_all");
  refuse(PVOL_CONVERT, {smoke, folder / "s.####.vdb"}, 2, "frames.pattern_without_frames");
  refuse(PVOL_CONVERT, {smoke, smoke, "--frames", "1-3"}, 2, "frames.no_conversion_toml");
}

TEST_F(Sequence, EndsAtAFrameThatFails) {
  std::ofstream(at("smoke", 2, "toml")) << "no recipe";
  const RunResult r =
      run(PVOL_FIT, {smoke, "-o", folder / "s.####.pvol", "--frames", "1-3", "--quiet"}, 1);
  EXPECT_TRUE(says(r.err.substr(0, r.err.find('\n')), "frames.not_valid_toml"));
  EXPECT_TRUE(exists("s.0001.pvol") && !exists("s.0002.pvol") && !exists("s.0003.pvol"));
}

TEST_F(Sequence, GoesOnWhereItStopped) {
  std::ofstream(at("s", 2, "pvol")) << "kept";
  const Words fit{smoke, "-o", folder / "s.####.pvol", "--frames", "1-3", "--skip-existing"};
  const std::string skipped = run(PVOL_FIT, fit).err;
  EXPECT_TRUE(says(skipped, "frames.frames_exist_skipped"));
  EXPECT_EQ(count(skipped, "\n"), 1u) << skipped;
  EXPECT_EQ(read_text(at("s", 2, "pvol")), "kept");
  EXPECT_TRUE(exists("s.0001.pvol") && exists("s.0003.pvol"));

  std::ofstream(at("a", 2, "exr")) << "kept";
  std::ofstream(at("a", 3, "exr")) << "without its .png";
  std::ofstream(at("a", 2, "png")) << "kept";
  render(smoke, {"-o", exr, "--frames", "1-3", "--skip-existing", "--quiet"});
  EXPECT_EQ(read_text(at("a", 2, "exr")) + read_text(at("a", 2, "png")), "keptkept");
  EXPECT_EQ(header(at("a", 1, "exr")).at("pvol:frame"), "1");
  EXPECT_EQ(header(at("a", 3, "exr")).at("pvol:frame"), "3");
}

// --- choices of pvol-render ---------------------------------------------------------------------

TEST_F(Sequence, IsRenderedWithTheExtinctionAndTheCameraOfOneFrame) {
  const RunResult r =
      render(smoke, {"-o", exr, "--frames", "1-3", "--stats", folder / "a.####.json"});
  EXPECT_TRUE(says(r.err, "tools.extinction_chosen"));
  EXPECT_EQ(times_said(r.err, "tools.extinction_chosen"), 1) << r.err;
  EXPECT_TRUE(says(r.err, "frames.chosen_for_all"));
  EXPECT_EQ(times_said(r.err, "frames.chosen_for_all"), 1) << r.err;
  render(at("smoke", 1, "toml"), {"-o", folder / "first.exr", "--quiet"});
  render(at("smoke", 3, "toml"), {"-o", folder / "third.exr", "--quiet"});
  const auto first = header(folder / "first.exr");
  EXPECT_NE(first.at("pvol:extinction"), header(folder / "third.exr").at("pvol:extinction"));
  EXPECT_NE(camera(folder / "first.exr"), camera(folder / "third.exr"));
  EXPECT_FALSE(first.contains("pvol:frame") || first.contains("pvol:lock_frame"));
  for (const int frame : {1, 2, 3}) {
    SCOPED_TRACE(frame);
    const std::string number = std::to_string(frame);
    EXPECT_EQ(times_said(r.err, "frames.rendered", {number, number, "3", "192"}), 1) << r.err;
    const auto about = header(at("a", frame, "exr"));
    EXPECT_EQ(about.at("pvol:extinction"), first.at("pvol:extinction"));
    EXPECT_EQ(camera(at("a", frame, "exr")), camera(folder / "first.exr"));
    EXPECT_EQ(about.at("pvol:frame"), std::to_string(frame));
    EXPECT_EQ(about.at("pvol:lock_frame"), "1");
    const json stats = json::parse(read_text(at("a", frame, "json")));
    EXPECT_EQ(stats.at("options").at("frame"), frame);
    EXPECT_EQ(stats.at("options").at("volume"), at("smoke", frame, "toml"));
  }
}

TEST_F(Sequence, HasTheSameBytesFrameByFrameOnAFarm) {
  render(smoke, {"-o", exr, "--frames", "1-3", "--quiet"});
  for (const int frame : {1, 2, 3}) {
    SCOPED_TRACE(frame);
    const std::string number = std::to_string(frame), farm = at("farm", frame, "exr");
    for (const Words& task : {Words{"--frames", "1-3", "--frame", number},
                              Words{"--lock-frame", "1", "--frame", number}}) {
      const RunResult r =
          render(smoke, Words{"-o", folder / "farm.####.exr", "--no-resume"} + task);
      EXPECT_EQ(r.err.find("warning"), std::string::npos) << r.err;
      EXPECT_TRUE(says(r.err, "frames.single_rendered", {number, "192"}));
      EXPECT_EQ(read_text(farm), read_text(at("a", frame, "exr")));
      EXPECT_EQ(read_text(at("farm", frame, "png")), read_text(at("a", frame, "png")));
    }
  }
}

TEST_F(Sequence, IsLockedToAnyFrame) {
  render(smoke, {"-o", exr, "--frames", "1-2", "--lock-frame", "3", "--quiet"});
  render(at("smoke", 3, "toml"), {"-o", folder / "third.exr", "--quiet"});
  for (const int frame : {1, 2}) {
    EXPECT_EQ(header(at("a", frame, "exr")).at("pvol:extinction"),
              header(folder / "third.exr").at("pvol:extinction"));
    EXPECT_EQ(camera(at("a", frame, "exr")), camera(folder / "third.exr"));
    EXPECT_EQ(header(at("a", frame, "exr")).at("pvol:lock_frame"), "3");
  }
  EXPECT_FALSE(exists("a.0003.exr"));
  refuse(PVOL_RENDER, {smoke, "-o", exr, "--frames", "1-2", "--lock-frame", "9"}, 1,
         "frames.no_locked_frame");
  refuse(PVOL_RENDER, {at("smoke", 1, "toml"), "-o", exr, "--lock-frame", "1"}, 2,
         "frames.lock_frame_needs");
}

TEST_F(Sequence, WarnsOfAFrameThatChoosesForItself) {
  const RunResult r = render(smoke, {"-o", folder / "a.exr", "--frame", "3"});
  EXPECT_TRUE(says(r.err, "frames.chosen_for_one"));
  EXPECT_TRUE(says(r.err, "frames.chosen_for_one"));
  render(at("smoke", 3, "toml"), {"-o", folder / "third.exr", "--quiet"});
  EXPECT_EQ(header(folder / "a.exr").at("pvol:extinction"),
            header(folder / "third.exr").at("pvol:extinction"));
  const Words camera{"--set", "camera.position=[0,0,9]", "--set", "camera.target=[0,0,0]"};
  EXPECT_TRUE(says(render(smoke, camera + Words{"-o", folder / "a.exr", "--frame", "3"}).err,
                   "frames.extinction_for_one"));
}

TEST_F(Sequence, NeedsNoOtherFrameWhereTheSceneHasAll) {
  const Words all{"--set", "camera.position=[0,0,9]", "--set", "camera.target=[0,0,0]",
                  "--set", "medium.extinction=2"};
  render(smoke, all + Words{"-o", exr, "--frames", "2-3", "--quiet"});
  std::filesystem::remove(at("smoke", 1, "toml"));
  for (const Words& task : {Words{"--frame", "3"}, Words{"--frame", "3", "--frames", "1-3"}}) {
    const RunResult r = render(smoke, all + task + Words{"-o", folder / "b.####.exr"});
    EXPECT_EQ(r.err.find("warning"), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find("chosen"), std::string::npos) << r.err;
    EXPECT_EQ(read_text(at("b", 3, "exr")), read_text(at("a", 3, "exr")));
  }
  EXPECT_FALSE(header(at("a", 3, "exr")).contains("pvol:lock_frame"));
}

TEST_F(Sequence, ChoosesNothingForAnEmptyFrame) {
  std::ofstream(at("smoke", 0, "toml"))
      << recipe(1) + "[[cut]]\nshape = \"ellipsoid\"\ncentre = [9, 0, 0]\nradii = 1\n";
  refuse(PVOL_RENDER, {smoke, "-o", exr, "--frames", "0-3", "--quiet"}, 1,
         "frames.density_everywhere_extinction");
  refuse(PVOL_RENDER, {smoke, "-o", exr, "--frames", "0-3", "--frame", "0", "--quiet"}, 1,
         "frames.density_everywhere_extinction");
  render(smoke, {"-o", exr, "--frames", "0-3", "--lock-frame", "2", "--quiet"});
  EXPECT_TRUE(exists("a.0000.exr") && exists("a.0003.exr"));
}

// --- random numbers -----------------------------------------------------------------------------

TEST_F(Sequence, HasOtherNoiseInEachFrame) {
  std::ofstream(at("smoke", 2, "toml")) << recipe(1);
  const auto pixels = [&](int frame) {
    return formats::read_film(at("a", frame, "exr")).film.pixels;
  };
  const auto equal = [](const std::vector<PixelSums>& a, const std::vector<PixelSums>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const PixelSums& x, const PixelSums& y) { return mean(x) == mean(y); });
  };
  const Words two{"-o", exr, "--frames", "1-2", "--quiet"};
  render(smoke, two);
  const auto first = pixels(1);
  EXPECT_FALSE(equal(first, pixels(2))) << "the same cloud";
  const std::string seed = header(at("a", 1, "exr")).at("pvol:seed");
  EXPECT_NE(seed, header(at("a", 2, "exr")).at("pvol:seed"));
  render(smoke, two + Words{"--seed", "1"});
  EXPECT_TRUE(equal(first, pixels(1))) << "of the scene's seed, by default 1";
  render(smoke, two + Words{"--seed", "2"});
  EXPECT_FALSE(equal(first, pixels(1)));
  EXPECT_NE(seed, header(at("a", 1, "exr")).at("pvol:seed"));
  render(at("smoke", 1, "toml"), {"-o", folder / "single.exr", "--quiet"});
  EXPECT_EQ(header(folder / "single.exr").at("pvol:seed"), "1");
}

TEST_F(Sequence, SeedsOfFramesStayAsTheyAre) {
  for (const int frame : {0, -5}) {
    std::ofstream(folder / fmt::format("smoke.{:04}.toml", frame)) << recipe(1);
  }
  const auto seed = [&](const std::string& frame, const std::string& base) {
    render(smoke, {"-o", folder / "x.exr", "--frame", frame, "--seed", base, "--quiet"});
    return header(folder / "x.exr").at("pvol:seed");
  };
  EXPECT_EQ(seed("0", "1"), "3119036373970289394");
  EXPECT_EQ(seed("2", "1"), "2261205137569801783");
  EXPECT_EQ(seed("-5", "9223372036854775807"), "7375133442818582396");
}

TEST_F(Sequence, PrintsTheSceneOfAFrameWithAllThatIsChosen) {
  render(smoke, {"-o", exr, "--frames", "1-3", "--quiet"});
  const RunResult r = render(smoke, {"--print-scene", "--frames", "1-3", "--frame", "2"});
  std::ofstream(folder / "printed.toml") << r.out;
  run(PVOL_RENDER, {folder / "printed.toml", "-o", folder / "again.exr", "--quiet"});
  EXPECT_EQ(read_text(folder / "again.png"), read_text(at("a", 2, "png")));
  refuse(PVOL_RENDER, {smoke, "--print-scene", "--frames", "1-3"}, 2, "frames.print_scene_prints");
}

// --- scenes -------------------------------------------------------------------------------------

TEST_F(Sequence, MayBeOneVolumeOfAScene) {
  std::ofstream(folder / "rock.toml") << recipe(2);
  const std::string scene = folder / "scene.toml";
  std::ofstream(scene) << "[[volume]]\nfile = \"rock.toml\"\n[[volume]]\nfile = "
                          "\"smoke.####.toml\"\n[volume.medium]\ntranslate = [3, 0, 0]\n";
  render(scene, {"-o", exr, "--frames", "1-3", "--stats", folder / "a.#.json", "--quiet"});
  std::set<std::string> extinctions;
  for (const int frame : {1, 2, 3}) {
    const json volumes = json::parse(read_text(folder / fmt::format("a.{}.json", frame)))
                             .at("options")
                             .at("volumes");
    EXPECT_EQ(volumes.at(0).at("file"), folder / "rock.toml");
    EXPECT_EQ(volumes.at(1).at("file"), at("smoke", frame, "toml"));
    EXPECT_NE(volumes.at(0).at("extinction"), volumes.at(1).at("extinction")) << "each its own";
    extinctions.insert(volumes.at(0).at("extinction").dump() +
                       volumes.at(1).at("extinction").dump());
  }
  EXPECT_EQ(extinctions.size(), 1u);
  refuse(PVOL_RENDER, {scene, "-o", exr}, 2, "frames.pattern_to_render");
  refuse(PVOL_RENDER, {scene, "-o", folder / "b.#.exr", "--frames", "3-4"}, 1, "frames.no_cloud");
  std::ofstream(scene) << "[volume]\nfile = \"rock.toml\"\n";
  refuse(PVOL_RENDER, {scene, "-o", exr, "--frames", "1-3"}, 2, "frames.frames_frame_need_input");
}

TEST_F(Sequence, MayHaveASkyAndASceneForEachFrame) {
  render(smoke, {"-o", folder / "sky.####.exr", "--frames", "1-2", "--no-png", "--quiet"});
  for (const int frame : {1, 2, 3}) {
    std::ofstream(at("scene", frame, "toml"))
        << "[volume]\nfile = \"smoke.0001.toml\"\n[environment]\nfile = \"sky.####.exr\"\n"
        << "[camera]\nposition = [0, 0, " << 5 + frame << "]\ntarget = [0, 0, 0]\n";
  }
  const std::string scenes = folder / "scene.####.toml";
  refuse(PVOL_RENDER, {scenes, "-o", exr, "--frames", "1-3"}, 1, "frames.no_sky");
  render(scenes, {"-o", exr, "--frames", "1-2", "--quiet"});
  const std::string first = header(at("a", 1, "exr")).at("pvol:scene");
  const std::string second = header(at("a", 2, "exr")).at("pvol:scene");
  EXPECT_NE(first.find("sky.0001.exr"), std::string::npos) << first;
  EXPECT_NE(second.find("sky.0002.exr"), std::string::npos) << second;
  EXPECT_NE(camera(at("a", 1, "exr")), camera(at("a", 2, "exr"))) << "given for each frame";
}

TEST_F(Sequence, MayHaveAMeshForEachFrame) {
  for (const int frame : {1, 2}) {
    std::ofstream(at("roof", frame, "obj"))
        << "v -9 " << frame << " -9\nv 9 1 -9\nv 0 1 9\nf 1 2 3\n";
  }
  const std::string scene = folder / "roof.toml";
  std::ofstream(scene) << "[volume]\nfile = \"smoke.0001.toml\"\n[[mesh]]\n"
                          "file = \"roof.####.obj\"\n[camera]\nposition = [0, 0, 6]\n"
                          "target = [0, 0, 0]\n[medium]\nextinction = 5\n";
  refuse(PVOL_RENDER, {scene, "-o", exr, "--frames", "1-3"}, 1, "frames.no_mesh");
  render(scene, {"-o", exr, "--frames", "1-2", "--quiet"});
  const std::string first = header(at("a", 1, "exr")).at("pvol:scene");
  EXPECT_NE(first.find("roof.0001.obj"), std::string::npos) << first;
  const std::string second = header(at("a", 2, "exr")).at("pvol:scene");
  EXPECT_NE(second.find("roof.0002.obj"), std::string::npos) << second;
}

TEST_F(Sequence, IsRenderedByTheScenesThatWereChecked) {
  const std::string scene = folder / "scene.toml";
  std::ofstream(scene) << "[volume]\nfile = \"smoke.####.toml\"\n";
  const RunResult r =
      run_tool(PVOL_RENDER, {scene, "-o", exr, "--frames", "1-2", "--size", "64x48", "--spp", "64"},
               [&](int, const std::string& err) {
                 if (times_said(err, "frames.chosen_for_all") > 0)
                   std::ofstream(scene) << "damaged";
               });
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_EQ(read_text(scene), "damaged") << "while the frames were rendered";
  EXPECT_TRUE(exists("a.0001.exr") && exists("a.0002.exr"));
}

TEST_F(Sequence, LeavesAloneWhatTheSceneOfAFrameHas) {
  for (const int frame : {1, 2}) {
    std::ofstream(at("scene", frame, "toml"))
        << "[volume]\nfile = \"smoke.####.toml\"\n"
        << (frame == 1 ? ""
                       : "[medium]\nextinction = 2\n[camera]\nposition = [0, 0, 9]\n"
                         "target = [0, 0, 0]\n");
  }
  render(folder / "scene.####.toml", {"-o", exr, "--frames", "1-2", "--quiet"});
  EXPECT_EQ(header(at("a", 1, "exr")).at("pvol:lock_frame"), "1");
  EXPECT_FALSE(header(at("a", 2, "exr")).contains("pvol:lock_frame"));
  EXPECT_EQ(header(at("a", 2, "exr")).at("pvol:extinction"), "2.0");
  render(folder / "scene.####.toml", {"-o", folder / "b.exr", "--frame", "2", "--quiet"});
  EXPECT_EQ(read_text(folder / "b.exr"), read_text(at("a", 2, "exr")));
}

TEST_F(Sequence, WantsAPlaceForTheFrameInEveryOutput) {
  const Words all{smoke, "-o", exr, "--frames", "1-3"};
  const auto refuse_output = [&](const Words& more, const std::string& name) {
    refuse(PVOL_RENDER, all + more, 2, "frames.one_picture_for_all", {more.back(), folder / name});
  };
  refuse_output({"-o", folder / "x.exr"}, "x.####.exr");
  refuse_output({"--png", folder / "x.png"}, "x.####.png");
  refuse_output({"--deep", folder / "x.deep.exr"}, "x.deep.####.exr");
  refuse_output({"--stats", folder / "x.json"}, "x.####.json");
  refuse(PVOL_RENDER, {smoke, "-o", exr}, 2, "frames.pattern_without_frames");
  // One picture, or one cloud, with the name of many.
  const std::string one = at("smoke", 1, "toml");
  refuse(PVOL_RENDER, {one, "-o", exr}, 2, "frames.pattern_of_output");
  refuse(PVOL_RENDER, {one, "-o", folder / "a.exr", "--png", folder / "a.####.png"}, 2,
         "frames.pattern_of_output");
  refuse(PVOL_FIT, {one, "-o", folder / "a.####.pvol"}, 2, "frames.pattern_of_output");
  refuse(PVOL_CONVERT, {one, folder / "a.####.vdb"}, 2, "frames.pattern_of_output");
  render(smoke, {"-o", exr, "--frames", "1-2", "--png", folder / "p.#.png", "--deep",
                 folder / "d.##.exr", "--stats", folder / "s.%03d.json", "--quiet"});
  for (const char* file : {"a.0002.exr", "p.2.png", "d.02.exr", "s.002.json"}) {
    EXPECT_TRUE(exists(file)) << file;
  }
  EXPECT_FALSE(exists("a.0002.png"));
}

TEST_F(Sequence, InterruptedKeepsTheFramesThatAreDone) {
  for (const int frame : {1, 2, 3}) {
    std::ofstream(at("scene", frame, "toml"))
        << "[volume]\nfile = \"smoke.0001.toml\"\n[render]\nspp = "
        << (frame == 2 ? 4'000'000'000 : 1) << "\n";
  }
  bool sent = false;
  const RunResult r = run_tool(
      PVOL_RENDER, {folder / "scene.####.toml", "-o", exr, "--frames", "1-3", "--size", "12x8"},
      [&](int pid, const std::string& err) {
        if (!sent && times_said(err, "frames.rendered", {"1", "1", "3", "96"}) > 0)
          sent = kill(pid, SIGINT) == 0;
      });
  // The second frame may not have come as far as to its first sample.
  EXPECT_TRUE(r.exit == 1 || r.signal == SIGINT) << r.err;
  EXPECT_NE(r.err.find("interrupted"), std::string::npos) << r.err;
  EXPECT_TRUE(says(r.err, r.exit == 1 ? "frames.second_interrupted" : "frames.some_done"));
  EXPECT_TRUE(exists("a.0001.exr"));
  EXPECT_FALSE(exists("a.0003.exr"));
  if (exists("a.0002.exr")) {
    EXPECT_TRUE(formats::read_picture_header(folder / "a.0002.exr").has_sums) << "to go on with";
  }
}

TEST_F(Sequence, KeepsAFrameThatIsNotDoneForTheNextRun) {
  bool sent = false;
  const RunResult r = run_tool(
      PVOL_RENDER, {smoke, "-o", exr, "--frame", "2", "--size", "64x48", "--spp", "4000000000"},
      [&](int pid, const std::string& err) {
        if (!sent && err.find(" expected", err.find("\nframe 2 ")) != err.npos) {
          sent = kill(pid, SIGINT) == 0;
        }
      });
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(says(r.err, "frames.interrupted_after_samples"));
  const auto header = formats::read_picture_header(folder / "a.0002.exr");
  EXPECT_TRUE(header.has_sums);
  EXPECT_TRUE(header.attributes.at("pvol:samples").ends_with(" of 12288000000000"));
  // Nobody takes it for a finished one.
  const RunResult again = run_tool(PVOL_RENDER,
                                   {smoke, "-o", exr, "--frame", "2", "--size", "64x48", "--spp",
                                    "4000000000", "--skip-existing"},
                                   [&](int pid, const std::string& err) {
                                     if (times_said(err, "frames.resuming") > 0) kill(pid, SIGKILL);
                                   });
  EXPECT_EQ(again.signal, SIGKILL) << again.err;
}

/// What is finished is known by its scene and the contents of its files, not by its name.
TEST_F(Sequence, LeavesOutWhatIsFinishedAndNothingElse) {
  const Words line{"-o",   exr,     "--frames", "1-3",       "--size",
                   "12x8", "--spp", "4",        "--summary", folder / "summary.json"};
  std::string log;
  const auto states = [&](const Words& more) {
    const RunResult r = run(PVOL_RENDER, Words{smoke} + line + more);
    std::string text;
    for (const auto& frame : json::parse(read_text(folder / "summary.json"))) {
      text += frame.at("state").get<std::string>() + ' ';
      if (frame.at("state") == "rendered") {
        EXPECT_GT(frame.at("pixel_noise"), 0);
        EXPECT_GT(frame.at("wall_seconds"), 0);
      }
    }
    log = r.err;
    return text;
  };
  EXPECT_EQ(states({}), "rendered rendered rendered ");
  EXPECT_TRUE(says(log, "frames.frames_rendered"));
  const std::string first = read_text(at("a", 1, "exr"));
  EXPECT_EQ(states({}), "finished finished finished ");
  EXPECT_TRUE(says(log, "frames.frame_exr_finished"));
  EXPECT_EQ(states({"--no-resume"}), "rendered rendered rendered ");
  EXPECT_TRUE(read_text(at("a", 1, "exr")) == first);
  std::ofstream(at("a", 1, "exr"), std::ios::binary) << first.substr(0, first.size() - 1);
  std::ofstream(at("a", 2, "png"), std::ios::binary).close();
  EXPECT_EQ(states({}), "rendered rendered finished ") << "cut off, or empty";
  EXPECT_TRUE(read_text(at("a", 1, "exr")) == first);
  EXPECT_EQ(states({"--pixel-type", "half"}), "rendered rendered rendered ");
  EXPECT_EQ(states({"--pixel-type", "half"}), "finished finished finished ");
  EXPECT_EQ(states({"--compression", "none"}), "rendered rendered rendered ");
  EXPECT_EQ(states({}), "rendered rendered rendered ");
  std::ofstream(at("a", 2, "exr")) << "damaged";
  std::filesystem::remove(at("a", 3, "png"));
  EXPECT_EQ(states({}), "finished rendered rendered ");
  std::ofstream(at("smoke", 2, "toml"), std::ios::app) << "# as thick as before\n";
  EXPECT_EQ(states({}), "finished rendered finished ") << "the cloud's file has other contents";
  EXPECT_EQ(states({"--spp", "5"}), "rendered rendered rendered ");
  EXPECT_EQ(states({"--spp", "5", "--seed", "2"}), "rendered rendered rendered ");
  const Words some{"--spp", "5", "--seed", "2", "--samples", "0:2"};
  EXPECT_EQ(states(some), "rendered rendered rendered ") << "a part";
  EXPECT_EQ(states(some), "finished finished finished ");
  EXPECT_EQ(states({"--spp", "5", "--seed", "2"}), "rendered rendered rendered ") << "the whole";
  EXPECT_EQ(states({"--spp", "5", "--seed", "2", "--denoise"}), "rendered rendered rendered ");
  EXPECT_EQ(states({"--spp", "5", "--seed", "2", "--denoise"}), "finished finished finished ");
  EXPECT_EQ(states({"--spp", "5", "--seed", "2", "--multipart"}), "rendered rendered rendered ");
  EXPECT_EQ(states({"--spp", "5", "--seed", "2", "--aov", "depth"}), "rendered rendered rendered ");
}

TEST_F(Sequence, GoesOnAfterAFrameThatFails) {
  for (const int frame : {1, 2, 3}) {  // the second one would hardly end
    std::ofstream(at("scene", frame, "toml"))
        << "[volume]\nfile = \"smoke.0001.toml\"\n[medium]\nalbedo = 1\nextinction = "
        << (frame == 2 ? "1e9" : "1") << "\n";
  }
  const RunResult r =
      run_tool(PVOL_RENDER, {folder / "scene.####.toml", "-o", exr, "--frames", "1-3", "--size",
                             "12x8", "--spp", "2", "--summary", "-"});
  EXPECT_EQ(r.exit, 1);
  EXPECT_TRUE(says(r.err, "frames.path_scatter_about_times"));
  EXPECT_TRUE(says(r.err, "frames.frames_rendered_failed"));
  EXPECT_TRUE(exists("a.0001.exr"));
  EXPECT_TRUE(exists("a.0003.exr"));
  EXPECT_EQ(json::parse(r.out).at(1).at("state"), "failed");
}

}  // namespace sequence_test
}  // namespace pvol
