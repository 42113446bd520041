// Where pbrt's cameras see points, by pbrt's own transforms, and where pvol's camera does.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "render/scene/projection.h"
#include "support/pbrt_text.h"

namespace pvol::formats {
namespace pbrt_camera_test {

using test::pbrt_text;
using test::read_pbrt_text;

/// Places in pbrt's world, shown as point lights.
const std::vector<Vec3d> kPlaces{{0, 0, 0},   {0.7, 0, 0},      {0, 0.6, 0},
                                 {0, 0, 0.8}, {-0.4, 0.3, 0.5}, {0.2, -0.7, -0.6}};

std::string lights() {
  std::string text;
  for (const Vec3d p : kPlaces) {
    text += "LightSource \"point\" \"point3 from\" [ " + std::to_string(p.x) + " " +
            std::to_string(p.y) + " " + std::to_string(p.z) + " ]\n";
  }
  return text;
}

/// Axes and origin of a camera in pbrt's world.
struct Frame {
  Vec3d x, y, z, origin;
};

/// LookAt as the book has it: left-handed, +z ahead, +x right, +y up.
Frame look_from(Vec3d eye, Vec3d at, Vec3d up) {
  Frame f;
  f.origin = eye;
  f.z = normalize(at - eye);
  f.x = normalize(cross(normalize(up), f.z));
  f.y = cross(f.z, f.x);
  return f;
}

Vec3d in_camera(const Frame& f, Vec3d p) {
  const Vec3d d = p - f.origin;
  return {dot(f.x, d) / dot(f.x, f.x), dot(f.y, d) / dot(f.y, f.y), dot(f.z, d) / dot(f.z, f.z)};
}

struct Picture {
  int width = 300, height = 200;
  std::array<double, 4> window{};  // left, right, bottom, top of pbrt's screen
};
Picture picture(int width, int height) {
  const double aspect = double(width) / height;
  if (aspect > 1) return {width, height, {-aspect, aspect, -1, 1}};
  return {width, height, {-1, 1, -1 / aspect, 1 / aspect}};
}

std::array<double, 2> on_film(const Picture& p, double x, double y) {
  const auto& w = p.window;
  return {(x - w[0]) / (w[1] - w[0]) * p.width, (w[3] - y) / (w[3] - w[2]) * p.height};
}

std::string film(const Picture& p) {
  return "Film \"rgb\" \"integer xresolution\" " + std::to_string(p.width) +
         " \"integer yresolution\" " + std::to_string(p.height) + "\n";
}

/// The ray of pvol's camera through where pbrt sees each place must meet the place.
template <class Raster>
void expect_seen(const std::string& before, const Picture& p, const Raster& raster) {
  const PbrtScene scene = read_pbrt_text(pbrt_text(film(p) + before, lights()));
  const Scene& s = scene.file.scene;
  ASSERT_EQ(s.options.width, p.width);
  ASSERT_EQ(s.options.height, p.height);
  ASSERT_EQ(s.lights.size(), kPlaces.size());
  EXPECT_NO_THROW(validate(s.camera));
  const pvol::detail::Projection camera(s.camera, p.width, p.height);
  for (std::size_t i = 0; i < kPlaces.size(); ++i) {
    const auto [x, y] = raster(kPlaces[i]);
    const Ray ray = camera.ray(x, y);
    const Vec3d to = std::get<PointLight>(s.lights[i]).position - ray.o;
    EXPECT_GT(dot(to, ray.d), 0) << i;
    EXPECT_LT(length(cross(to, ray.d)), 2e-6 * length(to)) << i << ": " << before;
  }
}

auto perspective(const Frame& f, const Picture& p, double fov) {
  return [=](Vec3d place) {
    const Vec3d c = in_camera(f, place);
    const double t = std::tan(fov / 360 * std::numbers::pi);
    return on_film(p, c.x / c.z / t, c.y / c.z / t);
  };
}

const std::string kLookAt = "LookAt 1.5 1 -4  0.1 0.2 0  0.1 1 0.2\n";
const Frame kFrame = look_from({1.5, 1, -4}, {0.1, 0.2, 0}, {0.1, 1, 0.2});

TEST(PbrtCamera, PerspectiveSeesPlacesWherePbrtDoes) {
  for (const auto& [w, h] : {std::pair{300, 200}, {200, 300}, {128, 128}}) {
    const Picture p = picture(w, h);
    expect_seen(kLookAt + "Camera \"perspective\" \"float fov\" 50\n", p,
                perspective(kFrame, p, 50));
    expect_seen(kLookAt + "Camera \"perspective\"\n", p, perspective(kFrame, p, 90));
  }
}

TEST(PbrtCamera, MirroredByScaleAsManyScenesAre) {
  Frame f = kFrame;
  f.x = -f.x;
  const Picture p = picture(300, 200);
  expect_seen("Scale -1 1 1\n" + kLookAt + "Camera \"perspective\" \"float fov\" 40\n", p,
              perspective(f, p, 40));
}

TEST(PbrtCamera, ByMatricesAndTurns) {
  const Picture p = picture(240, 180);
  // Camera from world: columns one after the other. A turn by 90 degrees about y, then 4 ahead.
  expect_seen("Transform [ 0 0 1 0  0 1 0 0  -1 0 0 0  0.1 0 4 1 ]\nCamera \"perspective\"\n", p,
              perspective({{0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {-4, 0, 0.1}}, p, 90));
  // p_camera = T R p: pbrt's turn by 90 degrees about y takes +z to +x and +x to -z.
  expect_seen("Translate 0 0 5\nRotate 90 0 1 0\nCamera \"perspective\" \"float fov\" 60\n", p,
              perspective({{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {5, 0, 0}}, p, 60));
  expect_seen(
      "Identity\nTranslate 0 0 5\nConcatTransform [ 0 0 -1 0 0 1 0 0 1 0 0 0 0 0 0 1 ]\n"
      "Camera \"perspective\" \"float fov\" 60\n",
      p, perspective({{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {5, 0, 0}}, p, 60));
  // With z up, the mirror is another one.
  expect_seen("LookAt 0.4 -5 1  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 30\n", p,
              perspective(look_from({0.4, -5, 1}, {0, 0, 0}, {0, 0, 1}), p, 30));
}

TEST(PbrtCamera, ScreenWindowMovesThePicture) {
  Picture p{300, 200, {-0.4, 1.1, -0.7, 0.3}};
  expect_seen(kLookAt +
                  "Camera \"perspective\" \"float fov\" 70 \"float screenwindow\" [ -0.4 1.1 "
                  "-0.7 0.3 ]\n",
              p, perspective(kFrame, p, 70));
}

TEST(PbrtCamera, ScaledCameraSeesTheSame) {
  const Picture p = picture(300, 200);
  expect_seen("Scale 3 3 3\n" + kLookAt + "Camera \"perspective\" \"float fov\" 50\n", p,
              perspective(kFrame, p, 50));
}

TEST(PbrtCamera, Orthographic) {
  for (const auto& [w, h] : {std::pair{300, 200}, {200, 300}}) {
    const Picture p = picture(w, h);
    const auto raster = [&](Vec3d place) {
      const Vec3d c = in_camera(kFrame, place);
      return on_film(p, c.x, c.y);
    };
    expect_seen(kLookAt + "Camera \"orthographic\"\n", p, raster);
    Picture moved{w, h, {-1, 2, -1, 2 - (w > h ? 1 : -1.5)}};
    const auto elsewhere = [&](Vec3d place) {
      const Vec3d c = in_camera(kFrame, place);
      return on_film(moved, c.x, c.y);
    };
    expect_seen(kLookAt + "Camera \"orthographic\" \"float screenwindow\" [ -1 2 -1 " +
                    std::to_string(moved.window[3]) + " ]\n",
                moved, elsewhere);
  }
}

TEST(PbrtCamera, SphericalByLongitudeAndLatitude) {
  const Picture p = picture(400, 200);
  const auto raster = [&](Vec3d place) {
    const Vec3d d = normalize(in_camera(kFrame, place));  // theta from +y, phi from +x to +z
    const double phi = std::atan2(d.z, d.x), turn = 2 * std::numbers::pi;
    return std::array<double, 2>{(phi < 0 ? phi + turn : phi) / turn * p.width,
                                 std::acos(d.y) / std::numbers::pi * p.height};
  };
  expect_seen(kLookAt + "Camera \"spherical\" \"string mapping\" \"equirectangular\"\n", p, raster);
}

TEST(PbrtCamera, ALensHasPbrtsRadiusAndSharpDistance) {
  const Picture p = picture(300, 200);
  const PbrtScene scene = read_pbrt_text(
      pbrt_text(film(p) + kLookAt +
                "Camera \"perspective\" \"float lensradius\" 0.25 \"float focaldistance\" 4.5\n"));
  const Camera& c = scene.file.scene.camera;
  EXPECT_NEAR(lens_radius(c, 1.5), 0.25, 1e-12);
  EXPECT_NEAR(c.focus_distance.value_or(0), 4.5, 1e-12);
}

}  // namespace pbrt_camera_test
}  // namespace pvol::formats
