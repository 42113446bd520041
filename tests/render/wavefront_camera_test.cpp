// Rays of the camera that the engine makes side by side are those of camera_ray().
#include <gtest/gtest.h>

#include "render/path/camera_rays.h"
#include "support/bodies.h"

namespace pvol::test {
namespace wavefront_camera_test {

/// A cloud too thin for any path to collide, at the left of the picture, and a sky that tells where
/// each ray goes.
CloudScene clear_view() {
  CloudScene s;
  s.medium.extinction = 1e-12;
  s.camera.position = {3, 0.2, 4}, s.camera.target = {2, 0, 0};
  s.environment = GradientSky{Rgb(0.1f), Rgb(0.7f), Rgb(0.4f), normalize(Vec3d(0.7, 0.5, 0.2))};
  s.options.width = 21, s.options.height = 13;
  s.options.samples = 11;  // rays of a batch end within a pixel
  s.options.look_up = LookUp::nearest;
  s.options.guide = GuideUse::off;
  return s;
}

/// What the pixels of a picture are, and what they are by their rays.
void expect_sky_along_rays(const CloudScene& s) {
  const std::vector<Volume> volumes = make_volumes(cube(), std::vector{s.medium}, s);
  const Film film = render(std::span(volumes), s).film;
  Scene scene = s.scene();
  scene.options.seed = proof::seeded(scene.options.seed);
  const detail::PathSetup setup(plan(volumes, scene));
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      Vec3d sum;
      for (std::uint32_t i = 0; i < s.options.samples; ++i) {
        const Ray ray = detail::camera_ray(setup, {film.x + x, film.y + y, film.first_sample + i});
        sum += Vec3d(setup.light.sky.radiance(Vec3f(ray.d)));
      }
      for (int c = 0; c < 3; ++c) {
        ASSERT_DOUBLE_EQ(film.at(x, y).sum[c], sum[c]) << "pixel " << x << ", " << y;
      }
    }
  }
}

/// Alone, in parts of pictures, and among surfaces, which a plane far behind the camera stands for.
void expect_rays_of(CloudScene s) {
  expect_sky_along_rays(s);
  s.options.crop_x = 4, s.options.crop_y = 2, s.options.crop_width = 11, s.options.crop_height = 7;
  s.options.first_sample = 3;
  expect_sky_along_rays(s);
  s.surfaces = {PlaneSurface{{0, 0, 1e6}, {0, 0, -1}}};
  expect_sky_along_rays(s);
}

TEST(WavefrontCamera, PinholesSeeAlongTheirRays) {
  CloudScene s = clear_view();
  expect_rays_of(s);
  s.options.filter = PixelFilter::box;
  s.camera.focal_length = 28, s.camera.shift = {0.2, -0.1};
  expect_rays_of(s);
}

TEST(WavefrontCamera, OthersSeeAlongTheirRays) {
  const CloudScene s = clear_view();
  CloudScene lens = s, orthographic = s, around = s, moving = s;
  lens.camera.f_stop = 0.02;
  expect_rays_of(lens);
  orthographic.camera.kind = CameraKind::orthographic, orthographic.camera.ortho_scale = 5;
  expect_rays_of(orthographic);
  around.camera.kind = CameraKind::latlong;
  expect_sky_along_rays(around);
  moving.camera.shutter = {0, 1};
  moving.camera.to = CameraPlace{{3.5, 0.2, 4}, {2.5, 0.1, 0}};
  expect_rays_of(moving);
}

}  // namespace wavefront_camera_test
}  // namespace pvol::test
