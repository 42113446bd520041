// Scenes of USD from several layers.
#include <gtest/gtest.h>

#include <set>

#include "support/error_of.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_compose_test {

using test::error_of;
using test::kUsdCloud;
using test::usda_notes;

const std::string kHeader = "#usda 1.0\n";

class UsdaCompose : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(folder_.file(name).parent_path());
    write_bytes(folder_.file(name), text);
  }
  [[nodiscard]] ImportedScene read(const std::string& text) const {
    write("a.usda", text);
    return read_usda(folder_.file("a.usda"), "out");
  }
  [[nodiscard]] std::string fault_of(const std::string& text) const {
    return error_of([&] { (void)read(text); });
  }
  [[nodiscard]] double radius_of(const std::string& text) const {
    const ImportedScene s = read(text);
    return std::get<BallSurface>(s.file.scene.surfaces.at(0)).radius;
  }

  TemporaryFolder folder_;
};

std::string sphere(const std::string& name, double radius, const std::string& head = "def Sphere") {
  return head + " \"" + name + "\" { double radius = " + std::to_string(radius) + " }\n";
}

TEST_F(UsdaCompose, SublayersAreWeaker) {
  write("b.usda", kHeader + "( upAxis = \"Z\" )" + kUsdCloud + sphere("s", 2));
  const std::string subs = "( subLayers = [@./b.usda@] )";
  EXPECT_EQ(radius_of(kHeader + subs), 2);
  EXPECT_EQ(radius_of(kHeader + subs + sphere("s", 3, "over")), 3);
  EXPECT_EQ(read(kHeader + subs).file.scene.camera.up, Vec3d(0, 1, 0));  // the first layer's
}

TEST_F(UsdaCompose, ReferencesTakePrimsOfOtherFilesAndTheirTargets) {
  write("parts/cloud.usda",
        kHeader + "( defaultPrim = \"cloud\" )" + kUsdCloud + sphere("ball", 4));
  const ImportedScene s = read(kHeader +
                               "def \"w\" { def \"c\" ( references = @parts/cloud.usda@ )"
                               " { } def \"b\" ( payload = @parts/cloud.usda@</ball> ) {"
                               " } }");
  ASSERT_EQ(s.file.volumes.size(), 1u);
  EXPECT_EQ(s.file.volumes[0].file, folder_.file("parts/cloud.vdb"));  // beside that layer
  EXPECT_EQ(std::get<BallSurface>(s.file.scene.surfaces.at(0)).radius, 4);
}

TEST_F(UsdaCompose, VolumesThatDifferInPlaceAloneAreInstances) {
  const std::string moved =
      "{ double3 xformOp:translate = (1, 0, 0) uniform token[] xformOpOrder = "
      "[\"xformOp:translate\"] }";
  const ImportedScene s = read(kHeader + kUsdCloud + "def \"b\" ( references = </cloud> )" + moved);
  ASSERT_EQ(s.file.volumes.size(), 1u);
  ASSERT_EQ(s.file.volumes[0].instances.size(), 2u);
  EXPECT_EQ(s.file.volumes[0].instances[0], Affine{});
  EXPECT_EQ(s.file.volumes[0].instances[1], translation({1, 0, 0}));
  EXPECT_EQ(s.file.volumes[0].object_to_world, Affine{});
}

TEST_F(UsdaCompose, ClassesAndChosenVariants) {
  const std::string with_class =
      kHeader + kUsdCloud + "class Sphere \"_c\" { double radius = 5 }\n";
  EXPECT_EQ(radius_of(with_class + "def \"s\" ( inherits = </_c> ) { }"), 5);
  const std::string sets =
      " prepend variantSets = \"size\" ) { variantSet \"size\" = { \"big\" { double radius = 8 } "
      "\"small\" { double radius = 9 } } }";
  EXPECT_EQ(
      radius_of(with_class + "def Sphere \"s\" ( variants = { string size = \"small\" }" + sets),
      9);
  EXPECT_EQ(radius_of(with_class + "def Sphere \"s\" ( inherits = </_c>" + sets), 5);
}

TEST_F(UsdaCompose, VariantsAreChosenWhereTheyAreReferredTo) {
  write("b.usda", kHeader +
                      "def Sphere \"s\" ( variants = { string size = \"big\" } ) {"
                      " variantSet \"size\" = { \"big\" { double radius = 8 }"
                      " \"small\" { double radius = 9 } } }");
  EXPECT_EQ(radius_of(kHeader + kUsdCloud + "def \"s\" ( references = @b.usda@</s> ) { }"), 8);
  EXPECT_EQ(radius_of(kHeader + kUsdCloud +
                      "def \"s\" ( references = @b.usda@</s> variants = {"
                      " string size = \"small\" } ) { }"),
            9);
}

TEST_F(UsdaCompose, WhatIsNotThereOrBinaryIsNamed) {
  const std::string notes = usda_notes(read(
      kHeader + kUsdCloud + "def \"a\" ( references = [@none.usda@, @b.usdc@, </nobody>] ) { }"));
  EXPECT_TRUE(says(notes, "usd.no_such_layer"));
  EXPECT_TRUE(says(notes, "usd.binary_layer"));
  EXPECT_TRUE(says(notes, "usd.no_such_prim"));
}

TEST_F(UsdaCompose, CirclesAreRefused) {
  EXPECT_TRUE(says(fault_of(kHeader + "def \"a\" ( references = </a> ) { }"), "usd.circle"));
  EXPECT_TRUE(says(fault_of(kHeader + "def \"a\" { def \"b\" ( references = </a> ) { } }\n"
                                      "def \"c\" ( references = </a> ) { }"),
                   "usd.circle"));
  EXPECT_TRUE(says(fault_of(kHeader + "( subLayers = [@a.usda@] )"), "usd.layer_circle"));
}

/// Each prim has two of the next: more than any memory holds.
TEST_F(UsdaCompose, GrowthWithoutBoundsIsRefused) {
  std::string text = kHeader;
  for (int i = 0; i < 40; ++i) {
    const std::string next = "( references = </p" + std::to_string(i + 1) + "> ) { }\n";
    text += "def \"p" + std::to_string(i) + "\" { def \"x\" " + next + "def \"y\" " + next + "}\n";
  }
  EXPECT_TRUE(says(fault_of(text + "def \"p40\" { }\n"), "usd.too_large"));
}

TEST_F(UsdaCompose, FaultsOfLayersNameWhoRefersToThem) {
  write("b.usda", kHeader + "def {");
  EXPECT_TRUE(
      says(fault_of(kHeader + "def \"a\" ( references = @b.usda@ ) { }"), "usd.fault_of_layer"));
}

TEST_F(UsdaCompose, SwitchedOffInvisibleAndStandInsAreNotThere) {
  const ImportedScene s =
      read(kHeader + kUsdCloud + "def Sphere \"a\" ( active = false ) { }\n" +
           sphere("b", 1, "over") + sphere("c", 1, "class Sphere") +
           "def \"d\" { token visibility = \"invisible\"\n" + sphere("x", 1) +
           "}\ndef \"e\" { uniform token purpose = \"proxy\"\n" + sphere("x", 1) + "}\n");
  EXPECT_EQ(s.file.scene.surfaces.size(), 0u);
}

TEST_F(UsdaCompose, APrimsOwnPurposeWins) {
  const auto count = [&](const std::string& outer, const std::string& inner) {
    return read(kHeader + kUsdCloud + "def \"a\" { " + outer + " def Sphere \"s\" { " + inner +
                " } }")
        .file.scene.surfaces.size();
  };
  const auto purpose = [](const std::string& name) {
    return "uniform token purpose = \"" + name + "\"\n";
  };
  EXPECT_EQ(count(purpose("proxy"), purpose("render")), 1u);
  EXPECT_EQ(count(purpose("guide"), purpose("default")), 1u);
  EXPECT_EQ(count(purpose("render"), purpose("proxy")), 0u);
  EXPECT_EQ(count(purpose("proxy"), ""), 0u);
  EXPECT_EQ(count(purpose("proxy") + "token visibility = \"invisible\"\n", purpose("render")), 0u);
}

/// Radii of spheres within a prim whose references two layers list.
TEST_F(UsdaCompose, ListsOfReferencesAreMadeByAllLayers) {
  const auto radii = [&](const std::string& strong, const std::string& weak) {
    const std::string parts = "def \"x\" {" + sphere("x", 1) + "}\ndef \"y\" {" + sphere("y", 2) +
                              "}\ndef \"z\" {" + sphere("z", 3) + "}\n";
    write("parts.usda", kHeader + parts);
    write("b.usda", kHeader + "def \"it\" ( " + weak + " ) { }\n");
    const ImportedScene s = read(kHeader + "( subLayers = [@b.usda@] )" + kUsdCloud +
                                 "over \"it\" ( " + strong + " ) { }\n");
    std::set<double> all;
    for (const Surface& surface : s.file.scene.surfaces) {
      all.insert(std::get<BallSurface>(surface).radius);
    }
    return all;
  };
  using Radii = std::set<double>;
  const std::string x = "@parts.usda@</x>", y = "@parts.usda@</y>", z = "@parts.usda@</z>";
  const std::string both = "references = [" + x + ", " + y + "]";
  EXPECT_EQ(radii("", both), (Radii{1, 2}));
  EXPECT_EQ(radii("references = " + z, both), (Radii{3}));
  EXPECT_EQ(radii("references = None", both), (Radii{}));
  EXPECT_EQ(radii("payload = " + z, both), (Radii{1, 2, 3}));
  EXPECT_EQ(radii("prepend references = " + z, both), (Radii{1, 2, 3}));
  EXPECT_EQ(radii("append references = " + z, both), (Radii{1, 2, 3}));
  EXPECT_EQ(radii("delete references = " + x, both), (Radii{2}));
  EXPECT_EQ(radii("delete references = " + x + "\nprepend references = " + z, both), (Radii{2, 3}));
  EXPECT_EQ(radii("references = " + z, "delete references = " + z), (Radii{3}));
}

TEST_F(UsdaCompose, PrependedReferencesAreStrongerAndAppendedOnesWeaker) {
  write("parts.usda", kHeader + sphere("x", 1) + sphere("y", 2));
  const auto radius = [&](const std::string& strong, const std::string& weak) {
    write("b.usda", kHeader + "def \"it\" ( " + weak + " ) { }\n");
    return radius_of(kHeader + "( subLayers = [@b.usda@] )" + kUsdCloud + "over \"it\" ( " +
                     strong + " ) { }\n");
  };
  const std::string x = "references = @parts.usda@</x>", y = "references = @parts.usda@</y>";
  EXPECT_EQ(radius("prepend " + x, y), 1);
  EXPECT_EQ(radius("append " + x, y), 2);
  EXPECT_EQ(radius("append " + x, "append " + y), 2);
  EXPECT_EQ(radius("append " + x, "prepend " + x + "\nappend " + y), 2);  // the last, then
}

/// Within a file, a sublayer's prims are those of the whole stack.
TEST_F(UsdaCompose, ReferencesWithinALayerAreTakenOutByAnother) {
  write("b.usda", kHeader + sphere("x", 1, "class Sphere") + sphere("y", 2, "class Sphere") +
                      "def \"it\" ( references = [</x>, </y>] ) { }\n");
  EXPECT_EQ(radius_of(kHeader + "( subLayers = [@b.usda@] )" + kUsdCloud +
                      "over \"it\" ( delete references = </x> ) { }\n"),
            2);
}

/// An explicit list replaces those of its own layers, not those of what is referred to.
TEST_F(UsdaCompose, ListsOfOtherFilesHoldBesideExplicitOnes) {
  write("c.usda", kHeader + sphere("x", 1) + sphere("y", 2));
  write("b.usda", kHeader + "def \"p\" { def \"it\" ( references = @c.usda@</x> ) { } }\n");
  const std::string a = kHeader + kUsdCloud + "def \"p\" ( references = @b.usda@</p> ) { ";
  EXPECT_EQ(radius_of(a + "}"), 1);
  EXPECT_EQ(radius_of(a + "over \"it\" ( references = @c.usda@</y> ) { } }"), 2);
  EXPECT_EQ(radius_of(a + "over \"it\" ( references = None ) { } }"), 1);
}

TEST_F(UsdaCompose, ListsOfTargetsIdsAndSchemasAreMadeByAllLayers) {
  const auto count = [&](const std::string& metadata, const std::string& targets) {
    const auto cloud = [](const std::string& name) {
      return "def Volume \"" + name + "\" { rel field:density = </p/" + name +
             "/d>\ndef OpenVDBAsset \"d\" { asset filePath = @" + name + ".vdb@ } }\n";
    };
    write("b.usda", kHeader +
                        "def PointInstancer \"p\" ( inactiveIds = [0, 1] ) {\n"
                        "point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n"
                        "int[] protoIndices = [0, 0, 0]\nrel prototypes = [</p/a>, </p/b>]\n" +
                        cloud("a") + cloud("b") + "}\n");
    const SceneVolume v = read(kHeader + "( subLayers = [@b.usda@] )\nover \"p\" ( " + metadata +
                               " ) { " + targets + " }\n")
                              .file.volumes.at(0);
    return v.file.stem().string() + std::to_string(v.instances.size());
  };
  EXPECT_EQ(count("", ""), "a1");
  EXPECT_EQ(count("inactiveIds = [1]", ""), "a2");
  EXPECT_EQ(count("inactiveIds = []", ""), "a3");
  EXPECT_EQ(count("delete inactiveIds = [0]", ""), "a2");
  EXPECT_EQ(count("", "delete rel prototypes = </p/a>"), "b1");
  EXPECT_EQ(count("", "prepend rel prototypes = </p/b>"), "b1");
  EXPECT_EQ(count("", "append rel prototypes = </p/a>"), "b1");
  EXPECT_EQ(count("", "rel prototypes = </p/b>"), "b1");
  write("b.usda", kHeader + "def SphereLight \"l\" ( apiSchemas = [\"ShapingAPI\"] ) { }\n");
  const auto is_spot = [&](const std::string& metadata) {
    const ImportedScene s = read(kHeader + "( subLayers = [@b.usda@] )" + kUsdCloud +
                                 "over \"l\" ( " + metadata + " ) { }\n");
    return std::holds_alternative<SpotLight>(s.file.scene.lights.at(0));
  };
  EXPECT_TRUE(is_spot("prepend apiSchemas = [\"OtherAPI\"]"));
  EXPECT_FALSE(is_spot("delete apiSchemas = [\"ShapingAPI\"]"));
  EXPECT_FALSE(is_spot("apiSchemas = [\"OtherAPI\"]"));
}

}  // namespace usda_compose_test
}  // namespace pvol::formats
