// Where USD's cameras see points, by the frustum of GfCamera, and where pvol's camera does.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "render/scene/projection.h"
#include "support/messages.h"
#include "support/usda_text.h"

namespace pvol::formats {
namespace usda_camera_test {

using test::read_usda_text;
using test::usda_notes;
using test::usda_text;

/// In the camera's space: it looks along -z, y is up.
const std::vector<Vec3d> kSeen{
    {0, 0, -5}, {0.7, 0, -4}, {0, 0.6, -3}, {-0.4, 0.3, -6}, {1, -1, -8}};

const std::string kPlace = R"(
    double3 xformOp:translate = (1, 2, 3)
    float xformOp:rotateY = 90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateY"]
)";
/// A turn by 90 degrees about y takes +x to -z and +z to +x.
Vec3d in_world(Vec3d p) { return Vec3d{p.z, p.y, -p.x} + Vec3d{1, 2, 3}; }

std::string settings(int width, int height, const std::string& more = "") {
  return "def RenderSettings \"r\" { uniform int2 resolution = (" + std::to_string(width) + ", " +
         std::to_string(height) + ") " + more + " }\n";
}

ImportedScene camera_scene(const std::string& lines, const std::string& rest = "",
                           const std::string& metadata = "") {
  return read_usda_text(
      usda_text("def Camera \"cam\" {" + lines + kPlace + "}\n" + rest, metadata));
}

/// The window that the picture shows at a distance of 1, or in the world: left, right, bottom, top.
using Window = std::array<double, 4>;

void expect_seen(const ImportedScene& s, const Window& w, bool is_flat = false) {
  const Scene& scene = s.file.scene;
  const int width = scene.options.width, height = scene.options.height;
  const pvol::detail::Projection camera(scene.camera, width, height);
  for (const Vec3d p : kSeen) {
    const double depth = is_flat ? 1 : -p.z;
    const double x = (p.x / depth - w[0]) / (w[1] - w[0]) * width;
    const double y = (w[3] - p.y / depth) / (w[3] - w[2]) * height;
    const Ray ray = camera.ray(x, y);
    const Vec3d to = in_world(p) - ray.o;
    EXPECT_GT(dot(to, ray.d), 0);
    EXPECT_LT(length(cross(to, ray.d)), 2e-6 * length(to)) << p.x << ", " << p.y;
  }
}

TEST(UsdaCamera, SeesPlacesWhereUsdDoes) {
  // 30 x 20 over a focal length of 40, whatever the unit.
  const std::string lens =
      "float focalLength = 40 float horizontalAperture = 30 float verticalAperture = 20";
  for (const char* unit : {"metersPerUnit = 0.01", "metersPerUnit = 1", ""}) {
    expect_seen(camera_scene(lens, settings(300, 200), unit), {-0.375, 0.375, -0.25, 0.25});
  }
}

TEST(UsdaCamera, PicturesOfAnotherAspectByThePolicy) {
  const std::string lens =
      "float focalLength = 10 float horizontalAperture = 12 float verticalAperture = 8";
  const auto policy = [&](const std::string& name, int width, int height) {
    return camera_scene(
        lens, settings(width, height, "token aspectRatioConformPolicy = \"" + name + "\""));
  };
  expect_seen(camera_scene(lens, settings(400, 200)), {-0.8, 0.8, -0.4, 0.4});
  expect_seen(camera_scene(lens, settings(200, 200)), {-0.6, 0.6, -0.6, 0.6});
  expect_seen(policy("cropAperture", 400, 200), {-0.6, 0.6, -0.3, 0.3});
  expect_seen(policy("cropAperture", 200, 200), {-0.4, 0.4, -0.4, 0.4});
  expect_seen(policy("adjustApertureWidth", 200, 200), {-0.4, 0.4, -0.4, 0.4});
  expect_seen(policy("adjustApertureHeight", 400, 200), {-0.6, 0.6, -0.3, 0.3});
}

TEST(UsdaCamera, OffsetsMoveTheWindow) {
  expect_seen(camera_scene("float focalLength = 10 float horizontalAperture = 6 "
                           "float verticalAperture = 4 float horizontalApertureOffset = 1 "
                           "float verticalApertureOffset = -0.5",
                           settings(300, 200)),
              {-0.2, 0.4, -0.25, 0.15});
}

/// Apertures are in tenths of a unit.
TEST(UsdaCamera, Orthographic) {
  for (const auto& [width, height] : {std::pair{300, 200}, {200, 200}}) {
    const double high = 300 == width ? 2 : 3;
    expect_seen(camera_scene("token projection = \"orthographic\" float horizontalAperture = 60 "
                             "float verticalAperture = 40",
                             settings(width, height)),
                {-3, 3, -high, high}, true);
  }
}

TEST(UsdaCamera, WithoutSettingsThePictureHasTheAspectOfTheAperture) {
  const ImportedScene s = camera_scene("float horizontalAperture = 40 float verticalAperture = 10");
  EXPECT_EQ(s.file.scene.options.width, 640);
  EXPECT_EQ(s.file.scene.options.height, 160);
}

TEST(UsdaCamera, ALensHasTheRadiusThatItsUnitsSay) {
  const std::string lens =
      "float focalLength = 50 float fStop = 2 float focusDistance = 7 float horizontalAperture = "
      "30";
  // 50 tenths of a unit over f/2: 2.5 units across.
  for (const char* unit : {"metersPerUnit = 0.01", "metersPerUnit = 1"}) {
    const ImportedScene s = camera_scene(lens, "", unit);
    EXPECT_NEAR(lens_radius(s.file.scene.camera, 1.5), 1.25, 1e-12) << unit;
    EXPECT_EQ(s.file.scene.camera.focus_distance, 7);
  }
  EXPECT_NEAR(*camera_scene(lens).file.scene.camera.focal_length, 50, 1e-12);  // mm, of cm
  EXPECT_TRUE(says(usda_notes(camera_scene(lens, "", "metersPerUnit = 1")), "usd.long_lens"));
}

TEST(UsdaCamera, ShutterFramesAndMotion) {
  const ImportedScene s = read_usda_text(
      usda_text("def Camera \"c\" { double shutter:open = -0.25 double shutter:close = 0.25\n"
                "double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (4, 0, 2) }\n"
                "uniform token[] xformOpOrder = [\"xformOp:translate\"] }",
                "timeCodesPerSecond = 30"));
  const Camera& c = s.file.scene.camera;
  EXPECT_EQ(c.shutter, (Shutter{-0.25, 0.25}));
  EXPECT_EQ(c.fps, 30);
  ASSERT_TRUE(c.to.has_value());
  EXPECT_EQ(c.to->position, Vec3d(2, 0, 1));
  EXPECT_EQ(c.to->target, Vec3d(2, 0, 0));
}

TEST(UsdaCamera, SettingsAndTheirProductsChoose) {
  const std::string cameras = "def Camera \"b\" { float focalLength = 77 }\n";
  const std::string lens = "float focalLength = 50";
  const auto focal = [](const ImportedScene& s) { return *s.file.scene.camera.focal_length; };
  const ImportedScene first = camera_scene(lens, cameras);
  EXPECT_NEAR(focal(first), 50, 1e-12);
  EXPECT_TRUE(says(usda_notes(first), "usd.several_cameras"));
  EXPECT_NEAR(focal(camera_scene(lens, cameras + settings(9, 9, "rel camera = </b>"))), 77, 1e-12);
  const ImportedScene product =
      camera_scene(lens, cameras + settings(9, 9, "rel camera = </b> rel products = </p>") +
                             "def RenderProduct \"p\" { int2 resolution = (12, 8) }");
  EXPECT_EQ(product.file.scene.options.width, 12);
  EXPECT_NEAR(focal(product), 77, 1e-12);
}

TEST(UsdaCamera, SettingsNameTheColourSpace) {
  const auto imported = [](const std::string& space) {
    return camera_scene("",
                        settings(9, 9, "uniform token renderingColorSpace = \"" + space + "\""));
  };
  const auto space_of = [&](const std::string& space) {
    return imported(space).file.scene.options.color_space;
  };
  EXPECT_EQ(space_of("lin_ap1_scene"), ColorSpace::acescg);
  EXPECT_EQ(space_of("ACEScg"), ColorSpace::acescg);
  EXPECT_EQ(space_of("lin_rec709"), ColorSpace::rec709);
  EXPECT_EQ(space_of("lin_rec2020_scene"), ColorSpace::rec2020);
  EXPECT_EQ(space_of("lin_p3d65"), ColorSpace::p3);
  EXPECT_EQ(space_of("ACES2065-1"), ColorSpace::aces);
  EXPECT_EQ(space_of("srgb_p3d65_scene"), ColorSpace::rec709) << "not linear";
  EXPECT_TRUE(says(usda_notes(imported("srgb_p3d65_scene")), "usd.rendering_color_space"));
}

TEST(UsdaCamera, WithoutOnePvolFramesTheCloudInTheWorldsUp) {
  const ImportedScene s = read_usda_text(usda_text("", "upAxis = \"Z\""));
  EXPECT_FALSE(s.file.has_camera);
  EXPECT_EQ(s.file.scene.camera.up, Vec3d(0, 0, 1));
  EXPECT_EQ(std::get<GradientSky>(s.file.scene.environment).up, Vec3d(0, 0, 1));
  EXPECT_EQ(s.file.scene.lights.size(), 1u);
}

}  // namespace usda_camera_test
}  // namespace pvol::formats
