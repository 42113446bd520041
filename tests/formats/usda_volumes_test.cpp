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
