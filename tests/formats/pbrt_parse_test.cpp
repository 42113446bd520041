// How pbrt's scene files are read, and how damaged ones are refused.
#include <gtest/gtest.h>

#include <cmath>

#include "support/effort.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/pbrt_text.h"

namespace pvol::formats {
namespace pbrt_parse_test {

using test::error_of;
using test::pbrt_text;
using test::read_pbrt_text;

std::string fault_of(const std::string& text) {
  return error_of([&] { (void)read_pbrt_text(text); });
}

void expect_fault(const std::string& text, const std::string& key) {
  EXPECT_TRUE(says(fault_of(text), key));
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
  EXPECT_EQ(light_of("# one\rLightSource \"point\" # two\r\"point3 from\" [ 1 2 3 ]"),
            Vec3d(1, 2, -3));
}

TEST(PbrtParse, LinesEndInEveryWay) {
  expect_fault("\r#\r\r\n#\r\n\nTranslate 1 x", "pbrt.x_on_line_6");
}

TEST(PbrtParse, AByteOrderMarkIsSkipped) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_FALSE(read_pbrt_text(mark + pbrt_text("")).file.volumes.empty());
  EXPECT_FALSE(read_pbrt_text(mark + "# comment\n" + pbrt_text("")).file.volumes.empty());
  expect_fault("WorldBegin " + mark, "pbrt.byte_order_mark_later");
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
  EXPECT_TRUE(says(error_of([&] { (void)read_pbrt(folder.file("a.pbrt"), "b"); }),
                   "pbrt.pbrt_after_files"));
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
  expect_fault("Camera \"perspective\"\nFrame 1", "pbrt.frame_directive_pbrt");
  expect_fault("\n\nTranslate 1 2", "pbrt.numbers_missing");
  expect_fault("Translate 1 2 x", "pbrt.x_finite_number");
  expect_fault("Translate 1 2 1e999", "pbrt.number_overflow");
  expect_fault("Translate 1 2 nan", "pbrt.nan_finite_number");
  expect_fault("Scale 0 1 1", "pbrt.transform_without_inverse");
  expect_fault("LookAt 0 0 0 0 0 0 0 1 0", "pbrt.transform_without_inverse");
  expect_fault("Rotate 5 0 0 0", "pbrt.transform_without_inverse");
  expect_fault("Transform [ 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 ]", "pbrt.matrix_perspective");
  expect_fault("Transform [ 1 2 3 ]", "pbrt.matrix_too_short");
  expect_fault("Camera perspective", "pbrt.perspective_type_quotation");
  expect_fault("Camera \"perspective", "pbrt.string_without_end");
  expect_fault("Camera \"perspective\" \"float fov\" [ 30", "pbrt.list_without_end");
  expect_fault("Camera \"perspective\" \"float fov\" [ 3O ]", "pbrt.value_not_a_number");
  expect_fault("Camera \"perspective\" \"real fov\" 30", "pbrt.real_fov");
  expect_fault("Camera \"perspective\" \"fov\" 30", "pbrt.fov_parameter_such");
  expect_fault("Camera \"perspective\" \"float fov\" 1 \"float fov\" 2", "pbrt.fov_second_time");
  expect_fault("Camera \"perspective\" \"float fov\" 180", "pbrt.fov");
  expect_fault("Camera \"perspective\" \"float fov\" [ ]", "pbrt.float_fov_numbers");
  expect_fault("Film \"rgb\" \"integer xresolution\" 0", "pbrt.picture_side_pixels");
  expect_fault("Film \"rgb\" \"integer xresolution\" 3.5", "pbrt.xresolution_whole_number");
  expect_fault("AttributeEnd", "pbrt.attributeend_block_begun");
  expect_fault("AttributeBegin\nTransformEnd", "pbrt.transformend_attributeend");
  expect_fault("WorldBegin\nAttributeBegin\n", "pbrt.block_without_end");
  expect_fault("NamedMaterial \"x\"\nShape \"sphere\"", "pbrt.x_material_defined");
  expect_fault("MakeNamedMaterial \"x\" MakeNamedMaterial \"x\"", "pbrt.material_second_time");
  expect_fault("CoordSysTransform \"x\"", "pbrt.x_coordinate_system");
  expect_fault("MediumInterface \"fog\" \"\" Shape \"sphere\"", "pbrt.medium_fog");
  expect_fault("Include \"none.pbrt\"", "pbrt.open_none_pbrt");
  expect_fault("Include \"a.pbrt.gz\"", "pbrt.pbrt_gz_compressed");
}

TEST(PbrtParse, GridsAndMeshesOfTheWrongSizeAreRefused) {
  const auto fog = [](const std::string& from, const std::string& to) {
    std::string text = test::kPbrtFog;
    return pbrt_text("", "", text.replace(text.find(from), from.size(), to));
  };
  expect_fault(fog("\"integer nx\" 2", "\"integer nx\" 3"), "pbrt.samples_too_few");
  expect_fault(fog("\"integer nx\" 2", "\"integer nx\" 1073741824"), "pbrt.samples_overflow");
  expect_fault(fog("[ 1 2 ", "[ 1 -2 "), "pbrt.density_sample");
  expect_fault(fog("\"float density\" [", "\"point3 p1\" [ 0 1 1 ] \"float density\" ["),
               "pbrt.p0_p1_span");
  expect_fault(fog("\"float density\" [",
                   "\"float Lescale\" [ 1 2 ] \"rgb Le\" [ 1 1 1 ] \"float "
                   "density\" ["),
               "pbrt.scales_of_emission");
  expect_fault(pbrt_text("",
                         "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 ] \"integer indices\" [ 0 0 "
                         "1 ]"),
               "pbrt.index_vertices");
  expect_fault(pbrt_text("", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 ]"), "pbrt.point_of_two");
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
  std::size_t turn = 0;
  for (std::size_t n = 0; n < text.size(); ++n) {
    ++turn;
    for (const int flip : {1, 0x12, 0x80}) {
      if (!proof::has_turn(turn++, 3)) continue;
      std::string damaged = text;
      damaged[n] = char(damaged[n] ^ flip);
      check(damaged);
    }
  }
}

}  // namespace pbrt_parse_test
}  // namespace pvol::formats
