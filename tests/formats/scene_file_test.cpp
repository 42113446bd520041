#include "pvol/formats/scene_file.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <random>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

namespace fs = std::filesystem;
using Sets = std::vector<std::string>;

/// Writes text to a scene file in a folder of its own.
class SceneText : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("pvol_scene_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path write(const std::string& text) const {
    std::ofstream(folder_ / "s.toml", std::ios::binary) << text;
    return folder_ / "s.toml";
  }
  [[nodiscard]] SceneFile read(const std::string& text, const Sets& sets = {}) const {
    return read_scene(write(text), sets);
  }
  /// The message for a text, without the name of the folder.
  [[nodiscard]] std::string error(const std::string& text, const Sets& sets = {}) const {
    try {
      (void)read(text, sets);
    } catch (const Error& e) {
      std::string message = e.what();
      const std::string prefix = (folder_ / "").string();
      if (const auto at = message.find(prefix); at != std::string::npos) {
        message.erase(at, prefix.size());
      }
      return message;
    }
    return "no error";
  }

  fs::path folder_;
};

const std::string kCloud = "[volume]\nfile = \"cloud.pvol\"\n";  // two lines: sections begin at 3

const Sun& sun(const SceneFile& file, std::size_t i) { return std::get<Sun>(file.scene.lights[i]); }

void expect_near(Vec3d a, Vec3d b) {
  EXPECT_LT(length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST_F(SceneText, EveryKeyIsRead) {
  const SceneFile file = read(R"(
[volume]
file = "clouds/a.vdb"
grid = "smoke"
[camera]
position = [1, 2, 3]
target = [4, 5, 6.5]
up = [0, 0, 1]
fov = 20
[medium]
extinction = 12.5
albedo = [0.9, 0.8, 0.7]
g = -0.3
emission = 0.25
translate = [1, 0, 0]
[[medium.component]]
share = 0.25
albedo = 0.1
g = 0.7
emission = [1, 2, 3]
[environment]
type = "image"
file = "sky.exr"
scale = 2
rotation = 90
[[sun]]
direction = [1, 1, 0]
irradiance = [1, 2, 3]
angle = 0.5
[[sun]]
irradiance = 7
[render]
size = [320, 200]
crop = [10, 20, 30, 40]
spp = 17
seed = 99
tracker = "delta-global"
transmittance = "analog"
micro_bounds = "1"
interpolation = "nearest"
shells = "off"
guide = "on"
depth = 5
max_bounces = 8
background = false
density = "fpn"
density_tolerance = 0.125
majorant_scale = 2.5
homogenise = 0.125
preview = 2
)");
  EXPECT_EQ(file.density, (Quantisation{Precision::fpn, 0.125}));
  ASSERT_EQ(file.volumes.size(), 1u);
  const SceneVolume& volume = file.volumes[0];
  EXPECT_EQ(volume.file, folder_ / "clouds/a.vdb");
  EXPECT_EQ(volume.grid, "smoke");
  EXPECT_TRUE(file.has_camera);
  EXPECT_TRUE(volume.has_extinction);
  EXPECT_EQ(volume.medium, (Medium{12.5,
                                   {{0.75, {0.9f, 0.8f, 0.7f}, HenyeyGreenstein(-0.3), Rgb(0.25f)},
                                    {0.25, Rgb(0.1f), HenyeyGreenstein(0.7), {1, 2, 3}}}}));
  EXPECT_EQ(volume.object_to_world, translation({1, 0, 0}));

  Scene want;
  want.camera = {{1, 2, 3}, {4, 5, 6.5}, {0, 0, 1}, 20};
  ImageSky sky;
  sky.scale = Rgb(2.0f);
  sky.rotation = 90;
  sky.file = folder_ / "sky.exr";
  want.environment = sky;
  want.lights = {Sun{{1, 1, 0}, {1, 2, 3}, 0.5}, Sun{{0, 1, 0}, Rgb(7.0f), 0}};
  want.options.width = 320, want.options.height = 200;
  want.options.crop_x = 10, want.options.crop_y = 20;
  want.options.crop_width = 30, want.options.crop_height = 40;
  want.options.samples = 17;
  want.options.seed = 99;
  want.options.tracker = Tracker::delta_global;
  want.options.transmittance = Transmittance::analog;
  want.options.micro_bounds = MicroBoundsUse::cells_1;
  want.options.look_up = LookUp::nearest;
  want.options.shells = ShellUse::off;
  want.options.guide = GuideUse::on;
  want.options.depth = 5;
  want.options.max_bounces = 8;
  want.options.background = false;
  want.options.majorant_scale = 2.5;
  want.options.homogenise = 0.125;
  want.options.preview = 2;
  EXPECT_EQ(file.scene, want);
}

TEST_F(SceneText, SeveralVolumesHaveMediaOfTheirOwn) {
  const SceneFile file = read(R"([[volume]]
file = "clouds/a.vdb"
grid = "smoke"
[[volume]]
file = "b.pvol"
[volume.medium]
extinction = 3
albedo = 0.5
[[volume]]
file = "/c.pvol"
[medium]
g = 0.25
)");
  ASSERT_EQ(file.volumes.size(), 3u);
  const SceneVolume &a = file.volumes[0], &b = file.volumes[1], &c = file.volumes[2];
  EXPECT_EQ(a.file, folder_ / "clouds/a.vdb");
  EXPECT_EQ(mean_cosine(a.medium.components[0].phase), 0.25);
  EXPECT_EQ(b.file, folder_ / "b.pvol");
  EXPECT_TRUE(b.has_extinction);
  EXPECT_EQ(b.medium.extinction, 3);
  EXPECT_EQ(b.medium.components[0].albedo, Rgb(0.5f));
  EXPECT_EQ(c.file, "/c.pvol");
  EXPECT_EQ(c.medium, Medium{});
}

TEST_F(SceneText, SharesOfComponentsSumUpToAtMostOne) {
  const std::string component = "[[medium.component]]\nshare = 0.6\n";
  const Medium medium = read(kCloud + component).volumes[0].medium;
  ASSERT_EQ(medium.components.size(), 2u);
  EXPECT_EQ(medium.components[0].share, 1 - 0.6);
  EXPECT_THROW((void)read(kCloud + component + component), Error);
}

TEST_F(SceneText, WhatIsAbsentHasItsDefault) {
  const SceneFile file = read(kCloud);
  EXPECT_EQ(file.scene, Scene{});
  EXPECT_EQ(file.volumes, (std::vector{SceneVolume{.file = folder_ / "cloud.pvol"}}));
  EXPECT_FALSE(file.has_camera);
}

TEST_F(SceneText, WordsForNoLimitAreTheDefaults) {
  const SceneFile file = read(kCloud + "[render]\ndepth = \"auto\"\nmax_bounces = \"none\"\n");
  EXPECT_FALSE(file.scene.options.depth);
  EXPECT_FALSE(file.scene.options.max_bounces);
}

TEST_F(SceneText, EnvironmentWithoutTypeIsWhatItsKeysSay) {
  EXPECT_EQ(read(kCloud + "[environment]\nradiance = 2").scene.environment,
            Environment(ConstantSky{Rgb(2.0f)}));
  EXPECT_TRUE(std::holds_alternative<ImageSky>(
      read(kCloud + "[environment]\nfile = \"a.exr\"").scene.environment));
  EXPECT_EQ(
      std::get<GradientSky>(read(kCloud + "[environment]\nzenith = [1, 2, 3]").scene.environment)
          .zenith,
      Rgb(1, 2, 3));
}

TEST_F(SceneText, PlainSunTableIsOneSun) {
  const SceneFile file = read(kCloud + "[sun]\nirradiance = 5\n");
  ASSERT_EQ(file.scene.lights.size(), 1u);
  EXPECT_EQ(sun(file, 0).irradiance, Rgb(5.0f));
}

TEST_F(SceneText, PlacementScalesThenRotatesThenMoves) {
  const SceneFile file = read(
      kCloud + "[medium]\ntranslate = [10, 20, 30]\nscale = [2, 3, 4]\nrotate = [0, 0, 5, 90]\n");
  // (1, 1, 1) becomes (2, 3, 4), a quarter turn about z makes (-3, 2, 4) of it.
  expect_near(file.volumes[0].object_to_world.point({1, 1, 1}), {7, 22, 34});
}

TEST_F(SceneText, SeveralRotationsApplyInTheirOrder) {
  const SceneFile file =
      read(kCloud + "[medium]\nrotate = [[0, 0, 1, 90], [1, 0, 0, 90]]\nscale = 2\n");
  // x turns to y about z, then to z about x.
  expect_near(file.volumes[0].object_to_world.point({1, 0, 0}), {0, 0, 2});
}

TEST_F(SceneText, MatrixIsRowByRow) {
  const Affine want{{Vec3d{1, 2, 3}, Vec3d{0, 1, 4}, Vec3d{5, 6, 0}}, {7, 8, 9}};
  EXPECT_EQ(read(kCloud + "[medium]\nmatrix = [1, 2, 3, 7, 0, 1, 4, 8, 5, 6, 0, 9]\n")
                .volumes[0]
                .object_to_world,
            want);
  EXPECT_EQ(read(kCloud + "[medium]\nmatrix = [1, 2, 3, 7, 0, 1, 4, 8, 5, 6, 0, 9, 0, 0, 0, 1]\n")
                .volumes[0]
                .object_to_world,
            want);
}

TEST_F(SceneText, AbsoluteFileNamesStay) {
  EXPECT_EQ(read("[volume]\nfile = \"/clouds/a.vdb\"").volumes[0].file, fs::path("/clouds/a.vdb"));
}

TEST_F(SceneText, BadTextIsRefusedWithItsPlace) {
  const std::pair<const char*, const char*> cases[] = {
      // text after the two lines of kCloud, and the whole message
      {"[camera\n", "s.toml:3:8: not valid TOML: "},
      {"x = = 1", "s.toml:3:5: not valid TOML: "},
      {"[volume]\n", "s.toml:3:1: not valid TOML: "},
      {"[light]\n",
       "s.toml:3:2: unknown section or key \"light\"; expected one of volume, camera, medium, "
       "environment, sun or render"},
      {"[rendr]\n", "environment, sun or render; did you mean \"render\"?"},
      {"[camera]\nposition = [0, 0, 0]\n", "s.toml:3:1: [camera] has no target; add it"},
      {"[camera]\n  fovv = 3\n",
       "s.toml:4:3: unknown key \"fovv\" in [camera]; expected one of position, target, up or "
       "fov; did you mean \"fov\"?"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = 180\n",
       "s.toml:6:7: camera.fov is 180; expected a number in (0, 180)"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nfov = \"wide\"\n",
       "s.toml:6:7: camera.fov is \"wide\"; expected a number in (0, 180)"},
      {"[camera]\nposition = [0, 0]\ntarget = [0, 0, 1]\n",
       "s.toml:4:12: camera.position is an array of 2; expected an array of 3 numbers"},
      {"[camera]\nposition = [0, \"a\", 0]\ntarget = [0, 0, 1]\n",
       "s.toml:4:16: camera.position[2] is \"a\"; expected a finite number"},
      {"[camera]\nposition = [0, 0, nan]\ntarget = [0, 0, 1]\n",
       "s.toml:4:19: camera.position[3] is nan; expected a finite number"},
      {"[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]\n",
       "s.toml:5:10: camera.target is an array of 3; expected another point than position"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, -2, 0]\n",
       "s.toml:5:10: camera.target is an array of 3; expected up, by default [0, 1, 0], not along"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, -1]\n",
       "s.toml:6:6: camera.up is an array of 3; expected up"},
      {"[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 2]\nup = [0, 0, 0]\n",
       "s.toml:6:6: camera.up is an array of 3; expected a direction that is not zero"},
      {"[medium]\nalbedo = 1.01\n",
       "s.toml:4:10: medium.albedo is 1.01; expected a number in [0, 1]"},
      {"[medium]\nalbedo = [0.5, 0.5, -0.5]\n",
       "s.toml:4:21: medium.albedo[3] is -0.5; expected a number in [0, 1]"},
      {"[medium]\nalbedo = [0.5, 0.5]\n",
       "medium.albedo is an array of 2; expected a number in [0, 1], or an array of 3 of them"},
      {"[medium]\ng = 1\n", "s.toml:4:5: medium.g is 1; expected a number in [-0.9999, 0.9999]"},
      {"[medium]\nextinction = -1\n",
       "s.toml:4:14: medium.extinction is -1; expected a number of at least 0"},
      {"[medium]\nextinction = inf\n",
       "s.toml:4:14: medium.extinction is inf; expected a number of at least 0"},
      {"[medium]\nscale = 0\n",
       "s.toml:4:9: medium.scale is 0; expected a placement that can be undone"},
      {"[medium]\nrotate = [0, 0, 0, 30]\n",
       "s.toml:4:10: medium.rotate is an array of 4; expected an axis that is not zero"},
      {"[medium]\nrotate = [[0, 0, 1, 30], [0, 1]]\n",
       "s.toml:4:26: medium.rotate[2] is an array of 2; expected an array of 4 numbers"},
      {"[medium]\nmatrix = [1, 2]\n", "expected an array of 12 or 16 numbers"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]\n",
       "s.toml:4:10: medium.matrix is an array of 16; expected a last row of 0, 0, 0, 1; the"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]\n",
       "s.toml:4:10: medium.matrix is an array of 12; expected a placement that can be undone"},
      {"[medium]\nmatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nscale = 2\n",
       "s.toml:5:9: medium.scale is 2; expected either matrix, or scale, rotate and translate"},
      {"[environment]\ntype = \"imge\"\n",
       "s.toml:4:8: environment.type is \"imge\"; expected \"constant\", \"gradient\" or "
       "\"image\"; "
       "did you mean \"image\"?"},
      {"[environment]\ntype = \"image\"\n",
       "s.toml:3:1: [environment] has no file; expected the name of a file"},
      {"[environment]\ntype = \"constant\"\nzenith = 1\n",
       "s.toml:5:1: unknown key \"zenith\" in [environment]; expected one of type or radiance"},
      {"[environment]\nradiance = -1\n",
       "s.toml:4:12: environment.radiance is -1; expected a number in [0, 1e+30]"},
      {"[[sun]]\n[[sun]]\nangle = 180.0\n",
       "s.toml:5:9: sun[2].angle is 180.0; expected a number in [0, 180)"},
      {"[[sun]]\nirradiance = [1, 1, 1e39]\n",
       "s.toml:4:21: sun[1].irradiance[3] is 1e+39; expected a number in [0, 1e+30]"},
      {"[sun]\ndirection = [0, 0, 0]\n",
       "s.toml:4:13: sun.direction is an array of 3; expected a direction that is not zero"},
      {"[render]\nsun = 5\n", "s.toml:4:1: unknown key \"sun\" in [render]"},
      {"[render]\nsize = [0, 10]\n",
       "s.toml:4:9: render.size[1] is 0; expected a whole number in 1..1048576"},
      {"[render]\nsize = [10.5, 10]\n", "s.toml:4:9: render.size[1] is 10.5; expected a whole"},
      {"[render]\nsize = [100, 50]\ncrop = [90, 0, 11, 50]\n",
       "s.toml:5:8: render.crop is an array of 4; expected [x, y, width, height] inside the image "
       "of 100 x 50 pixels"},
      {"[render]\nspp = 0\n", "s.toml:4:7: render.spp is 0; expected a whole number in 1..429496"},
      {"[render]\nseed = -1\n",
       "s.toml:4:8: render.seed is -1; expected a whole number in 0..9223"},
      {"[render]\ntracker = \"deltta\"\n",
       "s.toml:4:11: render.tracker is \"deltta\"; expected \"delta-global\", \"delta\", "
       "\"decomposition\", \"weighted-delta\", \"weighted-decomposition\" or \"regular\"; "
       "did you mean \"delta\"?"},
      {"[render]\ndepth = 17\n",
       "s.toml:4:9: render.depth is 17; expected a whole number in 0..16 or \"auto\""},
      {"[render]\ndepth = \"deep\"\n",
       "s.toml:4:9: render.depth is \"deep\"; expected a whole number in 0..16 or \"auto\""},
      {"[render]\nmax_bounces = 1979-05-27\n",
       "s.toml:4:15: render.max_bounces is a date or time; expected a whole number in"},
      {"[render]\nbackground = \"off\"\n",
       "s.toml:4:14: render.background is \"off\"; expected true or false"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_NE(error(kCloud + text).find(message), std::string::npos)
        << text << "gave\n  " << error(kCloud + text) << "\nexpected\n  " << message;
  }
}

TEST_F(SceneText, DensityIsAsStoredUnlessItSaysOtherwise) {
  EXPECT_EQ(read(kCloud).density, std::nullopt);
  EXPECT_EQ(read(kCloud + "[render]\ndensity = \"stored\"\n").density, std::nullopt);
  EXPECT_EQ(read(kCloud + "[render]\ndensity = \"fp8\"\n").density, Quantisation{Precision::fp8});
  EXPECT_EQ(error(kCloud + "[render]\ndensity_tolerance = 0.1\n").find("s.toml:4:21"), 0u);
  EXPECT_NE(error(kCloud + "[render]\ndensity = \"fpn\"\ndensity_tolerance = 0\n").find("s.toml:5"),
            std::string::npos);
}

TEST_F(SceneText, BadFrameworkIsRefused) {
  EXPECT_EQ(error(""), "s.toml: there is no [volume]; add it");
  EXPECT_EQ(error("[volume]\n"), "s.toml:1:1: [volume] has no file; expected the name of a file");
  EXPECT_EQ(error("volume = 3\n"),
            "s.toml:1:10: volume is 3; expected a table [volume] or tables [[volume]]");
  EXPECT_EQ(
      error(kCloud + "[render]\n[[render.sun]]\n"),
      "s.toml:4:10: unknown key \"sun\" in [render]; expected one of size, crop, spp, "
      "first_sample, seed, "
      "tracker, transmittance, micro_bounds, interpolation, shells, guide, depth, max_bounces, "
      "background, light_layers, density, density_tolerance, majorant_scale, homogenise or preview");
  EXPECT_EQ(error("sun = [1]\n" + kCloud), "s.toml:1:8: sun[1] is 1; expected a table");
  EXPECT_NE(error("[recipe]\n").find("s.toml: is a recipe"), std::string::npos);
  EXPECT_NE(error("volume.fil = 3\n").find("s.toml:1:8: unknown key \"fil\" in [volume]"),
            std::string::npos);
  EXPECT_NE(error(std::string("a = \"\xff\"")).find("s.toml:1:"), std::string::npos);
  EXPECT_THROW((void)read_scene(folder_), Error);
  EXPECT_THROW((void)read_scene(folder_ / "absent.toml"), Error);
}

TEST_F(SceneText, SetsReplaceAndAddValues) {
  const std::string text = kCloud + "[medium]\ng = 0.1\n[[sun]]\nangle = 1\n[[sun]]\nangle = 2\n";
  const SceneFile file = read(
      text, {"medium.g=0.5", " medium.albedo = [1, 0.5, 0] ", "render.tracker=delta",
             "render.size=[64,32]", "sun.angle=3", "environment.radiance=1", "volume.file=b.vdb",
             "render.background=false", "volume.grid='fog'", "render.depth=auto"});
  const Component& matter = file.volumes[0].medium.components[0];
  EXPECT_EQ(mean_cosine(matter.phase), 0.5);
  EXPECT_EQ(matter.albedo, Rgb(1, 0.5f, 0));
  EXPECT_EQ(file.scene.options.tracker, Tracker::delta);
  EXPECT_EQ(file.scene.options.width, 64);
  ASSERT_EQ(file.scene.lights.size(), 2u);
  EXPECT_EQ(sun(file, 0).angle, 3);
  EXPECT_EQ(sun(file, 1).angle, 2);
  EXPECT_EQ(file.scene.environment, Environment(ConstantSky{Rgb(1.0f)}));
  // From the current folder, not the scene's.
  EXPECT_EQ(file.volumes[0].file, fs::path("b.vdb"));
  EXPECT_EQ(file.volumes[0].grid, "fog");
  EXPECT_FALSE(file.scene.options.background);
  EXPECT_FALSE(file.scene.options.depth);
}

TEST_F(SceneText, SunIsAddedByASetWhereThereIsNone) {
  const SceneFile file = read(kCloud, {"sun.angle=3", "sun.irradiance=4"});
  ASSERT_EQ(file.scene.lights.size(), 1u);
  EXPECT_EQ(sun(file, 0).angle, 3);
  EXPECT_EQ(sun(file, 0).irradiance, Rgb(4.0f));
  EXPECT_EQ(read("sun = []\n" + kCloud, {"sun.angle=3"}).scene.lights.size(), 1u);
}

TEST_F(SceneText, SetReplacesAWholeSection) {
  const SceneFile file = read(kCloud + "[environment]\ntype = \"gradient\"\nzenith = 1\n[[sun]]\n",
                              {"environment={type='constant', radiance=2}", "sun=[]"});
  EXPECT_EQ(file.scene.environment, Environment(ConstantSky{Rgb(2.0f)}));
  EXPECT_TRUE(file.scene.lights.empty());
}

TEST_F(SceneText, LaterSetsWin) {
  EXPECT_EQ(read(kCloud, {"render.spp=4", "render.spp=5"}).scene.options.samples, 5u);
}

TEST_F(SceneText, BadSetsAreRefusedWithTheirText) {
  const std::pair<const char*, const char*> cases[] = {
      {"medium.g=2", "--set medium.g=2: medium.g is 2; expected a number in [-0.9999, 0.9999]"},
      {"medium.g", "--set medium.g: expected SECTION.KEY=VALUE, e.g. medium.g=0.5"},
      {"medium.g=", "--set medium.g=: expected SECTION.KEY=VALUE"},
      {"=3", "--set =3: expected SECTION.KEY=VALUE"},
      {"medium..g=3", "--set medium..g=3: expected SECTION.KEY=VALUE"},
      {"", "--set : expected SECTION.KEY=VALUE"},
      {"medium.G=0", "--set medium.G=0: unknown key \"G\" in [medium]; expected one of"},
      {"medium.g=0.5.5", "--set medium.g=0.5.5: medium.g is \"0.5.5\"; expected a number in"},
      {"medium.albedo=[1, 2", "--set medium.albedo=[1, 2: the value is not valid TOML: "},
      {"medium.albedo=[1, 2, 1]",
       "--set medium.albedo=[1, 2, 1]: medium.albedo[2] is 2; expected a number in [0, 1]"},
      {
          "volume.file.x=1",
          "--set volume.file.x=1: volume.file is \"cloud.pvol\" and has no keys",
      },
      {"camera.fov=30", "--set camera.fov=30: [camera] has no position; add it"},
      {"g=0.5", "--set g=0.5: unknown section or key \"g\"; expected one of volume, camera"},
  };
  for (const auto& [set, message] : cases) {
    std::string found = error("[volume]\nfile = \"cloud.pvol\"\n", {set});
    if (const auto at = found.find((folder_ / "").string()); at != std::string::npos) {
      found.erase(at, (folder_ / "").string().size());
    }
    EXPECT_EQ(found.substr(0, std::string(message).size()), message);
  }
}

TEST(DefaultScene, HasAGradientSkyAndOneSun) {
  const SceneFile file = default_scene("clouds/my \"best\".vdb");
  EXPECT_EQ(file.volumes, (std::vector{SceneVolume{.file = "clouds/my \"best\".vdb"}}));
  EXPECT_EQ(file.scene.environment, Environment(GradientSky{}));
  ASSERT_EQ(file.scene.lights.size(), 1u);
  EXPECT_EQ(sun(file, 0), (Sun{{-0.75, 0.62, 0.35}, Rgb(3.3f, 3.0f, 2.6f), 0.53}));
  EXPECT_FALSE(file.has_camera);
}

TEST(DefaultScene, IsChangedBySets) {
  const SceneFile file = default_scene(
      "a.vdb", {"medium.extinction=4", "sun.angle=0", "camera={position=[0,0,9],target=[0,0,0]}"});
  EXPECT_TRUE(file.has_camera);
  EXPECT_TRUE(file.volumes[0].has_extinction);
  EXPECT_EQ(file.volumes[0].medium.extinction, 4);
  EXPECT_EQ(sun(file, 0), (Sun{{-0.75, 0.62, 0.35}, Rgb(3.3f, 3.0f, 2.6f), 0}));
}

/// Scenes with values of all magnitudes that a scene may hold.
struct RandomScene {
  std::mt19937_64 bits{11};

  double uniform(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(bits); }
  int whole(int lo, int hi) { return std::uniform_int_distribution(lo, hi)(bits); }
  bool coin() { return whole(0, 1) == 1; }
  double magnitude() { return std::exp2(uniform(-40, 40)); }
  double signed_magnitude() { return coin() ? magnitude() : -magnitude(); }
  Vec3d point() { return {signed_magnitude(), signed_magnitude(), signed_magnitude()}; }
  Rgb radiance() { return Rgb(Vec3d{magnitude(), magnitude(), coin() ? magnitude() : 0}); }

  Environment environment() {
    switch (whole(0, 2)) {
      case 0:
        return ConstantSky{radiance()};
      case 1:
        return GradientSky{radiance(), radiance(), radiance(), point()};
      default:
        return ImageSky{0, 0, {}, radiance(), signed_magnitude()};
    }
  }

  Camera camera() {
    const Vec3d position = point(), target = point(), view = normalize(target - position);
    const Vec3d off_axis{view.z, -view.x, view.y};
    return {position, target, off_axis * magnitude(), uniform(0.1, 179)};
  }

  RenderOptions options() {
    RenderOptions o;
    o.width = whole(1, 1 << 20), o.height = whole(1, 1 << 20);
    o.crop_x = whole(0, o.width - 1), o.crop_y = whole(0, o.height - 1);
    o.crop_width = whole(0, o.width - o.crop_x), o.crop_height = whole(0, o.height - o.crop_y);
    o.samples = std::uint32_t(bits() >> 32) | 1u;
    o.first_sample = std::uint32_t(bits() >> 33);
    o.seed = bits() >> 1;
    o.tracker = Tracker(whole(0, 5));
    o.transmittance = Transmittance(whole(0, 4));
    o.micro_bounds = MicroBoundsUse(whole(0, 3));
    o.look_up = LookUp(whole(0, 3));
    o.shells = ShellUse(whole(0, 2));
    o.guide = GuideUse(whole(0, 2));
    if (coin()) o.depth = whole(0, 16);
    if (coin()) o.max_bounces = std::uint32_t(bits() >> 32);
    o.background = coin();
    o.light_layers = coin();
    if (coin()) o.majorant_scale = uniform(1.0 / 3, 1000);
    if (coin()) o.homogenise = uniform(0, 10);
    o.preview = whole(0, 8);
    return o;
  }

  PhaseFunction phase() {
    const auto lobe = [&] { return HenyeyGreenstein(uniform(-0.9999, 0.9999)); };
    if (coin()) return lobe();
    return TwoLobes{lobe(), lobe(), uniform(0, 1)};
  }

  Component component(double share) {
    return {share, Rgb(Vec3d{uniform(0, 1), uniform(0, 1), double(whole(0, 1))}), phase(),
            coin() ? Rgb(0.0f) : radiance()};
  }

  SceneVolume volume(const char* file) {
    SceneVolume v{file, coin() ? "density[1]" : "", {}, {}, coin()};
    if (v.has_extinction) v.medium.extinction = magnitude();
    v.medium.components = {component(1)};
    for (int n = whole(0, 2); n > 0; --n) {
      v.medium.components.push_back(component(uniform(0, 0.5)));
      v.medium.components.front().share -= v.medium.components.back().share;
    }
    v.object_to_world = {
        {Vec3d{1, uniform(0, 1), 0}, Vec3d{0, 1, uniform(0, 1)}, Vec3d{uniform(0, 1), 0, 1}},
        point()};
    return v;
  }

  SceneFile operator()() {
    SceneFile file;
    file.volumes = {volume("/a folder/\"quoted\" \\ back\tslash \u00e9.vdb")};
    for (int n = whole(0, 2); n > 0; --n) file.volumes.push_back(volume("/other.vdb"));
    file.has_camera = coin();
    if (file.has_camera) file.scene.camera = camera();
    file.scene.environment = environment();
    if (auto* sky = std::get_if<ImageSky>(&file.scene.environment)) sky->file = "/sky.exr";
    for (int n = whole(0, 3); n > 0; --n) {
      file.scene.lights.push_back(Sun{point(), radiance(), uniform(0, 179)});
    }
    file.scene.options = options();
    if (coin()) file.density = Quantisation{Precision(whole(0, 3))};
    if (file.density && file.density->precision == Precision::fpn) {
      file.density->tolerance = uniform(kLeastTolerance, kLargestTolerance);
    }
    return file;
  }
};

TEST_F(SceneText, WrittenScenesReadBackEqual) {
  RandomScene random;
  for (int i = 0; i < 300; ++i) {
    const SceneFile file = random();
    const std::string text = to_toml(file);
    ASSERT_EQ(read(text), file) << text;
    ASSERT_EQ(to_toml(read(text)), text);
  }
  SceneFile largest;
  largest.volumes = {{.file = "/a", .has_extinction = true}};
  for (const double extinction : {0.0, 1e17, 1.2345678901234567e20, 1e300, 5e-324}) {
    largest.volumes[0].medium.extinction = extinction;
    EXPECT_EQ(read(to_toml(largest)), largest) << to_toml(largest);
  }
}

TEST(SceneNames, ComeBackFromTheirText) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(find_named<Tracker>(name(Tracker(i))), Tracker(i));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(find_named<Transmittance>(name(Transmittance(i))), Transmittance(i));
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(find_named<MicroBoundsUse>(name(MicroBoundsUse(i))), MicroBoundsUse(i));
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(find_named<ShellUse>(name(ShellUse(i))), ShellUse(i));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(find_named<LookUp>(name(LookUp(i))), LookUp(i));
  EXPECT_STREQ(name(Tracker::delta_global), "delta-global");
  EXPECT_EQ(find_named<Tracker>("woodcock"), std::nullopt);
  RenderOptions options;
  const auto refusal = find_key(entries(options), "tracker")->set("woodcock");
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->expected,
            "\"delta-global\", \"delta\", \"decomposition\", \"weighted-delta\", "
            "\"weighted-decomposition\" or \"regular\"");
  EXPECT_EQ(options, RenderOptions{});
}

TEST(SceneNames, SeedThatTomlCannotHoldIsRefused) {
  SceneFile file{.volumes = {{.file = "/a"}}};
  file.scene.options.seed = ~std::uint64_t{0};
  EXPECT_THROW((void)to_toml(file), Error);
}

}  // namespace
}  // namespace pvol::formats
