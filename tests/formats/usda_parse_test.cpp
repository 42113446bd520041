// How usda text is read, and how damaged text is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_parse_test {

using test::error_of;
using test::read_usda_text;
using test::usda_notes;
using test::usda_text;

std::string fault_of(const std::string& text) {
  return error_of([&] { (void)read_usda_text(text); });
}

void expect_fault(const std::string& prims, const std::string& key) {
  EXPECT_TRUE(says(fault_of("#usda 1.0\n" + prims), key));
}

const BallSurface& ball_of(const ImportedScene& s) {
  return std::get<BallSurface>(s.file.scene.surfaces.at(0));
}

double radius_of(const std::string& lines) {
  return ball_of(read_usda_text(usda_text("def Sphere \"s\" {" + lines + "}"))).radius;
}

TEST(UsdaParse, BlanksCommentsSeparatorsAndKindsOfNumbers) {
  EXPECT_EQ(radius_of("double radius=2"), 2);
  EXPECT_EQ(radius_of("# radius = 3\ncustom uniform double radius = +.5e1; float x = 1"), 5);
  EXPECT_EQ(radius_of("int a = -1 // one\n/* radius = 3\n */ double radius = 1. (doc = \")\")"), 1);
  EXPECT_EQ(radius_of("string s = \"\"\"a \"b\"\n}\"\"\"\nstring t = 'a\\'}'\ndouble radius = 7"),
            7);
  EXPECT_EQ(radius_of("double radius.timeSamples = { 3: 4, 1: 2, }"), 2);
  EXPECT_EQ(radius_of("double radius = 2\ndouble radius.connect = </a.b>"), 2);
  EXPECT_EQ(radius_of("add rel a = [</b>, <../c>,]\nreorder properties = [\"a\"]\nrel b\n"
                      "dictionary d = { double e = 1; dictionary f = { string[] g = [\"h\"] } }"),
            1);
}

/// As in the files that USD tests its own parser with.
TEST(UsdaParse, ListsOfTargetsOrdersAndShiftedReferences) {
  EXPECT_EQ(
      radius_of("delete varying rel a:b:d = </a/b>\nreorder varying rel a:b:d = [</a>, </b>]\n"
                "varying rel a:b:d.default = </a>\nreorder double c.connect = </a.b>\n"
                "reorder nameChildren = [\"a\"]\ndouble empty.timeSamples = {\n}\n"
                "custom bool e = True\nint[] f = []\ndouble radius = 3.45e-7"),
      3.45e-7);
  const ImportedScene s = read_usda_text(
      "#sdf 1.4.32\n(\n  \"\"\"two\nlines\"\"\"\n  hasOwnedSubLayers = True\n)\nreorder rootPrims "
      "= [\"w\"]\n" +
      test::kUsdCloud +
      "def \"w\" ( references = [</b> (offset = 11; scale = 22), </c> (customData = { bool d = "
      "True })]\n  permission = private ) { }\n"
      "def Sphere \"b\" { double radius = 6 }\ndef \"c\" ( references = None ) { }\n");
  EXPECT_EQ(ball_of(s).radius, 6);
  EXPECT_EQ(s.file.scene.surfaces.size(), 2u);
  EXPECT_TRUE(says(usda_notes(s), "usd.retimed"));
}

TEST(UsdaParse, TextMayBeginWithAByteOrderMark) {
  const ImportedScene s = read_usda_text("\xEF\xBB\xBF" + usda_text("def Sphere \"s\" { }"));
  EXPECT_EQ(s.file.scene.surfaces.size(), 1u);
  EXPECT_TRUE(says(fault_of("\xEF\xBB\xBF"
                            "def Sphere \"s\" {}"),
                   "usd.no_header"));
}

/// Metadata of attributes are passed, whatever they are.
TEST(UsdaParse, MetadataOfAttributes) {
  EXPECT_EQ(radius_of("double radius = 3 (\"text\" interpolation = \"constant\"\n"
                      "customData = { double[] interpolation = [(1, 2)]; string b = \")\" }\n"
                      "symmetryFunction =\nallowedTokens = [\"a\"])"),
            3);
  expect_fault("def \"s\" { float x = 1 ( doc = ", "usd.metadata_without_end");
}

TEST(UsdaParse, NumbersBetweenSamplesAreMixed) {
  const std::string text =
      usda_text("def Sphere \"s\" { double radius.timeSamples = { 0: 1, 4: 3, 6: None } }");
  EXPECT_EQ(ball_of(read_usda_text(text)).radius, 1);
  EXPECT_EQ(ball_of(read_usda_text(text, 1)).radius, 1.5);
  EXPECT_EQ(ball_of(read_usda_text(text, 4)).radius, 3);
  EXPECT_EQ(ball_of(read_usda_text(text, -5)).radius, 1);
  EXPECT_EQ(ball_of(read_usda_text(text, 9)).radius, 1);  // blocked: USD's own
}

TEST(UsdaParse, TheFirstFrameIsThatOfTheLayerElseOfTheSamples) {
  const std::string sphere = "def Sphere \"s\" { double radius.timeSamples = { 2: 1, 4: 3 } }";
  EXPECT_EQ(ball_of(read_usda_text(usda_text(sphere))).radius, 1);
  EXPECT_EQ(ball_of(read_usda_text(usda_text(sphere, "startTimeCode = 3"))).radius, 2);
}

TEST(UsdaParse, OtherFilesAreRefusedWithAdvice) {
  EXPECT_TRUE(says(fault_of("PXR-USDC\1\2"), "usd.binary"));
  EXPECT_TRUE(says(fault_of(std::string("PK\3\4")), "usd.package"));
  EXPECT_TRUE(says(fault_of("def Sphere \"s\" {}"), "usd.no_header"));
  EXPECT_TRUE(says(fault_of("#usda 1.0\n"), "usd.no_volume"));
}

TEST(UsdaParse, ErrorsNameFileLineColumnFoundAndExpected) {
  expect_fault("def Sphere \"s\" { double radius = }", "usd.value_missing");
  expect_fault("def Sphere \"s\" { double radius = 1e999 }", "usd.number_overflow");
  expect_fault("def Sphere \"s\" {\n  double = 3 }", "usd.attribute_without_name");
  expect_fault("def Sphere \"s\" {", "usd.prim_without_end");
  expect_fault("def Sphere s {}", "usd.name_without_quotes");
  expect_fault("define \"s\" {}", "usd.unknown_specifier");
  expect_fault("def \"s\" {} def \"s\" {}", "usd.prim_twice");
  expect_fault("def \"s\" { string t = \"a\n\" }", "usd.string_without_end");
  expect_fault("def \"s\" { asset t = @a\n@ }", "usd.asset_without_end");
  expect_fault("def \"s\" { float2 t = (1, \"2\") }", "usd.several_kinds");
  expect_fault("def \"s\" { float2 t = (1 2) }", "usd.comma_missing");
  expect_fault("def \"s\" { float t.timeSamples = { \"1\": 2 } }", "usd.sample_without_time");
  expect_fault("def \"s\" { float t.samples = 2 }", "usd.unknown_part");
  expect_fault("def \"s\" { float t.connect }", "usd.part_without_value");
  expect_fault("def \"s\" ( kind \"x\" ) {}", "usd.metadatum_without_value");
  expect_fault("def \"s\" { float t.spline = { 1: [) } }", "usd.other_bracket");
  expect_fault("def Sphere \"s\" { double radius = (1, 2) }", "usd.two_numbers_for_one");
  expect_fault("def Sphere \"s\" { double radius = \"1\" }", "usd.string_for_number");
  expect_fault("def Sphere \"s\" { double radius = nan }", "usd.nan");
}

TEST(UsdaParse, NestingIsLimited) {
  std::string prims, brackets = "def \"s\" { float x = ", dictionaries = "def \"s\" ( a = ";
  for (int i = 0; i < 200; ++i) prims += "def \"a\" {", brackets += '(', dictionaries += "{ x y = ";
  expect_fault(prims, "usd.prims_too_deep");
  expect_fault(brackets, "usd.brackets_too_deep");
  expect_fault(dictionaries, "usd.dictionaries_too_deep");
}

TEST(UsdaParse, WhatIsLeftOutIsNamedWithItsLine) {
  const ImportedScene s = read_usda_text(
      usda_text("def Sphere \"s\"\n{\n    float weight = 3\n    float x.spline = { 1: 2 }\n}\n"
                "def Cylinder \"c\" { }\n"));
  EXPECT_TRUE(says(usda_notes(s), "usd.attribute_left_out"));
  EXPECT_TRUE(says(usda_notes(s), "usd.spline_left_out"));
  EXPECT_TRUE(says(usda_notes(s), "usd.cylinders_left_out"));
}

}  // namespace usda_parse_test
}  // namespace pvol::formats
