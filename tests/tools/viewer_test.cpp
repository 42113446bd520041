// What a page of pvol-view may ask for: values to set, steps to undo, scenes to save.
#include "view/viewer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pvol/formats/scene_file.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"
#include "view/controls.h"

namespace pvol::viewer {
namespace viewer_test {

using cli::Json;
using test::error_of;

constexpr double kLong = 300;

/// Every kind of light and surface that needs no file, two volumes, components and a ramp.
constexpr const char* kScene = R"([[volume]]
file = "ball.toml"
[[volume]]
file = "ball.toml"
[volume.medium]
extinction = 2
translate = [2, 0, 0]
[medium]
extinction = 8
g = 0.3
[medium.density]
ramp = [[0, 0], [1, 2]]
[[medium.component]]
share = 0.25
albedo = [0.5, 0.6, 0.7]
draine_g = 0.4
[camera]
position = [0, 0, 6]
target = [0, 0, 0]
[environment]
zenith = 0.5
[[sun]]
direction = [0, 1, 0]
[[sun]]
direction = [1, 1, 0]
irradiance = 2
[[point]]
position = [0, 3, 0]
intensity = 5
[[plane]]
point = [0, -2, 0]
[render]
size = [32, 18]
spp = 2
)";

class Page : public ::testing::Test {
 protected:
  Page() {
    std::ofstream(folder_.file("ball.toml"))
        << "[recipe]\nresolution = 24\n[[form]]\nshape = \"ellipsoid\"\nradii = 1\n"
           "centre = [0, 0, 0]\n";
    std::ofstream(folder_.file("scene.toml")) << kScene;
    scene_ = formats::read_scene(folder_.file("scene.toml"));
  }

  [[nodiscard]] static Json set(const std::string& section, const std::string& key,
                                const Json& value) {
    return {{"section", section}, {"key", key}, {"value", value}};
  }

  /// The value of a key as a page gets it.
  [[nodiscard]] static Json value(formats::SceneFile scene, const std::string& section,
                                  const std::string& key) {
    for (const Json& s : describe_controls(scene)) {
      for (const Json& k : s["keys"]) {
        if (s["id"] == section && k["key"] == key) return k["value"];
      }
    }
    return "absent";
  }

  TemporaryFolder folder_;
  formats::SceneFile scene_;
};

TEST_F(Page, HasEveryKeyOfEverySection) {
  const Json all = describe_controls(scene_);
  std::vector<std::string> ids;
  for (const Json& s : all) ids.push_back(s["id"]);
  const std::vector<std::string> expected{"volume[1].medium",
                                          "volume[1].component[2]",
                                          "volume[1].density",
                                          "volume[2].medium",
                                          "volume[2].density",
                                          "sun[1]",
                                          "sun[2]",
                                          "point[1]",
                                          "environment",
                                          "plane[1]",
                                          "camera",
                                          "render"};
  EXPECT_EQ(ids, expected);
  // Those of the manual, so that a new key appears by itself.
  for (const formats::SectionManual& section : formats::describe_sections()) {
    std::string id = section.heading == "[camera]" ? "camera" : "";
    if (section.heading == "[render]") id = "render";
    if (section.heading == "[[sun]]") id = "sun[1]";
    if (id.empty()) continue;
    for (const auto& line : section.lines) {
      const bool of_frame = line.key == "azimuth" || line.key == "elevation" ||
                            line.key == "zoom" || line.key == "matrix";
      if (of_frame) continue;
      EXPECT_NE(value(scene_, id, line.key), "absent") << section.heading << ' ' << line.key;
    }
  }
}

TEST_F(Page, ValuesAreSetWhereTheyBelong) {
  edit(scene_, set("sun[2]", "irradiance", 7));
  edit(scene_, set("volume[1].component[2]", "albedo", {0.1, 0.2, 0.3}));
  edit(scene_, set("volume[2].medium", "extinction", 5.5));
  edit(scene_, set("camera", "f_stop", 2.8));
  edit(scene_, set("render", "seed", "9007199254740995"));  // no number of a script
  EXPECT_EQ(std::get<Sun>(scene_.scene.lights[0]).irradiance, Rgb(3.0f));
  EXPECT_EQ(std::get<Sun>(scene_.scene.lights[1]).irradiance, Rgb(7.0f));
  EXPECT_EQ(scene_.volumes[0].medium.components[1].albedo, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(scene_.volumes[1].medium.extinction, 5.5);
  EXPECT_EQ(scene_.scene.camera.f_stop, 2.8);
  EXPECT_EQ(scene_.scene.options.seed, 9007199254740995u);
  EXPECT_EQ(value(scene_, "render", "seed"), "9007199254740995");
  edit(scene_, set("camera", "f_stop", "none"));
  EXPECT_FALSE(scene_.scene.camera.f_stop);
}

TEST_F(Page, StrengthsThatAreSetAreNoLongerChosen) {
  scene_.volumes[0].has_extinction = false;
  EditedScene edited(scene_, {});
  edited.edit(Json::array({set("volume[1].medium", "extinction", 3)}), 1);
  EXPECT_TRUE(edited.scene().volumes[0].has_extinction);
  EXPECT_EQ(edited.scene().volumes[0].medium.extinction, 3);
}

TEST_F(Page, WhatNoFileHasIsKept) {
  scene_.scene.options.threads = 3;
  scene_.volumes[1].shows_fire = true;
  EditedScene edited(scene_, {});
  edited.edit(Json::array({set("camera", "fov", 20)}), 1);
  edited.undo();
  EXPECT_EQ(edited.scene().scene.options.threads, 3);
  EXPECT_TRUE(edited.scene().volumes[1].shows_fire);
}

TEST_F(Page, KindsAreChosen) {
  edit(scene_, set("environment", "type", "clear"));
  EXPECT_TRUE(std::holds_alternative<ClearSky>(scene_.scene.environment));
  edit(scene_, set("volume[1].medium", "phase", "two-lobes"));
  edit(scene_, set("volume[1].medium", "g_backward", -0.25));
  EXPECT_EQ(value(scene_, "volume[1].medium", "g_backward"), -0.25);
  EXPECT_EQ(value(scene_, "volume[1].medium", "g"), "absent");
}

TEST_F(Page, LightsAreAddedAndRemovedByKind) {
  edit(scene_, {{"add", "sun"}});
  EXPECT_TRUE(std::holds_alternative<Sun>(scene_.scene.lights[2])) << "behind others of its kind";
  edit(scene_, {{"remove", "sun[1]"}});
  EXPECT_EQ(std::get<Sun>(scene_.scene.lights[0]).irradiance, Rgb(2.0f));
  edit(scene_, {{"add", "ball"}});
  EXPECT_EQ(scene_.scene.surfaces.size(), 2u);
  edit(scene_, {{"remove", "plane[1]"}});
  EXPECT_TRUE(std::holds_alternative<BallSurface>(scene_.scene.surfaces.front()));
}

TEST_F(Page, WrongRequestsAreRefused) {
  const auto refusal = [&](const Json& change) { return error_of([&] { edit(scene_, change); }); };
  EXPECT_TRUE(says(refusal(set("camera", "fov", 200)), "viewer.fov_found"));
  EXPECT_TRUE(says(refusal(set("camera", "nix", 1)), "viewer.no_key"));
  EXPECT_TRUE(says(refusal(set("sun[3]", "angle", 1)), "viewer.no_section"));
  EXPECT_TRUE(says(refusal(set("camera", "up", Json::parse("[[[[1]]]]"))), "viewer.no_value"));
  EXPECT_TRUE(says(refusal(set("camera", "fov", nullptr)), "viewer.no_value"));
  EXPECT_TRUE(says(refusal({{"add", "mesh"}}), "viewer.no_kind"));
  EXPECT_TRUE(says(refusal({{"remove", "camera"}}), "viewer.not_removable"));
}

TEST_F(Page, StepsAreUndoneByGesture) {
  EditedScene edited(scene_, {});
  const std::string before = formats::to_toml(edited.scene());
  EXPECT_FALSE(edited.can_undo());
  for (int i = 1; i <= 5; ++i) edited.edit(Json::array({set("camera", "fov", 30 + i)}), 7);
  edited.edit(Json::array({set("camera", "fov", 50)}), 8);
  EXPECT_EQ(value(edited.scene(), "camera", "fov"), 50);
  edited.undo();
  EXPECT_EQ(value(edited.scene(), "camera", "fov"), 35) << "one gesture";
  edited.undo();
  EXPECT_EQ(formats::to_toml(edited.scene()), before);
  EXPECT_FALSE(edited.can_undo());
  edited.redo();
  EXPECT_EQ(value(edited.scene(), "camera", "fov"), 35);
  edited.edit(Json::array({set("camera", "fov", 20)}), 9);
  EXPECT_FALSE(edited.can_redo()) << "another way was taken";
}

TEST_F(Page, WhatDoesNotGoTogetherChangesNothing) {
  EditedScene edited(scene_, {});
  const std::string before = formats::to_toml(edited.scene());
  const auto refusal = error_of([&] {
    edited.edit(Json::array({set("camera", "fov", 20), set("camera", "target", {0, 0, 6})}), 1);
  });
  EXPECT_TRUE(says(refusal, "viewer.target_at_position"));
  EXPECT_EQ(formats::to_toml(edited.scene()), before);
  EXPECT_FALSE(edited.can_undo());
}

TEST_F(Page, FramesAreChosen) {
  scene_.volumes.front().file = "smoke.####.vdb";
  EditedScene edited(scene_, {1, 2, 10});
  EXPECT_EQ(edited.scene_of_frame().volumes.front().file, "smoke.0001.vdb");
  edited.choose_frame(10);
  EXPECT_EQ(edited.scene_of_frame().volumes.front().file, "smoke.0010.vdb");
  EXPECT_EQ(edited.scene().volumes.front().file, "smoke.####.vdb") << "as it is saved";
  EXPECT_TRUE(says(error_of([&] { edited.choose_frame(3); }), "viewer.no_frame"));
}

TEST_F(Page, SavedScenesAreTheSame) {
  Viewer viewer({scene_, {}}, cli::LiveScene({"test", true}), folder_.file(""), "scene.toml");
  (void)viewer.change({{"edits", Json::array({set("sun[1]", "angle", 2)})}, {"gesture", 1}});
  (void)viewer.save({{"name", "saved.toml"}});
  formats::SceneFile saved = formats::read_scene(folder_.file("saved.toml"));
  EXPECT_EQ(std::get<Sun>(saved.scene.lights[0]).angle, 2);
  EXPECT_TRUE(std::filesystem::equivalent(saved.volumes[0].file, folder_.file("ball.toml")));
  saved.volumes[0].file = scene_.volumes[0].file, saved.volumes[1].file = scene_.volumes[1].file;
  edit(saved, set("sun[1]", "angle", 0));
  EXPECT_EQ(formats::to_toml(saved), formats::to_toml(scene_)) << "and nothing of the viewer's own";
}

TEST_F(Page, SavesInItsFolderOnly) {
  Viewer viewer({scene_, {}}, cli::LiveScene({"test", true}), folder_.file(""), "scene.toml");
  for (const char* name :
       {"../a.toml", "/tmp/a.toml", "a/b.toml", "..", "", ".a.toml", "a.txt", "a\n.toml"}) {
    const auto refusal = error_of([&] { (void)viewer.save({{"name", name}, {"replace", true}}); });
    EXPECT_TRUE(says(refusal.substr(refusal.find("': ") + 3), "viewer.name_to_save")) << name;
  }
  const auto exists = error_of([&] { (void)viewer.save({{"name", "scene.toml"}}); });
  EXPECT_TRUE(says(exists, "viewer.file_exists"));
  EXPECT_EQ(read_bytes(folder_.file("scene.toml")), kScene);
  std::filesystem::create_symlink("/tmp/elsewhere.toml", folder_.file("link.toml"));
  const auto link = error_of([&] {
    (void)viewer.save({{"name", "link.toml"}, {"replace", true}});
  });
  EXPECT_TRUE(says(link, "viewer.file_is_link"));
  (void)viewer.save({{"name", "scene.toml"}, {"replace", true}});
  EXPECT_NE(read_bytes(folder_.file("scene.toml")), kScene);
}

TEST_F(Page, ShowsThePictureItsPixelsAndItsLayers) {
  Viewer viewer({scene_, {}}, cli::LiveScene({"test", true}), folder_.file(""), "scene.toml");
  Json state = viewer.state(0, kLong);
  while (!state["finished"]) state = viewer.state(state["number"], kLong);
  EXPECT_EQ(state["error"], "");
  EXPECT_EQ(state["per_pixel"], 2.0);
  const View view = viewer.picture({}, false);
  EXPECT_EQ(view.picture.rgb.size(), 32u * 18 * 3);
  const Json pixel = viewer.pixel(0.5, 0.5);
  EXPECT_EQ(pixel["x"], 16);
  EXPECT_EQ(pixel["y"], 9);
  EXPECT_NEAR(pixel["layers"]["depth"].get<double>(), 5.1, 0.6)
      << "the front of a ball of radius 1";
  EXPECT_NEAR(pixel["alpha"].get<double>(), 1, 0.01);
  EXPECT_TRUE(says(error_of([&] { (void)viewer.pixel(1, 0); }), "viewer.place_outside"));
  const View depth = viewer.picture({.layer = "depth"}, false);
  EXPECT_TRUE(depth.has_scale);
  EXPECT_GT(depth.lo, 4);
  EXPECT_LT(depth.hi, kNothingMet) << "some pixels meet nothing";
  EXPECT_NE(depth.picture.rgb, view.picture.rgb);
  EXPECT_NE(viewer.picture({.display = {.exposure = 2}}, false).picture.rgb, view.picture.rgb);
  EXPECT_TRUE(says(error_of([&] {
                     (void)viewer.change({{"show", {{"layer", "nix"}}}});
                   }),
                   "viewer.no_layer"));
  EXPECT_TRUE(says(error_of([&] {
                     (void)viewer.change({{"nothing", 1}});
                   }),
                   "viewer.nothing_to_change"));
}

TEST_F(Page, EveryLayerIsShown) {
  for (const std::string& layer : layers_to_view()) {
    SCOPED_TRACE(layer);
    Viewer viewer({scene_, {}}, cli::LiveScene({"test", true}), folder_.file(""), "scene.toml");
    (void)viewer.change({{"show", {{"layer", layer}}}});
    Json state = viewer.state(0, kLong);
    while (state["change"] < 2 || !state["finished"]) state = viewer.state(state["number"], kLong);
    EXPECT_EQ(state["error"], "");
    const View view = viewer.picture({.layer = layer}, false);
    EXPECT_EQ(view.picture.rgb.size(), 32u * 18 * 3);
    const View plain = viewer.picture({}, false);
    EXPECT_EQ(view.picture.rgb == plain.picture.rgb, layer == "colour");
  }
}

}  // namespace viewer_test
}  // namespace pvol::viewer
