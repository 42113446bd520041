// What becomes of USD's volumes: fields, files of frames, shaders, instances.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/density/voxel_grid.h"
#include "pvol/formats/vdb.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_volumes_test {

using test::error_of;
using test::kUsdCloud;
using test::read_usda_text;
using test::usda_notes;
using test::usda_text;

/// A field of a file, whose grid has its own name.
std::string field(const std::string& role, const std::string& file = "@a.vdb@",
                  const std::string& more = "") {
  return "rel field:" + role + " = </v/" + role + ">\ndef OpenVDBAsset \"" + role +
         "\" { asset filePath = " + file + " token fieldName = \"" + role + "_grid\" " + more +
         " }\n";
}

ImportedScene scene_of(const std::string& fields, const std::string& rest = "",
                       std::optional<int> frame = {}) {
  return read_usda_text(usda_text(rest, "", "def Volume \"v\" {\n" + fields + "}\n"), frame);
}

SceneVolume volume_of(const std::string& fields, const std::string& rest = "",
                      std::optional<int> frame = {}) {
  return scene_of(fields, rest, frame).file.volumes.at(0);
}

TEST(UsdaVolumes, FieldsByTheirNames) {
  const SceneVolume v = volume_of(field("density") + field("flames") + field("temperature") +
                                  field("vel", "@v.vdb@") + field("Cd"));
  EXPECT_EQ(v.file.filename(), "a.vdb");
  EXPECT_EQ(v.grid, "density_grid");
  ASSERT_TRUE(v.fire.has_value());
  EXPECT_EQ(v.fire->field, "flames_grid");
  EXPECT_EQ(v.fire->color_by, "temperature_grid");
  EXPECT_EQ(v.fire->kelvin, 1);
  EXPECT_FALSE(v.has_intensity);
  EXPECT_FALSE(v.has_extinction);  // USD's densities have no unit
  ASSERT_TRUE(v.velocity.has_value());
  EXPECT_EQ(v.velocity->field, "vel_grid");
  EXPECT_EQ(v.velocity->file.filename(), "v.vdb");
  ASSERT_TRUE(v.albedo_field.has_value());
  EXPECT_EQ(v.albedo_field->grid, "Cd_grid");
}

TEST(UsdaVolumes, FiresWithoutSmokeAndSmokeWithoutFire) {
  EXPECT_EQ(volume_of(field("flame")).grid, kNoGrid);
  EXPECT_EQ(volume_of(field("temperature")).fire->field, "temperature_grid");
  const ImportedScene smoke = scene_of(field("density") + field("temperature"));
  EXPECT_FALSE(smoke.file.volumes.at(0).fire.has_value());
  EXPECT_TRUE(says(usda_notes(smoke), "usd.temperature_alone"));
  EXPECT_EQ(volume_of(field("smoke")).grid, "smoke_grid");  // the only one
}

TEST(UsdaVolumes, WhatHasNoUseIsNamed) {
  const ImportedScene s =
      scene_of(field("density") + field("flames", "@b.vdb@") + field("pressure") +
               "rel field:x = </none>\nrel field:y = </v>\n");
  EXPECT_TRUE(says(usda_notes(s), "usd.another_file"));
  EXPECT_TRUE(says(usda_notes(s), "usd.field_without_use"));
  EXPECT_TRUE(says(usda_notes(s), "usd.field_missing"));
  EXPECT_TRUE(says(usda_notes(s), "usd.field_of_another_kind"));
  EXPECT_TRUE(says(error_of([] { (void)scene_of(field("density", "@op:/obj/smoke@")); }),
                   "usd.field_no_vdb"));
}

/// Some programs number all grids of a file.
TEST(UsdaVolumes, TheNumberOfAFieldCountsWhereTheFileHasItsNameAgain) {
  const TemporaryFolder folder;
  const float one = 1;
  VoxelGrid grid =
      make_grid(DenseArray{.values = &one, .size = {1, 1, 1}, .stride = Vec3l{1, 1, 1}}, Affine{});
  grid.name = "density_grid";
  write_vdb(folder.file("two.vdb"), {&grid, &grid});
  write_vdb(folder.file("one.vdb"), {&grid});
  const auto grid_of = [&](const std::string& file, const std::string& index) {
    return volume_of(field("density", "@" + folder.file(file).string() + "@",
                           "int fieldIndex = " + index))
        .grid;
  };
  EXPECT_EQ(grid_of("two.vdb", "0"), "density_grid");
  EXPECT_EQ(grid_of("two.vdb", "1"), "density_grid[1]");
  EXPECT_EQ(grid_of("one.vdb", "1"), "density_grid");
  EXPECT_EQ(grid_of("none.vdb", "1"), "density_grid");
}

std::string sequence(const std::string& samples) {
  return "rel field:density = </v/d>\ndef OpenVDBAsset \"d\" { asset filePath.timeSamples = { " +
         samples + " } token fieldName = \"density\" }\n";
}

TEST(UsdaVolumes, FilesOfFramesBecomeAPatternUnlessAFrameIsAskedFor) {
  const std::string padded = sequence("1: @s.0001.vdb@, 2: @s.0002.vdb@, 10: @s.0010.vdb@");
  EXPECT_EQ(volume_of(padded).file.filename(), "s.####.vdb");
  EXPECT_EQ(volume_of(padded, "", 2).file.filename(), "s.0002.vdb");
  EXPECT_EQ(volume_of(padded, "", 5).file.filename(), "s.0002.vdb");  // held
  EXPECT_EQ(volume_of(sequence("1: @s1.vdb@, 10: @s10.vdb@")).file.filename(), "s#.vdb");
  EXPECT_EQ(volume_of(sequence("1: @s.0101.vdb@, 2: @s.0102.vdb@")).file.filename(), "s.0101.vdb");
  EXPECT_EQ(volume_of(sequence("3: @s.0003.vdb@")).file.filename(), "s.0003.vdb");
  EXPECT_TRUE(says(usda_notes(scene_of(padded)), "usd.sequence"));
}

std::string material(const std::string& shader) {
  return "def Material \"m\" { token outputs:volume.connect = </m/s.outputs:out>\n"
         "def Shader \"s\" { " +
         shader + " } }\n";
}
const std::string kBound = field("density") + "rel material:binding = </m>\n";

TEST(UsdaVolumes, CoefficientsOfMaterialx) {
  const SceneVolume v = volume_of(
      kBound,
      material("uniform token info:id = \"ND_anisotropic_vdf_vector3\"\n"
               "vector3f inputs:absorption = (1, 0, 2) vector3f inputs:scattering = (3, 2, 0)\n"
               "float inputs:anisotropy = 0.4"));
  EXPECT_TRUE(v.has_extinction);
  EXPECT_EQ(v.medium.extinction, 4);
  EXPECT_EQ(v.medium.extinction_color, (Rgb{1, 0.5f, 0.5f}));
  EXPECT_EQ(v.medium.components.front().albedo, (Rgb{0.75f, 1, 0}));
  EXPECT_EQ(std::get<HenyeyGreenstein>(v.medium.components.front().phase).mean_cosine, 0.4);
}

TEST(UsdaVolumes, ArnoldsStandardVolume) {
  const SceneVolume v =
      volume_of(kBound, material("uniform token info:id = \"arnold:standard_volume\"\n"
                                 "float inputs:density = 5 float inputs:scatter = 0.5\n"
                                 "color3f inputs:scatter_color = (1, 0.8, 0.6)"));
  EXPECT_NEAR(v.medium.extinction, 5, 1e-12);  // what is left is 1/e by default
  EXPECT_LT(length(Vec3d(v.medium.components.front().albedo) - Vec3d(0.5, 0.4, 0.3)), 1e-6);
}

TEST(UsdaVolumes, OtherShadersAreNamed) {
  const auto notes = [](const std::string& shader) {
    return usda_notes(scene_of(kBound, material(shader)));
  };
  EXPECT_TRUE(says(notes("uniform token info:id = \"kma_pyro\""), "usd.other_shader"));
  EXPECT_TRUE(says(usda_notes(scene_of(kBound, "def Material \"m\" { }")), "usd.no_volume_shader"));
  EXPECT_TRUE(says(notes("uniform token info:id = \"arnold:standard_volume\"\n"
                         "float inputs:density.connect = </m/x.out>\nfloat inputs:emission = 2"),
                   "usd.connected_input"));
}

TEST(UsdaVolumes, InputsThatAMaterialPassesToItsShader) {
  const std::string arnold = "uniform token info:id = \"arnold:standard_volume\"\n";
  const auto extinction = [&](const std::string& inputs, const std::string& shader) {
    const SceneVolume v = volume_of(kBound, "def Material \"m\" { " + inputs +
                                                "\ntoken outputs:volume.connect = </m/s.out>\n"
                                                "def Shader \"s\" { " +
                                                arnold + shader + " } }\n");
    return v.has_extinction ? v.medium.extinction : -1;
  };
  const std::string connected = "float inputs:density.connect = </m.inputs:smoke>\n";
  EXPECT_NEAR(extinction("float inputs:smoke = 5", connected), 5, 1e-12);
  EXPECT_NEAR(extinction("float inputs:smoke = 5",
                         "float inputs:density.connect = </m/g.inputs:thick>\n} def NodeGraph "
                         "\"g\" { float inputs:thick.connect = </m.inputs:smoke>\n"),
              5, 1e-12);
  // The connection leads to nothing: what the shader says itself holds, as in USD.
  EXPECT_NEAR(extinction("float inputs:smoke", "float inputs:density = 3\n" + connected), 3, 1e-12);
  EXPECT_EQ(extinction("float inputs:smoke", connected), -1);
  EXPECT_EQ(extinction("float inputs:smoke.connect = </m.inputs:smoke>", connected), -1);
}

TEST(UsdaVolumes, ExtinctionOfTexturesIsLeftOpen) {
  const std::string texture =
      "connect = </m/t.outputs:r>\n} def Shader \"t\" { float outputs:r\n"
      "uniform token info:id = \"UsdUVTexture\"";
  const auto scene = [&](const std::string& shader) {
    return scene_of(kBound, material("uniform token info:id = " + shader + texture));
  };
  const ImportedScene arnold = scene(
      "\"arnold:standard_volume\"\ncolor3f inputs:scatter_color = (1, 0.5, 0.25)\n"
      "float inputs:density = 7\nfloat inputs:density.");
  EXPECT_FALSE(arnold.file.volumes.at(0).has_extinction);
  EXPECT_EQ(arnold.file.volumes.at(0).medium.components.front().albedo, (Rgb{1, 0.5f, 0.25f}));
  EXPECT_TRUE(says(usda_notes(arnold), "usd.connected_input"));
  EXPECT_TRUE(says(usda_notes(arnold), "usd.open_extinction"));
  const ImportedScene materialx = scene(
      "\"ND_anisotropic_vdf_vector3\"\nvector3f inputs:absorption = (1, 1, 1)\n"
      "vector3f inputs:scattering.");
  EXPECT_FALSE(materialx.file.volumes.at(0).has_extinction);
  // The colour alone varies.
  const ImportedScene colored =
      scene("\"arnold:standard_volume\"\nfloat inputs:density = 7\ncolor3f inputs:scatter_color.");
  EXPECT_NEAR(colored.file.volumes.at(0).medium.extinction, 7, 1e-12);
}

TEST(UsdaVolumes, InstancersPlaceVolumes) {
  const ImportedScene s =
      read_usda_text(usda_text(R"(def PointInstancer "p" {
  point3f[] positions = [(1, 0, 0), (0, 2, 0), (0, 0, 3)]
  quath[] orientations = [(1, 0, 0, 0), (0, 0, 1, 0), (1, 0, 0, 0)]
  float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1)]
  int[] protoIndices = [0, 0, 1]
  rel prototypes = [</p/cloud>, </p/ball>]
  double3 xformOp:translate = (10, 0, 0)
  uniform token[] xformOpOrder = ["xformOp:translate"])" +
                                   test::usd_cloud("/p") + "def Sphere \"ball\" { } }",
                               "", ""));
  ASSERT_EQ(s.file.volumes.size(), 1u);
  const SceneVolume& v = s.file.volumes[0];
  ASSERT_EQ(v.instances.size(), 2u);
  EXPECT_EQ(v.instances[0], translation({11, 0, 0}));
  // A half turn about y.
  EXPECT_LT(length(v.instances[1].point({1, 1, 1}) - Vec3d{8, 4, -2}), 1e-12);
  EXPECT_EQ(s.file.scene.surfaces.size(), 0u);
  EXPECT_TRUE(says(usda_notes(s), "usd.instances_of_others"));
}

/// Where a PointInstancer of these lines, of volumes at x = 1, 2, 3, has its instances.
ImportedScene instanced(const std::string& lines, const std::string& metadata = "") {
  return read_usda_text(usda_text("def PointInstancer \"p\" (" + metadata +
                                      ") {\n"
                                      "point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n"
                                      "int[] protoIndices = [0, 0, 0]\n"
                                      "rel prototypes = [</p/cloud>]\n" +
                                      lines + test::usd_cloud("/p") + "}\n",
                                  "", ""));
}
std::vector<double> places_of(const ImportedScene& s) {
  std::vector<double> x;
  for (const Affine& place : s.file.volumes.at(0).instances) x.push_back(place.t.x);
  return x;
}
using Places = std::vector<double>;

TEST(UsdaVolumes, InactiveAndInvisibleInstancesAreNotThere) {
  EXPECT_EQ(places_of(instanced("int64[] invisibleIds = [1]")), (Places{1, 3}));
  EXPECT_EQ(places_of(instanced("", "inactiveIds = [0]")), (Places{2, 3}));
  EXPECT_EQ(places_of(instanced("int64[] invisibleIds = [2]", "prepend inactiveIds = [0, 9]")),
            (Places{2}));
  const std::string ids = "int64[] ids = [70, 80, 90]\n";
  EXPECT_EQ(places_of(instanced(ids + "int64[] invisibleIds = [90, 1]", "inactiveIds = [70]")),
            (Places{2}));
  const ImportedScene s = instanced(ids + "int64[] invisibleIds = [90]");
  EXPECT_EQ(usda_notes(s).find("nvisibleIds"), std::string::npos);
  EXPECT_TRUE(says(error_of([] { (void)instanced("int64[] ids = [1, 2]"); }), "usd.ids_missing"));
}

TEST(UsdaVolumes, InstancesThatAreOthersAFrameLaterStayInPlace) {
  const std::string one = "1: [(1, 0, 0), (2, 0, 0)], ";
  const auto scene = [&](const std::string& lines) {
    return read_usda_text(usda_text("def PointInstancer \"p\" {\nrel prototypes = [</p/cloud>]\n" +
                                        lines + test::usd_cloud("/p") + "}\n",
                                    "", ""));
  };
  const ImportedScene born =
      scene("point3f[] positions.timeSamples = { " + one +
            "2: [(5, 0, 0), (6, 0, 0), (7, 0, 0)] }\n"
            "int[] protoIndices.timeSamples = { 1: [0, 0], 2: [0, 0, 0] }\n");
  EXPECT_EQ(places_of(born), (Places{1, 2}));
  EXPECT_TRUE(born.file.volumes.at(0).moving_instances.empty());
  EXPECT_TRUE(says(usda_notes(born), "usd.other_instances"));
  const std::string moved = "point3f[] positions.timeSamples = { " + one +
                            "2: [(5, 0, 0), (6, 0, 0)] }\nint[] protoIndices = [0, 0]\n";
  EXPECT_EQ(scene(moved).file.volumes.at(0).moving_instances.size(), 2u);
  const ImportedScene renamed =
      scene(moved + "int64[] ids.timeSamples = { 1: [1, 2], 2: [2, 3] }\n");
  EXPECT_TRUE(renamed.file.volumes.at(0).moving_instances.empty());
}

TEST(UsdaVolumes, InstancesWithoutAnOrientationAreNotTurned) {
  EXPECT_EQ(
      places_of(instanced("quath[] orientations = [(0, 0, 0, 0), (1, 0, 0, 0), (0, 0, 0, 0)]")),
      (Places{1, 2, 3}));
}

TEST(UsdaVolumes, MovingVolumes) {
  const ImportedScene s =
      scene_of(field("density") +
               "double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (1, 0, 0) }\n"
               "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
  const SceneVolume& v = s.file.volumes.at(0);
  ASSERT_TRUE(v.moving.has_value());
  EXPECT_EQ(v.moving->from.map(), Affine{});
  EXPECT_EQ(v.moving->to.map(), translation({1, 0, 0}));
  const std::string mirrored =
      "float3 xformOp:scale.timeSamples = { 1: (1, 1, 1), 2: (-1, 1, 1) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:scale\"]\n";
  const ImportedScene flips = scene_of(field("density") + mirrored);
  EXPECT_FALSE(flips.file.volumes.at(0).moving.has_value());
  EXPECT_TRUE(says(usda_notes(flips), "usd.no_way"));
}

}  // namespace usda_volumes_test
}  // namespace pvol::formats
