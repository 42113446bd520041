// How bright USD's lights are, in closed form, and where they shine.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_lights_test {

using test::read_usda_text;
using test::usda_notes;
using test::usda_prim;
using test::usda_text;

constexpr double kPi = std::numbers::pi;

const std::string kTwice = R"(float3 xformOp:scale = (2, 2, 2)
float3 xformOp:translate = (1, 2, 3)
float xformOp:rotateX = 90
)";
const std::string kMovedTwice = "\"xformOp:translate\", \"xformOp:rotateX\", \"xformOp:scale\"";

template <class Kind>
Kind light_of(const std::string& type, const std::string& lines, const std::string& order = "") {
  const ImportedScene s = read_usda_text(usda_text(usda_prim(type, kTwice + lines, order)));
  return std::get<Kind>(s.file.scene.lights.at(0));
}

void expect_near(Vec3d a, Vec3d b, double error = 1e-6) {
  EXPECT_LT(length(a - b), error * std::max(1.0, length(b)))
      << a.x << ", " << a.y << ", " << a.z << " and " << b.x << ", " << b.y << ", " << b.z;
}

TEST(UsdaLights, ASunsIrradianceIsItsRadianceOverItsDisc) {
  const double disc = kPi * std::pow(std::sin(0.5 * kPi / 180), 2);
  const Sun s = light_of<Sun>("DistantLight",
                              "float inputs:angle = 1 float inputs:intensity = 3 "
                              "float inputs:exposure = 2 color3f inputs:color = (1, 0.5, 0.25)",
                              kMovedTwice);
  expect_near(Vec3d(s.irradiance), Vec3d{12, 6, 3} * disc);
  EXPECT_EQ(s.angle, 1);
  expect_near(s.direction, {0, -1, 0});  // it shines along -z, which the turn takes to +y
}

TEST(UsdaLights, ANormalisedSunsIrradianceIsItsIntensity) {
  for (const char* angle : {"0", "0.53", "20"}) {
    const Sun s = light_of<Sun>("DistantLight", std::string("float inputs:angle = ") + angle +
                                                    " float inputs:intensity = 3 "
                                                    "bool inputs:normalize = true");
    expect_near(Vec3d(s.irradiance), Vec3d(3.0));
  }
  // By default 50000 nits over 0.53 degrees.
  const Sun usual = light_of<Sun>("DistantLight", "");
  expect_near(Vec3d(usual.irradiance),
              Vec3d(50000 * kPi * std::pow(std::sin(0.265 * kPi / 180), 2)));
}

TEST(UsdaLights, ABallOfRadianceLHasTheIntensityPiR2L) {
  const PointLight p = light_of<PointLight>(
      "SphereLight", "float inputs:radius = 0.5 float inputs:intensity = 7", kMovedTwice);
  EXPECT_NEAR(p.radius, 1, 1e-12);  // twice as large
  expect_near(p.position, {1, 2, 3});
  expect_near(Vec3d(p.intensity), Vec3d(7 * kPi));
}

TEST(UsdaLights, NormalisedBallsKeepTheirPower) {
  for (const char* radius : {"0.1", "1", "3"}) {
    const PointLight p = light_of<PointLight>(
        "SphereLight", std::string("bool inputs:normalize = 1 float inputs:intensity = 8 ") +
                           "float inputs:radius = " + radius);
    expect_near(Vec3d(p.intensity), Vec3d(2.0));  // pi r^2 / (4 pi r^2)
  }
}

TEST(UsdaLights, PointsAreBallsWithoutARadius) {
  const PointLight p =
      light_of<PointLight>("SphereLight", "bool treatAsPoint = true float inputs:radius = 2");
  EXPECT_EQ(p.radius, 0);
  expect_near(Vec3d(p.intensity), Vec3d(4 * kPi));
  const ImportedScene dark =
      read_usda_text(usda_text(usda_prim("SphereLight", "float inputs:radius = 0")));
  EXPECT_EQ(dark.file.scene.lights.size(), 0u);
  EXPECT_TRUE(says(usda_notes(dark), "usd.dark_point"));
}

TEST(UsdaLights, RectanglesShineAlongMinusZ) {
  const std::string size = "float inputs:width = 3 float inputs:height = 0.5 ";
  const AreaLight a =
      light_of<AreaLight>("RectLight", size + "float inputs:intensity = 6", kMovedTwice);
  EXPECT_NEAR(a.size[0], 6, 1e-12);
  EXPECT_NEAR(a.size[1], 1, 1e-12);
  expect_near(a.direction, {0, 1, 0});
  expect_near(a.up, {0, 0, 1});
  expect_near(a.position, {1, 2, 3});
  expect_near(Vec3d(a.radiance), Vec3d(6.0));
  const AreaLight of_power = light_of<AreaLight>(
      "RectLight", size + "float inputs:intensity = 6 bool inputs:normalize = true", kMovedTwice);
  expect_near(Vec3d(of_power.radiance), Vec3d(1.0));
}

TEST(UsdaLights, DisksBecomeSquaresOfTheSameArea) {
  const AreaLight a = light_of<AreaLight>("DiskLight", "float inputs:radius = 2");
  EXPECT_NEAR(a.size[0] * a.size[1], 4 * kPi, 1e-12);
  const ImportedScene s = read_usda_text(usda_text(usda_prim("DiskLight", "")));
  EXPECT_TRUE(says(usda_notes(s), "usd.disk"));
}

TEST(UsdaLights, ConesBecomeSpots) {
  const std::string cone =
      "float inputs:shaping:cone:angle = 30 float inputs:shaping:cone:softness = 0.25 ";
  const SpotLight s = light_of<SpotLight>("SphereLight", cone + "float inputs:radius = 1");
  EXPECT_EQ(s.angle, 60);
  EXPECT_EQ(s.blend, 0.25);
  expect_near(s.direction, {0, 0, -1});
  expect_near(Vec3d(s.intensity), Vec3d(kPi));
  const SpotLight flat = light_of<SpotLight>("RectLight", cone + "float inputs:width = 5");
  expect_near(Vec3d(flat.intensity), Vec3d(5.0));
  // As far as it can shine, it is none.
  (void)light_of<PointLight>("SphereLight", "float inputs:shaping:cone:angle = 180");
  (void)light_of<AreaLight>("RectLight", "float inputs:shaping:cone:angle = 90");
}

TEST(UsdaLights, TemperaturesAreOfLuminanceOneAndWhiteAt6500) {
  const auto color = [](const std::string& kelvin) {
    return light_of<AreaLight>("RectLight",
                               "bool inputs:enableColorTemperature = true "
                               "float inputs:colorTemperature = " +
                                   kelvin)
        .radiance;
  };
  expect_near(Vec3d(color("6500")), Vec3d(1.0));
  EXPECT_NEAR(luminance(color("3000")), 1, 1e-5);
  EXPECT_GT(color("3000").x, 2 * color("3000").z);
  const AreaLight off = light_of<AreaLight>("RectLight", "float inputs:colorTemperature = 3000");
  expect_near(Vec3d(off.radiance), Vec3d(1.0));
}

TEST(UsdaLights, OldNamesWithoutInputs) {
  const AreaLight a = light_of<AreaLight>("RectLight", "float intensity = 4 float width = 3");
  expect_near(Vec3d(a.radiance), Vec3d(4.0));
  EXPECT_EQ(a.size[0], 3);
}

TEST(UsdaLights, OthersAreNamed) {
  const ImportedScene s = read_usda_text(usda_text(usda_prim("CylinderLight", "")));
  EXPECT_TRUE(says(usda_notes(s), "usd.cylinder_light"));
  EXPECT_EQ(std::get<ConstantSky>(s.file.scene.environment).radiance, Rgb(0.0f));
}

TEST(UsdaLights, FactorsAreNamedWhereTheyChangeSomething) {
  const auto notes = [](const std::string& lines) {
    return usda_notes(read_usda_text(usda_text(usda_prim("RectLight", lines))));
  };
  EXPECT_EQ(
      notes("float inputs:diffuse = 1 float inputs:specular = 1 float inputs:shaping:focus = 0 "
            "color3f inputs:shaping:focusTint = (0, 0, 0)"),
      "");
  EXPECT_TRUE(says(notes("float inputs:diffuse = 0.5"), "usd.diffuse_factor"));
  EXPECT_TRUE(says(notes("int karma:light:samples = 4 int karma:light:b = 3"), "usd.karma"));
}

TEST(UsdaLights, EvenDomesAddUp) {
  const ImportedScene s = read_usda_text(
      usda_text("def DomeLight \"a\" { color3f inputs:color = (1, 2, 3) }\n"
                "def DomeLight \"b\" { float inputs:intensity = 0.5 bool inputs:normalize = 1 }"));
  expect_near(Vec3d(std::get<ConstantSky>(s.file.scene.environment).radiance), {1.5, 2.5, 3.5});
}

/// Where pvol's picture of a sky has the middle of a pixel.
Vec3d direction_of(const ImageSky& sky, double across, double down) {
  const double azimuth = 2 * kPi * across + sky.rotation * kPi / 180;
  const double sine = std::sin(kPi * down);
  const Vec3d own{sine * std::cos(azimuth), std::cos(kPi * down), sine * std::sin(azimuth)};
  const Vec3d y{0, 1, 0}, up = normalize(sky.up);  // the shortest way from +y to up
  const Vec3d axis = cross(y, up);
  if (length(axis) < 1e-12) return own;
  const Vec3d a = normalize(axis);
  const double c = dot(y, up), s = length(axis);
  return own * c + cross(a, own) * s + a * (dot(a, own) * (1 - c));
}

/// OpenEXR: longitude 0 is in the middle, towards +z, and pi/2 towards +x, left of it.
TEST(UsdaLights, PicturesOfDomesStandAsOpenexrHasThem) {
  const TemporaryFolder folder;
  write_bytes(folder.file("sky.exr"), "");
  const auto sky_of = [&](const std::string& type, const std::string& lines,
                          const std::string& metadata = "") {
    write_bytes(
        folder.file("a.usda"),
        usda_text("def " + type + " \"d\" { asset inputs:texture:file = @sky.exr@\n" + lines + "}",
                  metadata));
    return std::get<ImageSky>(read_usda(folder.file("a.usda"), "o").file.scene.environment);
  };
  const ImageSky plain = sky_of("DomeLight", "float inputs:intensity = 3");
  EXPECT_EQ(plain.file, folder.file("sky.exr"));
  expect_near(Vec3d(plain.scale), Vec3d(3.0));
  expect_near(direction_of(plain, 0.5, 0.5), {0, 0, 1});
  expect_near(direction_of(plain, 0.25, 0.5), {1, 0, 0});
  expect_near(direction_of(plain, 0.3, 0), {0, 1, 0});
  // Turned by 90 degrees about x: +y to +z, +z to -y.
  const std::string turned =
      "float xformOp:rotateX = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateX\"]";
  const ImageSky up = sky_of("DomeLight", turned);
  expect_near(direction_of(up, 0.3, 0), {0, 0, 1});
  expect_near(direction_of(up, 0.5, 0.5), {0, -1, 0});
  expect_near(direction_of(up, 0.25, 0.5), {1, 0, 0});
  const ImageSky poled = sky_of("DomeLight_1", "", "upAxis = \"Z\"");
  expect_near(direction_of(poled, 0.3, 0), {0, 0, 1});
  expect_near(direction_of(poled, 0.5, 0.5), {0, -1, 0});
  const ImageSky about_y =
      sky_of("DomeLight",
             "float xformOp:rotateY = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateY\"]");
  expect_near(direction_of(about_y, 0.5, 0.5), {1, 0, 0});  // +z goes to +x
}

TEST(UsdaLights, PicturesThatPvolDoesNotReadAreNamed) {
  const ImportedScene s =
      read_usda_text(usda_text("def DomeLight \"d\" { asset inputs:texture:file = @sky.png@ }\n"
                               "def DomeLight \"e\" { asset inputs:texture:file = @sky.exr@ }"));
  EXPECT_TRUE(says(usda_notes(s), "usd.sky_of_png"));
  EXPECT_TRUE(says(usda_notes(s), "usd.sky_missing"));
}

}  // namespace usda_lights_test
}  // namespace pvol::formats
