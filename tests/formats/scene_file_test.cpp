#include "pvol/formats/scene_file.h"

#include <gtest/gtest.h>

#include "pvol/error.h"
#include "support/messages.h"
#include "support/scene_text.h"

namespace pvol::formats {
namespace scene_file_test {

void expect_near(Vec3d a, Vec3d b) {
  EXPECT_LT(length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

const char* const kEveryKey = R"(
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
)";

/// What it says besides its volume.
Scene every_key(const std::string& sky_file) {
  Scene want;
  want.camera = {{1, 2, 3}, {4, 5, 6.5}, {0, 0, 1}, 20};
  ImageSky sky;
  sky.scale = Rgb(2.0f);
  sky.rotation = 90;
  sky.file = sky_file;
  want.environment = sky;
  want.lights = {Sun{{1, 1, 0}, {1, 2, 3}, 0.5}, Sun{{0, 1, 0}, Rgb(7.0f), 0}};
  want.options.width = 320, want.options.height = 200;
  want.options.crop_x = 10, want.options.crop_y = 20;
  want.options.crop_width = 30, want.options.crop_height = 40;
  want.options.samples = 17;
  want.options.seed = 99;
  want.options.tracker = Tracker::delta_global;
  want.options.transmittance = Transmittance::analog;
  want.options.micro_bounds = MicroBoundsUse::edge_1;
  want.options.look_up = LookUp::nearest;
  want.options.shells = ShellUse::off;
  want.options.guide = GuideUse::on;
  want.options.depth = 5;
  want.options.max_bounces = 8;
  want.options.background = false;
  want.options.majorant_scale = 2.5;
  want.options.homogenise = 0.125;
  want.options.preview = 2;
  return want;
}

TEST_F(SceneText, EveryKeyIsRead) {
  const SceneFile file = read(kEveryKey);
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
  EXPECT_EQ(file.scene, every_key(folder_ / "sky.exr"));
}

TEST_F(SceneText, PhaseFunctionsAreKnownByTheirFirstKeys) {
  const std::pair<const char*, PhaseFunction> cases[] = {
      {"", HenyeyGreenstein(0.5)},
      {"g = 0", HenyeyGreenstein(0)},
      {"g_forward = 0.9\nforward_share = 0.5",
       TwoLobes{HenyeyGreenstein(0.9), HenyeyGreenstein(-0.3), 0.5}},
      {"rayleigh = true", Rayleigh{}},
      {"draine_g = 0.25\ndraine_alpha = 30", Draine(0.25, 30)},
      {"draine_g = -0.25", Draine(-0.25, 1)},
      {"droplet_diameter = 14", Droplets(14)},
      {"phase_table = [[0, 3], [90, 1.5], [180, 2]]", PhaseTable({{0, 3}, {90, 1.5}, {180, 2}})},
  };
  for (const auto& [text, phase] : cases) {
    const SceneFile file =
        read(kCloud + "[medium]\n" + text + "\n[[medium.component]]\nshare = 0.5\n" + text + "\n");
    for (const Component& c : file.volumes[0].medium.components) EXPECT_EQ(c.phase, phase) << text;
    EXPECT_EQ(read(to_toml(file)), file) << text;
  }
}

/// Whatever the file has is another scene's; two that the command line sets are a slip.
TEST_F(SceneText, SettingAPhaseFunctionReplacesThatOfTheFile) {
  const std::string two = kCloud + "[medium]\ng_forward = 0.9\nforward_share = 0.5\n" +
                          "[[medium.component]]\nshare = 0.5\ng = 0.1\n";
  const auto phases = [&](const Sets& sets) {
    const SceneFile file = read(two, sets);
    std::vector<PhaseFunction> all;
    for (const Component& c : file.volumes[0].medium.components) all.push_back(c.phase);
    return all;
  };
  using Phases = std::vector<PhaseFunction>;
  EXPECT_EQ(phases({"medium.droplet_diameter=9", "medium.component.rayleigh=true"}),
            (Phases{Droplets(9), Rayleigh{}}));
  EXPECT_EQ(phases({"medium.g=0.2", "medium.component.phase_table=[[0,1],[180,2]]"}),
            (Phases{HenyeyGreenstein(0.2), PhaseTable({{0, 1}, {180, 2}})}));
  EXPECT_TRUE(
      says(error(two, {"medium.g=0.2", "medium.rayleigh=true"}), "scene.set_two_phase_functions"));
  EXPECT_NE(error(two, {"medium.g_backward=-0.2", "medium.rayleigh=true"}).find("g_backward"),
            std::string::npos);
}

/// As any option replaces what the file says.
TEST_F(SceneText, AFieldOfViewOfTheCommandLineReplacesAFocalLength) {
  const std::string text = kCloud + "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n";
  const auto camera = [&](const std::string& more, const Sets& sets) {
    return read(text + more, sets).scene.camera;
  };
  EXPECT_EQ(camera("focal_length = 50\nfov = 20\n", {}).focal_length, 50);
  const Camera wide = camera("focal_length = 50\n", {"camera.fov=100"});
  EXPECT_EQ(wide.focal_length, std::nullopt);
  EXPECT_EQ(wide.fov, 100);
  EXPECT_EQ(camera("", {"camera.fov=100", "camera.focal_length=50"}).focal_length, 50);
  EXPECT_TRUE(says(error(text + "projection = \"orthographic\"\n", {"camera.fov=20"}),
                   "scene.fov_of_orthographic"));
}

TEST_F(SceneText, NamesOfOtherProgramsLeadToOurs) {
  EXPECT_TRUE(says(error(kCloud, {"camera.lens=35"}), "scene.lens_is_focal_length"));
  EXPECT_TRUE(says(error(kCloud + "[[sun]]\ncolor = 3\n", {}), "scene.color_is_irradiance"));
  EXPECT_TRUE(says(error(kCloud, {"render.samples=9"}), "scene.samples_is_spp"));
}

TEST_F(SceneText, ABackslashInANameOfAFileIsExplained) {
  EXPECT_TRUE(says(error("[volume]\nfile = \"C:\\Users\\me.vdb\"\n", {}), "scene.backslash"));
  EXPECT_TRUE(says(error(kCloud, {"volume.file=\"C:\\Users\""}), "scene.backslash_in_set"));
}

/// Relative to the scene; of --set, as all files, to the current folder.
TEST_F(SceneText, PhaseTablesAreReadFromTextFiles) {
  fs::create_directories(folder_ / "mie");
  std::ofstream(folder_ / "mie/p.txt", std::ios::binary)
      << "# angle value\r\n0 3\r\n\n  90\t1.5  # aside\n180, 2e0";
  const PhaseFunction expected = PhaseTable({{0, 3}, {90, 1.5}, {180, 2}});
  const SceneFile file = read(kCloud + "[medium]\nphase_table = \"mie/p.txt\"\n" +
                              "[[medium.component]]\nshare = 0.5\nphase_table = \"mie/p.txt\"\n");
  for (const Component& c : file.volumes[0].medium.components) EXPECT_EQ(c.phase, expected);
  EXPECT_EQ(read(to_toml(file)), file);
  const SceneFile set = read(kCloud, {"medium.phase_table=" + (folder_ / "mie/p.txt").string()});
  EXPECT_EQ(set.volumes[0].medium.components[0].phase, expected);
  EXPECT_TRUE(
      says(error(kCloud, {"medium.phase_table=mie/p.txt"}), "scene.set_medium_phase_table_names"));
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

TEST_F(SceneText, FiresAndMapsAreRead) {
  const SceneFile scene = read(R"(
[volume]
file = "fire.vdb"
grid = "none"
[medium.density]
scale = 2
clamp = [0, 1.5]
ramp = [[0, 0], [0.5, 0.25], [1, 3]]
smooth = true
[medium.fire]
field = "flames"
power = 2
intensity = 40
color = [1, 0.5, 2]
color_by = "temperature"
kelvin = 1900
kelvin_of_intensity = 1500
)");
  const SceneVolume& v = scene.volumes.front();
  EXPECT_EQ(v.grid, formats::kNoGrid);
  const FieldMap map{
      .scale = 2, .clamp = {{0, 1.5}}, .ramp = {{{0, 0}, {0.5f, 0.25f}, {1, 3}}, true}};
  EXPECT_EQ(v.density_map, map);
  const Fire fire{.field = "flames",
                  .map = {.power = 2},
                  .intensity = 40,
                  .color = Rgb(1.0f, 0.5f, 2.0f),
                  .color_by = "temperature",
                  .kelvin = 1900,
                  .kelvin_of_intensity = 1500};
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(*v.fire, fire);
  EXPECT_TRUE(v.has_intensity);
  EXPECT_TRUE(scene.scene.lights.empty()) << "a scene with a fire has light";
}

TEST_F(SceneText, AlbedosGoByGrids) {
  const SceneFile scene = read(R"(
[[volume]]
file = "a.vdb"
[[volume]]
file = "b.vdb"
[volume.medium.albedo_field]
grid = "none"
[medium]
albedo = 0.9
[medium.albedo_field]
grid = "temperature"
scale = 0.001
clamp = [0, 1]
power = 2
colors = [[0, 0.1, 0.2, 0.3], [1, 1, 0.5, 0.25]]
)");
  AlbedoMap map{.grid = "temperature", .map = {.scale = 0.001, .clamp = {{0, 1}}, .power = 2}};
  map.colors.channels[0].points = {{0, 0.1f}, {1, 1}};
  map.colors.channels[1].points = {{0, 0.2f}, {1, 0.5f}};
  map.colors.channels[2].points = {{0, 0.3f}, {1, 0.25f}};
  EXPECT_EQ(scene.volumes[0].albedo_field, map);
  EXPECT_EQ(scene.volumes[0].medium.components[0].albedo, Rgb(0.9f));
  ASSERT_TRUE(scene.volumes[1].albedo_field);
  EXPECT_EQ(scene.volumes[1].albedo_field->grid, kNoGrid);
  EXPECT_FALSE(read("[volume]\nfile = \"a.vdb\"\n").volumes[0].albedo_field);
  EXPECT_EQ(read(to_toml(scene)), scene);
}

TEST_F(SceneText, ExtinctionMayHaveAColor) {
  const SceneFile scene =
      read("[volume]\nfile = \"a.vdb\"\n[medium]\nextinction_color = [0.2, 1, 0.5]\n");
  EXPECT_EQ(scene.volumes.front().medium.extinction_color, Rgb(0.2f, 1.0f, 0.5f));
  EXPECT_EQ(read(to_toml(scene)).volumes.front().medium.extinction_color, Rgb(0.2f, 1.0f, 0.5f));
}

TEST_F(SceneText, FiresHaveColorsAlongAField) {
  const SceneFile scene = read(R"(
[volume]
file = "fire.vdb"
[medium.fire]
colors = [[0, 0, 0, 0], [1, 1, 0.5, 0.25]]
)");
  const Fire& fire = *scene.volumes.front().fire;
  EXPECT_FALSE(scene.volumes.front().has_intensity);
  EXPECT_EQ(fire.colors.channels[2].points, (std::vector<RampPoint>{{0, 0}, {1, 0.25f}}));
}

TEST_F(SceneText, InstancesAreMapsAfterThePlacement) {
  const SceneFile file = read(R"([[volume]]
file = "a.vdb"
[[volume.instance]]
translate = [10, 20, 30]
scale = 2
[[volume.instance]]
[[volume]]
file = "b.vdb"
[volume.instance]
rotate = [0, 0, 1, 90]
[volume.medium]
translate = [1, 0, 0]
[medium]
scale = 3
)");
  ASSERT_EQ(file.volumes.size(), 2u);
  const SceneVolume &a = file.volumes[0], &b = file.volumes[1];
  EXPECT_EQ(a.object_to_world, scaling(Vec3d(3.0)));
  EXPECT_EQ(a.instances, (std::vector{translation({10, 20, 30}) * scaling(Vec3d(2.0)), Affine{}}));
  EXPECT_EQ(a.first_place().point({1, 0, 0}), Vec3d(16, 20, 30));
  ASSERT_EQ(b.instances.size(), 1u);
  const Vec3d turned = b.first_place().point({0, 0, 0});
  EXPECT_NEAR(turned.x, 0, 1e-12);
  EXPECT_NEAR(turned.y, 1, 1e-12);
  EXPECT_TRUE(read(kCloud).volumes[0].instances.empty());
  EXPECT_EQ(read(kCloud).volumes[0].first_place(), Affine{});
}

TEST_F(SceneText, CamerasHaveAnotherPlaceAFrameLater) {
  const std::string camera = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 1, 0]\nup = [1, 1, 0]\n";
  const SceneFile file = read(kCloud + camera + "[camera.to]\nposition = [2, 0, 5]\n");
  const CameraPlace expected{{2, 0, 5}, {0, 1, 0}, {1, 1, 0}};
  EXPECT_EQ(file.scene.camera.to, expected) << "keys that are left out keep their values";
  EXPECT_EQ(read(to_toml(file)), file);
  EXPECT_FALSE(read(kCloud + camera).scene.camera.to);
  const SceneFile set = read(kCloud + camera, {"camera.to.target=[0, 2, 0]"});
  EXPECT_EQ(set.scene.camera.to->target, Vec3d(0, 2, 0));
  EXPECT_EQ(set.scene.camera.to->position, Vec3d(0, 0, 5));
  const SceneFile printed = read(
      kCloud + camera + "to = { matrix = [1, 0, 0, 7, 0, 1, 0, 8, 0, 0, 1, 9, 0, 0, 0, 1] }\n");
  EXPECT_EQ(printed.scene.camera.to, (CameraPlace{{7, 8, 9}, {7, 8, 8}, {0, 1, 0}}));
}

TEST_F(SceneText, SurfacesHaveAnotherPlaceAFrameLater) {
  const SceneFile file = read(kCloud +
                              "[[ball]]\ncentre = [1, 2, 3]\nto = { centre = [4, 5, 6] }\n"
                              "[[mesh]]\nfile = \"a.obj\"\nscale = 2\n[mesh.to]\n"
                              "rotate = [0, 1, 0, 30]\n[[solid]]\nfile = \"a.toml\"\n");
  const std::vector<Surface>& all = file.scene.surfaces;
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(std::get<BallSurface>(all[0]).to, (BallPlace{{4, 5, 6}}));
  EXPECT_FALSE(std::get<SolidSurface>(all[1]).to);
  const MeshSurface& mesh = std::get<MeshSurface>(all[2]);
  EXPECT_EQ(mesh.to->scale, Vec3d(2)) << "keys that are left out keep their values";
  EXPECT_EQ(mesh.to->rotate, (std::vector<Turn>{{{0, 1, 0}, 30}}));
  EXPECT_EQ(read(to_toml(file)), file);
}

TEST_F(SceneText, PlacesHaveAnotherOneAFrameLater) {
  const SceneFile file = read(R"([volume]
file = "a.vdb"
[volume.to]
translate = [5, 0, 0]
[[volume.instance]]
translate = [10, 0, 0]
[[volume.instance]]
scale = 2
rotate = [0, 0, 1, 30]
to = { rotate = [0, 0, 1, 400], translate = [0, 1, 0] }
[[volume.instance]]
rotate = [0, 1, 0, 20]
to = { matrix = [1, 0, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5] }
[medium]
scale = 3
translate = [1, 2, 3]
)");
  const SceneVolume& v = file.volumes.front();
  ASSERT_TRUE(v.moving);
  EXPECT_EQ(v.object_to_world, v.moving->from.map());
  EXPECT_EQ(v.moving->from.translate, Vec3d(1, 2, 3));
  EXPECT_EQ(v.moving->to.map(), translation({5, 0, 0}) * scaling(Vec3d(3.0)));
  ASSERT_EQ(v.moving_instances.size(), 3u);
  EXPECT_FALSE(v.moving_instances[0]);
  const MovingPlacement& turns = *v.moving_instances[1];
  EXPECT_EQ(v.instances[1], turns.from.map());
  EXPECT_EQ(turns.to.scale, Vec3d(2.0));
  EXPECT_EQ(turns.to.rotate, (std::vector<Turn>{{{0, 0, 1}, 400}}));
  EXPECT_EQ(turns.to.translate, Vec3d(0, 1, 0));
  EXPECT_EQ(v.moving_instances[2]->to.map(), translation({3, 4, 5}));
  EXPECT_TRUE(v.moving_instances[2]->to.rotate.empty()) << "a matrix says all";
  EXPECT_EQ(read(to_toml(file)), file);
  EXPECT_FALSE(read(kCloud).volumes[0].moving);
  // By the command line, too.
  const SceneFile set = read(kCloud, {"volume.to.rotate=[0, 1, 0, 40]"});
  EXPECT_EQ(set.volumes[0].moving->to.rotate.front().degrees, 40);
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
  Scene lit;  // as a cloud without a scene is
  lit.lights = default_scene("cloud.pvol", {}).scene.lights;
  EXPECT_EQ(lit.lights.size(), 1u);
  EXPECT_EQ(file.scene, lit);
  EXPECT_EQ(read(kCloud + "[environment]\nradiance = 1\n").scene.lights.size(), 0u);
  EXPECT_EQ(read(kCloud + "[medium]\nemission = 1\n").scene.lights.size(), 0u) << "a fire";
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
  EXPECT_EQ(sun(file, 0).direction, Vec3d(0, 1, 0)) << "overhead";
}

TEST_F(SceneText, SurfacesAreReadByKind) {
  const SceneFile file = read(kCloud +
                              "[[mesh]]\nfile = \"a/b.obj\"\nscale = 2\nlook = \"holdout\"\n"
                              "[[plane]]\nalbedo = [0.1, 0.2, 0.3]\n"
                              "[solid]\nfile = \"/c.toml\"\nlook = \"shadow-catcher\"\n"
                              "[[plane]]\npoint = [1, 2, 3]\nnormal = [1, 0, 0]\n");
  const auto& all = file.scene.surfaces;
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(std::get<PlaneSurface>(all[0]).normal, Vec3d(0, 1, 0));
  EXPECT_EQ(material_of(all[0]).albedo, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(std::get<PlaneSurface>(all[1]).point, Vec3d(1, 2, 3));
  EXPECT_EQ(std::get<PlaneSurface>(all[1]).normal, Vec3d(1, 0, 0));
  EXPECT_EQ(material_of(all[2]).visibility, Visibility::shadow_catcher);
  EXPECT_EQ(std::get<SolidSurface>(all[2]).file, "/c.toml");
  const auto& mesh = std::get<MeshSurface>(all[3]);
  EXPECT_TRUE(mesh.file.ends_with("/a/b.obj")) << mesh.file << " is relative to the scene";
  EXPECT_EQ(mesh.place.map().point({1, 1, 1}), Vec3d(2.0));
  EXPECT_EQ(mesh.material.visibility, Visibility::holdout);
  const SceneFile upright = read(kCloud + "[world]\nup = \"z\"\n[[plane]]\n");
  EXPECT_EQ(std::get<PlaneSurface>(upright.scene.surfaces[0]).normal, Vec3d(0, 0, 1));
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

TEST_F(SceneText, DensityIsAsStoredUnlessItSaysOtherwise) {
  EXPECT_EQ(read(kCloud).density, std::nullopt);
  EXPECT_EQ(read(kCloud + "[render]\ndensity = \"stored\"\n").density, std::nullopt);
  EXPECT_EQ(read(kCloud + "[render]\ndensity = \"fp8\"\n").density, Quantisation{Precision::fp8});
  EXPECT_EQ(error(kCloud + "[render]\ndensity_tolerance = 0.1\n").find("s.toml:4:21"), 0u);
  EXPECT_NE(error(kCloud + "[render]\ndensity = \"fpn\"\ndensity_tolerance = 0\n").find("s.toml:5"),
            std::string::npos);
}

TEST_F(SceneText, SetsReplaceAndAddValues) {
  const std::string text = kCloud + "[medium]\ng = 0.1\n[[sun]]\nangle = 1\n[[sun]]\nangle = 2\n";
  const SceneFile file = read(
      text, {"medium.g=0.5", " medium.albedo = [1, 0.5, 0] ", "render.tracker=delta",
             "render.size=[64,32]", "sun.angle=3", "environment.radiance=1", "volume.file=b.vdb",
             "render.background=false", "volume.grid='fog'", "render.depth=auto"});
  const Component& component = file.volumes[0].medium.components[0];
  EXPECT_EQ(mean_cosine(component.phase), 0.5);
  EXPECT_EQ(component.albedo, Rgb(1, 0.5f, 0));
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

TEST(DefaultScene, HasAGradientSkyAndOneSun) {
  const SceneFile file = default_scene("clouds/my \"best\".vdb");
  EXPECT_EQ(file.volumes, (std::vector{SceneVolume{.file = "clouds/my \"best\".vdb"}}));
  EXPECT_EQ(file.scene.environment, Environment(GradientSky{}));
  ASSERT_EQ(file.scene.lights.size(), 1u);
  EXPECT_EQ(sun(file, 0), (Sun{{-0.75, 0.62, 0.35}, Rgb(3.3f, 3.0f, 2.6f), 0.53}));
  EXPECT_FALSE(file.has_camera);
}

TEST_F(SceneText, MayStandOnZ) {
  const SceneFile file = default_scene("a.vdb", {"world.up=z", "sun.angle=0"});
  const GradientSky sky{.up = {0, 0, 1}};
  EXPECT_EQ(file.scene.environment, Environment(sky));
  EXPECT_EQ(file.scene.camera.up, Vec3d(0, 0, 1));
  EXPECT_EQ(sun(file, 0), (Sun{{-0.75, -0.35, 0.62}, Rgb(3.3f, 3.0f, 2.6f), 0}));
  const std::string image = "\n[environment]\nfile = \"a.exr\"\n";
  const std::string z = "[world]\nup = \"z\"\n";
  const auto up = [](const SceneFile& f) { return std::get<ImageSky>(f.scene.environment).up; };
  EXPECT_EQ(up(read(z + kCloud + image, {})), Vec3d(0, 0, 1));
  EXPECT_EQ(up(read(kCloud + image, {})), Vec3d(0, 1, 0));
  EXPECT_EQ(up(read(z + kCloud + image + "up = [1, 0, 0]\n", {})), Vec3d(1, 0, 0)) << "it says so";
  EXPECT_EQ(read(z + kCloud + "\n[camera]\nup = [0, 1, 0]\n", {}).scene.camera.up, Vec3d(0, 1, 0));
}

TEST(DefaultScene, IsChangedBySets) {
  const SceneFile file = default_scene(
      "a.vdb", {"medium.extinction=4", "sun.angle=0", "camera={position=[0,0,9],target=[0,0,0]}"});
  EXPECT_TRUE(file.has_camera);
  EXPECT_TRUE(file.volumes[0].has_extinction);
  EXPECT_EQ(file.volumes[0].medium.extinction, 4);
  EXPECT_EQ(sun(file, 0), (Sun{{-0.75, 0.62, 0.35}, Rgb(3.3f, 3.0f, 2.6f), 0}));
}

TEST(DefaultScene, TakesNumbersAsPeopleWriteThem) {
  const SceneFile file =
      default_scene("a.vdb", {"medium.extinction=.25", "medium.albedo=[.9, 1., 5e-1]",
                              "medium.g=-.5", "environment.radiance=1."});
  EXPECT_EQ(file.volumes[0].medium.extinction, 0.25);
  EXPECT_EQ(file.volumes[0].medium.components[0].albedo, Rgb(0.9f, 1.0f, 0.5f));
  EXPECT_EQ(mean_cosine(file.volumes[0].medium.components[0].phase), -0.5);
  EXPECT_EQ(file.scene.environment, Environment(ConstantSky{Rgb(1.0f)}));
}

TEST(DefaultScene, CameraMayHaveNoPlace) {
  const SceneFile file = default_scene("a.vdb", {"camera.fov=10", "camera.up=[0,0,1]"});
  EXPECT_FALSE(file.has_camera);
  EXPECT_EQ(file.scene.camera.fov, 10);
  EXPECT_EQ(file.scene.camera.up, Vec3d(0, 0, 1));
}

TEST_F(SceneText, SetsReachEachOfAList) {
  const SceneFile file = read("[[volume]]\nfile = \"a.vdb\"\n[[volume]]\nfile = \"b.vdb\"\n",
                              {"volume[2].grid=smoke", "volume[2].medium.extinction=3",
                               "volume[1].grid=fire", "medium.extinction=2"});
  EXPECT_EQ(file.volumes[0].grid, "fire");
  EXPECT_EQ(file.volumes[0].medium.extinction, 2);
  EXPECT_EQ(file.volumes[1].grid, "smoke");
  EXPECT_EQ(file.volumes[1].medium.extinction, 3);
}

TEST_F(SceneText, AnotherSkyMayBeSetOverThatOfTheFile) {
  const std::string gradient = kCloud + "[environment]\nzenith = [1, 2, 3]\n";
  EXPECT_EQ(
      read(gradient, {"environment.type=constant", "environment.radiance=4"}).scene.environment,
      Environment(ConstantSky{Rgb(4.0f)}));
  const SceneFile same = read(gradient, {"environment.type=gradient"});
  EXPECT_EQ(std::get<GradientSky>(same.scene.environment).zenith, Rgb(1, 2, 3));
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
  EXPECT_TRUE(says(refusal->expected, "limits.trackers"));
  EXPECT_EQ(options, RenderOptions{});
}

}  // namespace scene_file_test
}  // namespace pvol::formats
