// How pbrt's scene files are read, and how damaged ones are refused.
#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.h"
#include "support/pbrt_text.h"

namespace pvol::formats {
namespace pbrt_parse_test {

using test::error_of;
using test::pbrt_text;
using test::read_pbrt_text;

std::string fault_of(const std::string& text) {
  return error_of([&] { (void)read_pbrt_text(text); });
}

void expect_fault(const std::string& text, const std::vector<std::string>& words) {
  const std::string message = fault_of(text);
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), message.npos) << "'" << message << "' lacks " << word;
  }
}

Vec3d light_of(const std::string& after) {
  const PbrtScene s = read_pbrt_text(pbrt_text("", after));
  return std::get<PointLight>(s.file.scene.lights.at(0)).position;
}

TEST(PbrtParse, BlanksCommentsBracketsAndKindsOfNumbers) {
  EXPECT_EQ(light_of("LightSource\"point\"\"point3 from\"[1 +2.5e0 -3]#end"), Vec3d(1, 2.5, 3));
  EXPECT_EQ(light_of("LightSource # here\r\n\"point\" \"point  from \" [ 1\t2 # two\n3 ]"),
            Vec3d(1, 2, -3));
  EXPECT_EQ(light_of("LightSource \"point\" \"float scale\" 2 \"point3 from\" [ .5 1. 1e-1 ]"),
            Vec3d(0.5, 1, -0.1));
}

TEST(PbrtParse, AttributesKeepTransformsToThemselves) {
  const std::string light = "LightSource \"point\"\n";
  EXPECT_EQ(light_of("Translate 1 0 0 AttributeBegin Translate 9 9 9 AttributeEnd " + light),
            Vec3d(1, 0, 0));
  EXPECT_EQ(light_of("TransformBegin Scale 2 2 2 Translate 1 0 0 " + light + "TransformEnd"),
            Vec3d(2, 0, 0));
  EXPECT_EQ(
      light_of("Translate 5 0 0 CoordinateSystem \"here\" Identity CoordSysTransform \"here\" " +
               light),
      Vec3d(5, 0, 0));
  EXPECT_EQ(light_of("ActiveTransform EndTime Translate 7 0 0 ActiveTransform All " + light),
            Vec3d(0, 0, 0));
  EXPECT_EQ(light_of("Attribute \"light\" \"point3 from\" [ 3 4 0 ] " + light), Vec3d(3, 4, 0));
}

TEST(PbrtParse, TurnsGoTheWayOfPbrts) {
  const auto turned = [](const std::string& turn, const std::string& from) {
    return light_of(turn + " LightSource \"point\" \"point3 from\" [ " + from + " ]");
  };
  const auto expect_at = [](Vec3d found, Vec3d expected) {
    EXPECT_LT(length(found - Vec3d{expected.x, expected.y, -expected.z}), 1e-12);
  };
  expect_at(turned("Rotate 90 0 0 1", "1 0 0"), {0, 1, 0});
  expect_at(turned("Rotate 90 1 0 0", "0 1 0"), {0, 0, 1});
  expect_at(turned("Rotate 90 0 2 0", "0 0 1"), {1, 0, 0});
  expect_at(turned("Rotate 120 1 1 1", "1 2 3"), {3, 1, 2});
  expect_at(turned("Rotate 30 0 0 1 Scale 2 1 1", "1 0 0"), {std::sqrt(3.0), 1, 0});
}

TEST(PbrtParse, CamerasNameTheirSystem) {
  const PbrtScene s =
      read_pbrt_text(pbrt_text("LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"",
                               "CoordSysTransform \"camera\" LightSource \"point\""));
  EXPECT_LT(length(std::get<PointLight>(s.file.scene.lights.at(0)).position - Vec3d(0, 0, 5)),
            1e-9);
}

TEST(PbrtParse, IncludesAreFoundFromTheFirstFileOrTheirOwn) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.file("parts/deep"));
  write_bytes(folder.file("a.pbrt"),
              pbrt_text("", "Include \"parts/one.pbrt\" LightSource \"point\""));
  write_bytes(folder.file("parts/one.pbrt"),
              "Translate 1 0 0 Import \"deep/two.pbrt\" Include "
              "\"parts/deep/two.pbrt\"");
  write_bytes(folder.file("parts/deep/two.pbrt"), "Translate 0 1 0 # without an end of line");
  const PbrtScene s = read_pbrt(folder.file("a.pbrt"), "out");
  EXPECT_EQ(std::get<PointLight>(s.file.scene.lights.at(0)).position, Vec3d(1, 2, 0));
}

TEST(PbrtParse, IncludesWithoutEndAreRefused) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.pbrt"), "Include \"a.pbrt\"");
  EXPECT_NE(error_of([&] { (void)read_pbrt(folder.file("a.pbrt"), "b"); }).find("do not include"),
            std::string::npos);
  // 40 levels of two each would be a million million files.
  for (int i = 0; i < 40; ++i) {
    const std::string next = "Include \"" + std::to_string(i + 1) + ".pbrt\"\n";
    write_bytes(folder.file(std::to_string(i) + ".pbrt"), next + next);
  }
  write_bytes(folder.file("40.pbrt"), "");
  EXPECT_NE(error_of([&] { (void)read_pbrt(folder.file("0.pbrt"), "b"); }).find("4096"),
            std::string::npos);
}

TEST(PbrtParse, ErrorsNameFileLineFoundAndExpected) {
  expect_fault("Camera \"perspective\"\nFrame 1", {"a.pbrt:2:", "'Frame'", "a directive"});
  expect_fault("\n\nTranslate 1 2", {"a.pbrt:3:", "the end of the file", "a number"});
  expect_fault("Translate 1 2 x", {":1:", "'x'", "finite number"});
  expect_fault("Translate 1 2 1e999", {"'1e999'"});
  expect_fault("Translate 1 2 nan", {"'nan'"});
  expect_fault("Scale 0 1 1", {":1:", "without an inverse"});
  expect_fault("LookAt 0 0 0 0 0 0 0 1 0", {":1:", "without an inverse"});
  expect_fault("Rotate 5 0 0 0", {":1:", "without an inverse"});
  expect_fault("Transform [ 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 ]", {"perspective", "0, 0, 0, 1"});
  expect_fault("Transform [ 1 2 3 ]", {"']'", "finite number"});
  expect_fault("Camera perspective", {"'perspective'", "quotation marks"});
  expect_fault("Camera \"perspective", {":1:", "without an end"});
  expect_fault("Camera \"perspective\" \"float fov\" [ 30", {"the end of the file", "]"});
  expect_fault("Camera \"perspective\" \"float fov\" [ 3O ]", {"'3O'", "float fov"});
  expect_fault("Camera \"perspective\" \"real fov\" 30", {"\"real fov\"", "integer, float"});
  expect_fault("Camera \"perspective\" \"fov\" 30", {"\"fov\"", "a parameter such as"});
  expect_fault("Camera \"perspective\" \"float fov\" 1 \"float fov\" 2", {"a second time"});
  expect_fault("Camera \"perspective\" \"float fov\" 180", {"fov 180"});
  expect_fault("Camera \"perspective\" \"float fov\" [ ]", {"with 0 numbers"});
  expect_fault("Film \"rgb\" \"integer xresolution\" 0", {"a side of 0 pixels"});
  expect_fault("Film \"rgb\" \"integer xresolution\" 3.5", {"xresolution 3.5", "whole"});
  expect_fault("AttributeEnd", {":1:", "AttributeEnd", "begun before"});
  expect_fault("AttributeBegin\nTransformEnd", {":2:", "TransformEnd", "AttributeEnd"});
  expect_fault("WorldBegin\nAttributeBegin\n", {":2:", "a block without an end"});
  expect_fault("NamedMaterial \"x\"", {"\"x\"", "a material that was defined before"});
  expect_fault("CoordSysTransform \"x\"", {"\"x\"", "a coordinate system that was defined before"});
  expect_fault("MediumInterface \"fog\" \"\" Shape \"sphere\"",
               {"medium \"fog\"", "MakeNamedMedium"});
  expect_fault("Include \"none.pbrt\"", {"a.pbrt:1:", "none.pbrt"});
  expect_fault("Include \"a.pbrt.gz\"", {"compressed", "gunzip"});
}

TEST(PbrtParse, GridsAndMeshesOfTheWrongSizeAreRefused) {
  const auto fog = [](const std::string& from, const std::string& to) {
    std::string text = test::kPbrtFog;
    return pbrt_text("", "", text.replace(text.find(from), from.size(), to));
  };
  expect_fault(fog("\"integer nx\" 2", "\"integer nx\" 3"), {"8 samples for 3 x 2 x 2"});
  expect_fault(fog("\"integer nx\" 2", "\"integer nx\" 1073741824"), {"8 samples for 1073741824"});
  expect_fault(fog("[ 1 2 ", "[ 1 -2 "), {"\"density\"", "-2"});
  expect_fault(fog("\"float density\" [", "\"point3 p1\" [ 0 1 1 ] \"float density\" ["),
               {"span no volume"});
  expect_fault(fog("\"float density\" [",
                   "\"float Lescale\" [ 1 2 ] \"rgb Le\" [ 1 1 1 ] \"float "
                   "density\" ["),
               {"2 numbers in Lescale"});
  expect_fault(pbrt_text("",
                         "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 ] \"integer indices\" [ 0 0 "
                         "1 ]"),
               {"index 1 of 1 vertices"});
  expect_fault(pbrt_text("", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 ]"), {"2 numbers in P"});
}

TEST(PbrtParse, DamagedScenesAreErrorsOrScenes) {
  const std::string text = read_bytes(PVOL_SAMPLES "/pbrt_scene.pbrt");
  ASSERT_GT(text.size(), 1000u);
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("a.pbrt");
  const auto check = [&](const std::string& damaged) {
    write_bytes(file, damaged);
    PbrtScene scene;
    const std::string message = error_of([&] { scene = read_pbrt(file, "b"); });
    if (message.empty()) {
      EXPECT_FALSE(scene.file.volumes.empty());
    } else {
      EXPECT_NE(message.find("a.pbrt"), message.npos) << message;
    }
  };
  for (std::size_t n = 0; n < text.size(); ++n) check(text.substr(0, n));
  for (std::size_t n = 0; n < text.size(); ++n) {
    for (const int flip : {1, 0x12, 0x80}) {
      std::string damaged = text;
      damaged[n] = char(damaged[n] ^ flip);
      check(damaged);
    }
  }
}

}  // namespace pbrt_parse_test
}  // namespace pvol::formats
