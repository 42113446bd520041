// Surfaces that move while the shutter is open: against closed forms and what stands still.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "pvol/render/render.h"
#include "render/scene/surface/surfaces.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/lit_scenes.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/pictures.h"

namespace pvol::test {
namespace moving_surfaces_test {

using detail::SurfaceHit;
using detail::SurfaceSet;

constexpr double kPi = 3.14159265358979;
constexpr double kFar = 1e9;

/// A square in the plane z = 0, from -1 to 1.
std::shared_ptr<const TriangleMesh> plate() {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
std::shared_ptr<const pvol::Body> egg() {
  return std::make_shared<const pvol::Body>(FreeForm{unit_ball(), {}});
}

Vec3d any_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  const double z = 1 - 2 * double(u), r = std::sqrt(1 - z * z), azimuth = 2 * kPi * double(v);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// One of each kind that swings, turns, grows and goes on.
std::vector<Surface> swinging_surfaces() {
  const Placement from{
      .scale = Vec3d(2, 1.5, 1), .rotate = {{{1, 2, 0.5}, 20}}, .translate = Vec3d(1, -2, 3)};
  const Placement to{
      .scale = Vec3d(3, 1, 1.2), .rotate = {{{1, 2, 0.5}, 110}}, .translate = Vec3d(-4, 2, 5)};
  BallSurface ball{.centre = {2, 1, 0}, .radius = 1.5};
  ball.to = BallPlace{{-6, 3, 2}};
  SolidSurface solid{.body = egg(), .place = from};
  solid.to = to;
  MeshSurface mesh{.mesh = plate(), .place = from};
  mesh.to = to;
  return {ball, solid, mesh};
}

/// The same, as it is at a time, at rest.
Surface still_at(const Surface& surface, double time) {
  Surface still = surface;
  const Affine map = motion_of(surface)->at(time);
  if (auto* ball = std::get_if<BallSurface>(&still)) ball->centre = map.t, ball->to.reset();
  if (auto* solid = std::get_if<SolidSurface>(&still))
    solid->place = matrix(map), solid->to.reset();
  if (auto* mesh = std::get_if<MeshSurface>(&still)) mesh->place = matrix(map), mesh->to.reset();
  return still;
}

TEST(MovingSurfaces, AreMetWhereTheyAreAtEachTime) {
  Rng rng(1, 2, 3);
  for (const Surface& surface : swinging_surfaces()) {
    const SurfaceSet moving({&surface, 1}, {-0.5, 1});
    EXPECT_TRUE(moving.move());
    int hits = 0;
    for (const double time : {-0.5, 0.0, 0.25, 1.0}) {
      const Surface still = still_at(surface, time);
      const SurfaceSet there({&still, 1}, {});
      const Vec3d centre = motion_of(surface)->at(time).t;
      for (int i = 0; i < 400; ++i) {
        const Vec3d from = centre + any_direction(rng) * 20.0;
        const Vec3d aim = centre + any_direction(rng) * 1.5;
        const Ray ray{from, normalize(aim - from)};
        const SurfaceHit a = moving.first_hit(ray, kFar, float(time));
        const SurfaceHit b = there.first_hit(ray, kFar, 0);
        ASSERT_EQ(a.material != nullptr, b.material != nullptr) << kind_name(surface);
        EXPECT_EQ(moving.block(ray, kFar, float(time)), a.material != nullptr);
        if (!a.material) continue;
        ++hits;
        EXPECT_NEAR(a.distance, b.distance, 1e-5);
        EXPECT_LT(length(a.normal - b.normal), 1e-4) << kind_name(surface);
        EXPECT_LT(length(a.place - b.place), 1e-4);
        EXPECT_GT(a.clearance, 0);
        EXPECT_FALSE(moving.block({a.place, a.normal}, 0.01, float(time))) << "it does not hide";
      }
    }
    EXPECT_GT(hits, 200) << kind_name(surface);
  }
}

/// Nothing of it is in the way.
CloudScene before(Rgb sky, Shutter shutter) {
  CloudScene s = sunny();
  s.lights.clear();
  s.environment = ConstantSky{sky};
  s.medium.object_to_world = translation({1000, 1000, 1000});
  s.camera = {.position = {0, 0, 1e4}, .target = {0, 0, 0}, .fov = 1e-9, .shutter = shutter};
  s.options.width = s.options.height = 4;
  s.options.samples = proof::samples(16384);
  return s;
}

/// The time within the shutter at which a plate of half the width 1 is in the way of x = 0, where
/// it is at x at the files' time and moves by `speed` a frame.
double share_covered(Shutter shutter, double x, double speed) {
  const double enters = std::min((-1 - x) / speed, (1 - x) / speed);
  const double leaves = std::max((-1 - x) / speed, (1 - x) / speed);
  const double covered = std::min(leaves, shutter.close) - std::max(enters, shutter.open);
  return std::max(0.0, covered) / (shutter.close - shutter.open);
}

MeshSurface sliding_plate(double x, double speed, double z) {
  MeshSurface m{.mesh = plate(), .place = moved({x, 0, z}), .material = {.albedo = Rgb(0.25f)}};
  m.to = moved({x + speed, 0, z});
  return m;
}

TEST(MovingSurfaces, CoverThePictureAsLongAsTheyAreThere) {
  proof::Family family;
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 0.75}}) {
    for (const double x : {-1.5, 0.0, 0.7}) {
      CloudScene s = before(Rgb(1.0f), shutter);
      s.surfaces = {sliding_plate(x, 4, 0)};
      const double covered = share_covered(shutter, x, 4);
      const Average a = average(render(volume_of(s), s).film);
      compare(a, {Vec3d(covered * 0.25 + (1 - covered)), Vec3d(1e-14)}, "at " + std::to_string(x),
              family);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(MovingSurfaces, CastShadowsAsLongAsTheyAreThere) {
  proof::Family family;
  for (const double x : {-1.5, 0.0, 0.7}) {
    CloudScene s = before(Rgb(0.0f), {-0.5, 0.5});
    // The sun is above, the camera looks aslant at the ground where the shadow passes.
    s.lights = {Sun{{0, 0, 1}, Rgb(2.0f), 0}};
    s.camera.position = {0, 1e4, 1e4};
    s.surfaces = {PlaneSurface{.normal = {0, 0, 1}, .material = {.albedo = Rgb(0.5f)}},
                  sliding_plate(x, -4, 500)};
    const double lit = 1 - share_covered({-0.5, 0.5}, x, -4);
    const Average a = average(render(volume_of(s), s).film);
    compare(a, {Vec3d(lit * 2 * 0.5 / kPi), Vec3d(1e-14)}, "at " + std::to_string(x), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(MovingSurfaces, AmongCloudsAreTheMeanOfPicturesOverTheShutter) {
  proof::Family family;
  CloudScene s = sunny();
  const Volume v = volume_of(s);
  s.camera.shutter = {-0.5, 0.25};
  BallSurface ball{.centre = {40, 20, 40}, .radius = 8, .material = {.albedo = Rgb(0.7f)}};
  ball.to = BallPlace{{10, 40, 50}};
  MeshSurface mesh{.mesh = plate(),
                   .place = {.scale = Vec3d(12), .translate = Vec3d(20, 50, 20)},
                   .material = {.albedo = Rgb(0.3f)}};
  mesh.to =
      Placement{.scale = Vec3d(12), .rotate = {{{1, 0, 0}, 70}}, .translate = Vec3d(24, 44, 30)};
  s.surfaces = {PlaneSurface{.point = {0, -10, 0}, .material = {.albedo = Rgb(0.5f)}}, ball, mesh};
  s.options.samples = proof::samples(2048);
  const Film blurred = render(v, s).film;
  const Film sum = over_shutter(s.camera.shutter, 32, [&](double time, std::uint64_t seed) {
    CloudScene still = s;
    still.surfaces = {s.surfaces[0], still_at(ball, time), still_at(mesh, time)};
    still.options.samples = proof::samples(64u), still.options.seed = seed;
    return render(v, still).film;
  });
  compare(blurred, sum, "swinging", family);
  EXPECT_TRUE(family.passes());
}

TEST(MovingSurfaces, LeaveTheFurnaceWhite) {
  CloudScene s = sunny();
  s.medium.albedo = Rgb(1.0f);
  s.environment = ConstantSky{Rgb(1.0f)};
  s.lights.clear();
  s.options.samples = 8;
  const Volume v = volume_of(s);
  s.camera.shutter = {-0.5, 0.5};
  for (Surface surface : swinging_surfaces()) {
    std::visit([](auto& m) { m.material.albedo = Rgb(1.0f); }, surface);
    s.surfaces.push_back(std::move(surface));
  }
  for (const PixelSums& p : render(v, s).film.pixels) EXPECT_NEAR(mean(p).x, 1, 1e-6);
}

/// Of what turns about an axis the velocity is linear in the place, so its means are exact.
TEST(MovingSurfaces, TellTheirVelocity) {
  for (const Shutter shutter : {Shutter{0, 0}, Shutter{-0.5, 0.5}}) {
    CloudScene s = before(Rgb(1.0f), shutter);
    s.camera.fov = 0.02;
    s.options.samples = 16;
    s.options.aovs = {Aov::velocity, Aov::position};
    const Vec3d axis = normalize(Vec3d(0.1, 0.2, 1));
    MeshSurface m{.mesh = plate(), .place = {.scale = Vec3d(5)}};
    m.to = Placement{.scale = Vec3d(5), .rotate = {{axis, 24}}};
    s.surfaces = {m};
    const Film film = render(volume_of(s), s).film;
    int hits = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      if (film.pixels[i].alpha == 0) continue;
      const Vec3d at = value(film.layers[0], film, i), velocity = value(film.layers[1], film, i);
      EXPECT_LT(length(velocity - cross(axis * (24 * kPi / 180), at)), 1e-3) << i;
      ++hits;
    }
    EXPECT_EQ(hits, 16);
  }
}

TEST(MovingSurfaces, StandStillWithAClosedShutter) {
  CloudScene s = sunny();
  const Volume v = volume_of(s);
  BallSurface ball{.centre = {40, 20, 40}, .radius = 8};
  s.surfaces = {ball};
  const Film still = render(v, s).film;
  ball.to = BallPlace{{10, 40, 50}};
  s.surfaces = {ball};
  EXPECT_TRUE(same_bytes(render(v, s).film, still));
}

TEST(MovingSurfaces, WaysThatDoNotLeadThereAreRefused) {
  const auto refusal = [](const Placement& to, Shutter shutter) {
    MeshSurface m{.mesh = plate()};
    m.to = to;
    const Surface surface = m;
    return error_of([&] {
      validate(surface);
      (void)SurfaceSet({&surface, 1}, shutter);
    });
  };
  EXPECT_TRUE(says(refusal({.scale = Vec3d(1, -1, 1)}, {}), "moving_surfaces.mirrored"));
  EXPECT_TRUE(says(refusal({.scale = Vec3d(0.5)}, {0, 3}), "moving_surfaces.flat"));
  EXPECT_EQ(refusal({.scale = Vec3d(0.5)}, {0, 1}), "");
}

}  // namespace moving_surfaces_test
}  // namespace pvol::test
