// What becomes of USD's surfaces.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/error_of.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_surfaces_test {

using test::error_of;
using test::read_usda_text;
using test::usda_notes;
using test::usda_prim;
using test::usda_text;

const std::string kSquare = R"(
int[] faceVertexCounts = [4]
int[] faceVertexIndices = [0, 1, 2, 3]
point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
uniform token subdivisionScheme = "none"
)";

ImportedScene scene_of(const std::string& type, const std::string& lines,
                       const std::string& order = "", const std::string& rest = "") {
  return read_usda_text(usda_text(usda_prim(type, lines, order) + rest));
}

const Material& look_of(const ImportedScene& s, std::size_t i = 0) {
  return material_of(s.file.scene.surfaces.at(i));
}

double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t[0]];
    area += length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)) / 2;
  }
  return area;
}

TEST(UsdaSurfaces, MeshesAreTrianglesInTheWorldByColour) {
  const std::string red = "color3f[] primvars:displayColor = [(1, 0, 0)]\n";
  const std::string order = "float3 xformOp:scale = (3, 2, 1)\n";
  const ImportedScene s = read_usda_text(
      usda_text(usda_prim("Mesh", kSquare + red + order, "\"xformOp:scale\"") + "def Mesh \"b\" {" +
                kSquare + "}\ndef Mesh \"c\" {" + kSquare + red + "}"));
  ASSERT_EQ(s.meshes.size(), 2u);
  EXPECT_EQ(s.meshes[0].name, "out_mesh1.ply");
  EXPECT_NEAR(area_of(s.meshes[0].mesh), 7, 1e-12);  // 3 x 2 and 1 x 1
  EXPECT_NEAR(area_of(s.meshes[1].mesh), 1, 1e-12);
  EXPECT_EQ(look_of(s).albedo, (Rgb{1, 0, 0}));
  EXPECT_EQ(look_of(s, 1).albedo, Rgb(0.5f));
}

TEST(UsdaSurfaces, PlanesAndCubes) {
  EXPECT_NEAR(area_of(scene_of("Plane", "double width = 3 double length = 5").meshes.at(0).mesh),
              15, 1e-12);
  for (const char* axis : {"X", "Y", "Z"}) {
    const ImportedScene s =
        scene_of("Plane", std::string("double width = 4 uniform token axis = \"") + axis + '"');
    for (const Vec3d v : s.meshes.at(0).mesh.vertices) EXPECT_EQ(v[axis[0] - 'X'], 0) << axis;
  }
  EXPECT_NEAR(area_of(scene_of("Cube", "double size = 3").meshes.at(0).mesh), 54, 1e-12);
}

TEST(UsdaSurfaces, SpheresAreBallsWhereTheyAreRound) {
  const std::string even = "double radius = 2\nfloat3 xformOp:scale = (3, 3, 3)\n";
  const ImportedScene s = scene_of("Sphere", even, "\"xformOp:scale\"");
  EXPECT_NEAR(std::get<BallSurface>(s.file.scene.surfaces.at(0)).radius, 6, 1e-12);
  const ImportedScene flat =
      scene_of("Sphere", "float3 xformOp:scale = (3, 1, 3)\n", "\"xformOp:scale\"");
  EXPECT_EQ(flat.file.scene.surfaces.size(), 0u);
  EXPECT_TRUE(says(usda_notes(flat), "usd.stretched_sphere"));
}

TEST(UsdaSurfaces, WhatMovesHasAFileOfItsOwn) {
  const ImportedScene s =
      scene_of("Mesh", kSquare + "float xformOp:rotateZ.timeSamples = { 0: 0, 1: 90 }\n",
               "\"xformOp:rotateZ\"");
  const auto& mesh = std::get<MeshSurface>(s.file.scene.surfaces.at(0));
  ASSERT_TRUE(mesh.to.has_value());
  EXPECT_EQ(mesh.place.map(), Affine{});
  EXPECT_LT(length(mesh.to->map().point({1, 0, 0}) - Vec3d{0, 1, 0}), 1e-12);
  EXPECT_EQ(s.meshes.at(0).mesh.vertices.at(2), Vec3d(1, 1, 0));
}

TEST(UsdaSurfaces, ColoursOfMaterialsAndOfThemselves) {
  const std::string material =
      "def Material \"m\" { token outputs:surface.connect = </m/s.out>\n"
      "def Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\"\n";
  const std::string bound = "rel material:binding = </m>\n";
  const ImportedScene s =
      scene_of("Sphere", bound, "", material + "color3f inputs:diffuseColor = (0.1, 0.2, 0.3) } }");
  EXPECT_EQ(look_of(s).albedo, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_TRUE(says(usda_notes(s), "usd.preview_surface"));
  const ImportedScene textured =
      scene_of("Sphere", bound + "color3f[] primvars:displayColor = [(0, 0, 0), (1, 2, 1)]\n", "",
               material + "color3f inputs:diffuseColor.connect = </m/t.out> } }");
  EXPECT_EQ(look_of(textured).albedo, (Rgb{0.5f, 1, 0.5f}));
  EXPECT_TRUE(says(usda_notes(textured), "usd.textured"));
  EXPECT_TRUE(says(usda_notes(textured), "usd.mean_colour"));
}

TEST(UsdaSurfaces, ColoursThatAMaterialPassesToItsShader) {
  const ImportedScene s = scene_of("Sphere", "rel material:binding = </m>\n", "",
                                   R"(def Material "m" {
  color3f inputs:tint = (0.1, 0.2, 0.3)
  token outputs:surface.connect = </m/g.outputs:out>
  def NodeGraph "g" {
    color3f inputs:tint.connect = </m.inputs:tint>
    token outputs:out.connect = </m/g/s.outputs:out>
    def Shader "s" {
      uniform token info:id = "UsdPreviewSurface"
      color3f inputs:diffuseColor.connect = </m/g.inputs:tint>
    }
  }
})");
  EXPECT_EQ(look_of(s).albedo, (Rgb{0.1f, 0.2f, 0.3f}));
}

TEST(UsdaSurfaces, ConstantColoursHoldForAllThatIsWithin) {
  const auto albedo = [](const std::string& outer, const std::string& inner,
                         const std::string& own = "") {
    const ImportedScene s = read_usda_text(usda_text(
        "def \"a\" {" + outer + " def \"b\" {" + inner + " def Sphere \"s\" {" + own + "} } }"));
    return look_of(s).albedo;
  };
  const auto color = [](const std::string& values, const std::string& interpolation = "constant") {
    return "color3f[] primvars:displayColor = [" + values + "] ( interpolation = \"" +
           interpolation + "\" )\n";
  };
  const std::string red = color("(1, 0, 0)"), green = color("(0, 1, 0)");
  EXPECT_EQ(albedo(red, ""), (Rgb{1, 0, 0}));
  EXPECT_EQ(albedo("color3f[] primvars:displayColor = [(1, 0, 0)]\n", ""), (Rgb{1, 0, 0}));
  EXPECT_EQ(albedo(red, green), (Rgb{0, 1, 0}));
  EXPECT_EQ(albedo(red, "", green), (Rgb{0, 1, 0}));
  EXPECT_EQ(albedo("", color("(0, 1, 0)", "vertex")), Rgb(0.5f));
  EXPECT_EQ(albedo("", "", color("(0, 1, 0)", "vertex")), (Rgb{0, 1, 0}));
}

TEST(UsdaSurfaces, TheMeanOfColoursIsThatOfTheirIndices) {
  const std::string table = "color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]\n";
  const auto scene = [&](const std::string& indices) {
    return scene_of("Sphere", table + "int[] primvars:displayColor:indices = [" + indices + "]\n");
  };
  EXPECT_EQ(look_of(scene("1, 1")).albedo, (Rgb{0, 1, 0}));
  EXPECT_EQ(look_of(scene("0, 0, 0, 2")).albedo, (Rgb{0.75f, 0, 0.25f}));
  EXPECT_FALSE(says(usda_notes(scene("0, 2")), "usd.index_of_no_colour"));
  const ImportedScene bad = scene("1, 3, -1");
  EXPECT_EQ(look_of(bad).albedo, (Rgb{0, 1, 0}));
  EXPECT_TRUE(says(usda_notes(bad), "usd.index_of_no_colour"));
}

TEST(UsdaSurfaces, BindingsThatAreStrongerThanThoseWithin) {
  const auto material = [](const std::string& name, const std::string& color) {
    return "def Material \"" + name + "\" { token outputs:surface.connect = </" + name +
           "/s.outputs:out>\ndef Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\"\n"
           "color3f inputs:diffuseColor = " +
           color + " } }\n";
  };
  const auto albedo = [&](const std::string& outer, const std::string& inner) {
    const ImportedScene s = read_usda_text(
        usda_text(material("red", "(1, 0, 0)") + material("green", "(0, 1, 0)") + "def \"a\" {" +
                  outer + "\ndef \"b\" {" + inner + "\ndef Sphere \"s\" { } } }"));
    return look_of(s).albedo;
  };
  const std::string red = "rel material:binding = </red>";
  const std::string green = "rel material:binding = </green>";
  const std::string strong = " ( bindMaterialAs = \"strongerThanDescendants\" )";
  EXPECT_EQ(albedo(red, green), (Rgb{0, 1, 0}));
  EXPECT_EQ(albedo(red + strong, green), (Rgb{1, 0, 0}));
  EXPECT_EQ(albedo(red + strong, green + strong), (Rgb{1, 0, 0}));
  EXPECT_EQ(albedo(red + " ( bindMaterialAs = \"weakerThanDescendants\" )", green + strong),
            (Rgb{0, 1, 0}));
  EXPECT_EQ(albedo("rel material:binding:full = </red>", green), (Rgb{1, 0, 0}));
}

TEST(UsdaSurfaces, BindingsOfCollectionsAreNamed) {
  const ImportedScene s = read_usda_text(usda_text(
      "def \"a\" { rel material:binding:collection:glass = [</a.collection:glass>, </m>]\n"
      "def Sphere \"s\" { } }"));
  EXPECT_TRUE(says(usda_notes(s), "usd.binding_of_collection"));
}

TEST(UsdaSurfaces, SubdivisionIsNamedAndBadFacesAreRefused) {
  const std::string points = "point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]\n";
  const std::string count = "int[] faceVertexCounts = ", index = "int[] faceVertexIndices = ";
  EXPECT_TRUE(says(usda_notes(scene_of("Mesh", points + count + "[3]\n" + index + "[0, 1, 2]\n")),
                   "usd.subdivision"));
  const auto fault = [&](const std::string& lines) {
    return error_of([&] { (void)scene_of("Mesh", points + lines); });
  };
  EXPECT_TRUE(says(fault(count + "[3]\n" + index + "[0, 1, 3]\n"), "usd.index_too_large"));
  EXPECT_TRUE(says(fault(count + "[4]\n" + index + "[0, 1, 2]\n"), "usd.corners_missing"));
}

TEST(UsdaSurfaces, FilesAreWrittenThatReadBackAsTheScene) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.usda"), usda_text(usda_prim("Mesh", kSquare)));
  const ImportedScene scene = read_usda(folder.file("a.usda"), "b");
  write_imported(folder.file("b.toml"), scene);
  const SceneFile back = read_scene(folder.file("b.toml"));
  EXPECT_EQ(back.volumes.at(0).file, folder.file("cloud.vdb"));
  EXPECT_TRUE(std::filesystem::exists(folder.file("b_mesh1.ply")));
}

}  // namespace usda_surfaces_test
}  // namespace pvol::formats
