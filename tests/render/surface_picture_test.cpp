// Pictures of surfaces against closed forms: lit planes, enclosures, ground under slabs, shadow
// catchers and holdouts.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "pvol/error.h"
#include "pvol/render/lights.h"
#include "support/bodies.h"
#include "support/meshes.h"
#include "support/messages.h"
#include "support/slab_oracle.h"
#include "support/statistics.h"
#include "support/surface_pixel.h"

namespace pvol::test {
namespace surface_picture_test {

constexpr double kPi = std::numbers::pi;

/// The cube on the ground, from aside.
CloudScene cloud_scene_of_cube() {
  CloudScene s;
  s.medium = component(0.2, Rgb(0.9f), 0.3);
  s.camera.position = {40, 20, 30};
  s.camera.target = {6, 5, 6};
  s.options.look_up = LookUp::nearest;
  s.options.samples = 16;
  s.options.threads = 2;
  return s;
}

RenderResult run_cube(const CloudScene& s) {
  const Field& f = cube();
  return render(make_volume(f.grid, build_pyramid(f.grid), s), s);
}

TEST(SurfacePicture, APlaneInTheLightOfEachKind) {
  proof::Family family;
  const Vec3d from{3, 5, 2};
  const auto picture = [&] {
    Pixel p(far_away(), from, {0, 0, 0});
    p.scene.surfaces = {ground(0.6)};
    return p;
  };
  Pixel sun = picture();
  sun.scene.lights = {Sun{{1, 2, 0}, Rgb(3.0f), 0}};
  expect_mean(sun.sums(), 0.6 / kPi * 3 * 2 / std::sqrt(5.0), "sun", family);
  Pixel disc = picture();
  disc.scene.lights = {Sun{{1, 2, 0}, Rgb(3.0f), 50}};
  expect_mean(disc.sums(), 0.6 / kPi * 3 * 2 / std::sqrt(5.0), "disc", family);
  Pixel setting = picture();
  setting.scene.options.samples = 40'000;
  setting.scene.lights = {Sun{{1, 0, 0}, Rgb(3.0f), 60}};
  // Half a disc of radius r on the horizon: L (r - sin r cos r) of L pi sin^2 r.
  const double r = kPi / 6, sine = std::sin(r);
  expect_mean(setting.sums(), 0.6 / kPi * 3 * (r - sine * std::cos(r)) / (kPi * sine * sine),
              "setting disc", family);
  Pixel point = picture();
  point.scene.lights = {PointLight{{1, 2, -2}, Rgb(7.0f)}};
  expect_mean(point.sums(), 0.6 / kPi * 7 / 9 * 2 / 3, "point", family);
  Pixel sky = picture();
  sky.scene.environment = ConstantSky{Rgb(0.8f)};
  expect_mean(sky.sums(), 0.6 * 0.8, "constant sky", family);
  Pixel gradient = picture();
  gradient.scene.environment = GradientSky{Rgb(0.9f), Rgb(0.3f), Rgb(5.0f), {0, 1, 0}};
  expect_mean(gradient.sums(), 0.6 * (0.3 + (0.9 - 0.3) * 2 / 3), "gradient sky", family);
  Pixel image = picture();
  // Below the horizon it shines, too; above, half of the azimuths do.
  image.scene.environment = ImageSky{2, 2, {Rgb(4.0f), Rgb(0.0f), Rgb(9.0f), Rgb(9.0f)}};
  expect_mean(image.sums(), 0.6 * 2, "picture of a sky", family);
  EXPECT_TRUE(family.passes());
}

/// In a closed room of albedo a the light of a lamp in its middle is E / (1 - a) everywhere.
TEST(SurfacePicture, AnIntegratingSphere) {
  proof::Family family;
  const Affine stretch = translation({7, 0, 0}) * scaling(Vec3d(3));
  SolidSurface solid;
  solid.body = std::make_shared<const pvol::Body>(FreeForm{unit_ball(), {}});
  solid.place.matrix = stretch;
  MeshSurface mesh;
  mesh.mesh = std::make_shared<const TriangleMesh>(ball_mesh(64));
  mesh.place.matrix = stretch;
  const Surface rooms[] = {BallSurface{{7, 0, 0}, 3, {}}, solid, mesh};
  for (const double albedo : {0.3, 0.8}) {
    for (const Surface& room : rooms) {
      Pixel p(far_away(), {8, 1, 0.5}, {7, -3, 0.1});
      p.scene.surfaces = {room};
      std::visit([&](auto& s) { s.material.albedo = Rgb(float(albedo)); }, p.scene.surfaces[0]);
      p.scene.lights = {PointLight{{7, 0, 0}, Rgb(2.0f)}};
      p.scene.environment = ConstantSky{Rgb(1e6f)};
      const double expected = albedo / kPi * 2 / 9 / (1 - albedo);
      const PixelSums sums = p.sums();
      if (std::holds_alternative<MeshSurface>(room)) {  // of flat pieces
        EXPECT_NEAR(mean(sums).x, expected, 0.01 * expected) << albedo;
      } else {
        expect_mean(sums, expected, std::string(kind_name(room)), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// What only scatters, in light that is the same from everywhere, is invisible: every sample is the
/// sky's to the last bits.
TEST(SurfacePicture, TheFurnaceHidesWhiteSurfaces) {
  CloudScene s = cloud_scene_of_cube();
  s.environment = ConstantSky{Rgb(1.0f)};
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.options.width = s.options.height = 16;
  s.options.samples = 16;
  MeshSurface mesh;
  mesh.mesh = std::make_shared<const TriangleMesh>(ball_mesh(12));
  mesh.place.matrix = translation({6, 14, 6}) * scaling({5, 3, 4});
  mesh.material.albedo = Rgb(1.0f);
  s.surfaces = {ground(1), BallSurface{{6, 6, 6}, 4, {Rgb(1.0f)}}, mesh};
  s.options.count = true;
  const RenderResult r = run_cube(s);
  for (const PixelSums& p : r.film.pixels) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean(p)[c], 1, 2e-6);
  }
  EXPECT_GT(r.counts.surface_hits, 2000u);
  EXPECT_GT(r.counts.collisions, 2000u);
}

/// So are they on average where that light is sampled, and on catchers, whatever a path met before.
TEST(SurfacePicture, TheFurnaceOfASampledSkyHidesThemOnAverage) {
  proof::Family family;
  for (const Visibility visibility : {Visibility::surface, Visibility::shadow_catcher}) {
    for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
      CloudScene s = cloud_scene_of_cube();
      s.environment = ImageSky{4, 2, std::vector<Rgb>(8, Rgb(1.0f))};
      s.lights.clear();
      s.medium = component(0.2, Rgb(1.0f), 0.7);
      s.options.width = s.options.height = 16;
      s.options.samples = 128;
      s.options.guide = guide;
      s.surfaces = {ground(1, visibility), BallSurface{{6, 14, 6}, 4, {Rgb(1.0f)}}};
      const RenderResult r = run_cube(s);
      const std::string of =
          name(visibility) + (guide == GuideUse::on ? std::string(", guided") : "");
      const Average white{Vec3d(1.0), Vec3d(0.0)};
      compare(average(r.film), white, of, family, 1e-5);
      compare(average(r.film, 6, 4, 4, 4), white, of + ", cube", family, 1e-5);
      compare(average(r.film, 4, 12, 8, 4), white, of + ", ground", family, 1e-5);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Ground of albedo a under a wide slab in the sun: light goes to and fro between them, E T / (1 -
/// a R) with the slab's transmission T of the beam and reflection R of diffuse light.
TEST(SurfacePicture, GroundUnderASlab) {
  proof::Family family;
  for (const double albedo : {0.0, 0.7}) {
    for (const double g : {0.0, 0.6}) {
      const SlabOptics optics{1.5, 0.95, g};
      const double cosine = 0.8;
      const Slab slab(optics, {cosine});
      const Fluxes beam = slab.collimated(0), back = slab.diffuse();
      // The cube is 13 wide: as thin as 1.5 in y, and a million wide across.
      const Affine wide = translation({0, 2, 0}) * scaling({1e6 / 13, 1.0 / 13, 1e6 / 13}) *
                          translation({-6, 0.5, -6});
      Pixel p(component(1.5, Rgb(0.95f), g, Rgb(0.0f), wide), {0.3, 1.5, 0.2}, {0, 0, 0});
      p.scene.surfaces = {ground(albedo > 0 ? albedo : 0.4)};
      if (albedo == 0) p.scene.options.max_bounces = 1;  // the unscattered beam alone
      p.scene.lights = {Sun{{std::sqrt(1 - cosine * cosine), cosine, 0}, Rgb(2.0f), 0}};
      p.scene.options.samples = 60'000;
      const double expected = albedo > 0
                                  ? albedo / kPi * 2 * cosine * (beam.direct + beam.transmitted) /
                                        (1 - albedo * back.reflected)
                                  : 0.4 / kPi * 2 * cosine * beam.direct;
      expect_mean(p.sums(), expected, "g " + std::to_string(g), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// However dark the ground and however low the sun: in the open no sample differs from another, and
/// in the shadow of a cloud they differ as much as estimates of its transmittance.
TEST(SurfacePicture, SunlitGroundThatTheCameraSeesIsSmooth) {
  for (const double albedo : {0.01, 0.05, 0.3}) {
    for (const double elevation : {2.0, 20.0, 90.0}) {
      for (const bool shaded : {false, true}) {
        const double angle = elevation * kPi / 180;
        const Vec3d to_sun{std::cos(angle), std::sin(angle), 0};
        const Affine above = translation(30 * to_sun) * translation(Vec3d(-6));
        Pixel p(component(shaded ? 0.1 : 1, Rgb(0.0f), 0, Rgb(0.0f),
                          shaded ? above : translation({0, 0, 1e5})),
                {0.1, 1.5, -1}, {0, 0, 0});
        p.scene.surfaces = {ground(albedo)};
        p.scene.lights = {Sun{to_sun, Rgb(3.0f), 0}};
        p.scene.options.max_bounces = 1;
        p.scene.options.samples = 256;
        const PixelSums sums = p.sums();
        const double open = albedo / kPi * 3 * std::sin(angle), value = mean(sums).x;
        const double deviation = std::sqrt(256 * variance_of_mean(sums).x) / value;
        const double through = value / open;  // by a shadow ray that arrives or does not
        EXPECT_LT(deviation, shaded ? 1.2 * std::sqrt((1 - through) / through) : 1e-4)
            << albedo << " at " << elevation << " degrees";
        if (shaded) {
          EXPECT_LT(through, 0.4);
        } else {
          EXPECT_NEAR(value, open, 1e-5 * open);
        }
      }
    }
  }
}

/// The ball that hides a part of the fire below.
const BallSurface kShield{{2.5, 1.6, 2.2}, 0.8, {Rgb(0.0f)}};
const Affine kFirePlace = translation({-2, 3, -1}) * scaling(Vec3d(0.4));
constexpr double kFireExtinction = 0.1;

/// What arrives on the ground at (4, 0, 3): the integral of chords over the hemisphere.
double irradiance_of_the_fire(bool shielded) {
  const pvol::Box box = transform(kFirePlace, kCube);
  double irradiance = 0;
  constexpr int kSteps = 1500;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps; ++k) {
      const double u = (i + 0.5) / kSteps, azimuth = 2 * kPi * (k + 0.5) / kSteps;
      const double sine = std::sqrt(u);
      const Ray ray{{4, 0, 3},
                    {sine * std::cos(azimuth), std::sqrt(1 - u), sine * std::sin(azimuth)}};
      const Vec3d way = kShield.centre - ray.o, beside = way - ray.d * dot(way, ray.d);
      if (shielded && length(beside) < kShield.radius) continue;
      const auto span = intersect(box, ray, 0, 1e9);
      if (span) irradiance += -std::expm1(-kFireExtinction * (span->t1 - span->t0));
    }
  }
  return irradiance * 5 * kPi / (double(kSteps) * kSteps);
}

/// A box that emits and hardly scatters, over the ground or a catcher, whose light is found by
/// scattered rays and, where anything scatters, by looking for the fire. A black ball hides a part
/// of it, or none; all of it is emission.
TEST(SurfacePicture, GroundByTheLightOfAFire) {
  proof::Family family;
  for (const bool shielded : {false, true}) {
    const double irradiance = irradiance_of_the_fire(shielded);
    for (const float albedo : {0.0f, 1e-7f}) {
      for (const Visibility visibility : {Visibility::surface, Visibility::shadow_catcher}) {
        Pixel p(component(kFireExtinction, Rgb(albedo), 0, Rgb(5.0f), kFirePlace), {9, 4, 7},
                {4, 0, 3});
        p.scene.surfaces = {ground(0.9, visibility)};
        if (shielded) p.scene.surfaces.emplace_back(kShield);
        // Its light is a matter of alpha.
        if (visibility == Visibility::shadow_catcher)
          p.scene.lights = {Sun{{1, 2, 1}, Rgb(2.0f), 0}};
        p.scene.options.line_emission = LineEmission::on;
        p.scene.options.samples = proof::samples(100'000u);
        p.scene.options.aovs.add(Aov::lights);
        const RenderResult r = p.result();
        const PixelSums& sums = r.film.pixels.front();
        expect_mean(sums, 0.9 / kPi * irradiance,
                    std::string(name(visibility)) + (shielded ? ", shielded, " : ", ") +
                        std::to_string(albedo),
                    family);
        ASSERT_EQ(r.film.layers.back().name, "emission");
        EXPECT_NEAR(r.film.layers.back().sums.front().x, sums.sum.x, 1e-5 * sums.sum.x);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(SurfacePicture, AShadowCatcherCoversByTheLightThatIsMissing) {
  // Under an absorbing cube of optical depth 0.9 along the sun's ray.
  const Affine above = translation({-6, 3, -6});
  Pixel p(component(0.9 / 13, Rgb(0.0f), 0, Rgb(0.0f), above), {20, 2, 0}, {0, 0, 0});
  p.scene.surfaces = {ground(0.3, Visibility::shadow_catcher)};
  p.scene.lights = {Sun{{0, 1, 0}, Rgb(2.0f), 0}};
  p.scene.options.background = false;
  p.scene.options.samples = 100'000;
  const PixelSums shadow = p.sums();
  expect_alpha(shadow, 1 - std::exp(-0.9));
  EXPECT_EQ(mean(shadow), Vec3d(0.0)) << "nothing scatters light to it";
  p.scene.camera.target = {-30, 0, 0};  // beside the shadow
  p.scene.options.samples = 1000;
  const PixelSums lit = p.sums();
  EXPECT_NEAR(lit.alpha / lit.samples, 0, 1e-6);
  p.scene.lights = {Sun{{0, -1, 0}, Rgb(2.0f), 0}};
  EXPECT_EQ(p.sums().alpha, 0) << "no light, no shadow";
}

/// A ball at height h hides (r / h)^2 of an even sky from the place below it, of any sky whose
/// light is sampled or met by chance; a second light's share counts by its irradiance.
TEST(SurfacePicture, AShadowCatcherUnderABall) {
  const double expected = 0.36;  // r = 1.2, h = 2
  ImageSky even{4, 2, std::vector<Rgb>(8, Rgb(0.5f))};
  const Environment skies[] = {ConstantSky{Rgb(0.5f)}, even};
  for (const Environment& sky : skies) {
    for (const bool sun : {false, true}) {
      Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
      p.scene.surfaces = {ground(0.0, Visibility::shadow_catcher), BallSurface{{0, 2, 0}, 1.2, {}}};
      std::get<BallSurface>(p.scene.surfaces[1]).material.albedo = Rgb(0.0f);
      p.scene.environment = sky;
      // A sun that the ball does not hide, as bright on the ground as the sky.
      if (sun) p.scene.lights = {Sun{{1, 0.5, 0}, Rgb(float(0.5 * kPi * std::sqrt(5.0))), 4}};
      p.scene.options.background = false;
      p.scene.options.samples = 60'000;
      const PixelSums sums = p.sums();
      expect_alpha(sums, expected * (sun ? 0.5 : 1));
      EXPECT_EQ(mean(sums), Vec3d(0.0));
      p.scene.options.background = true;  // through what it does not cover the sky is seen
      const Vec3d seen = mean(p.sums());
      EXPECT_NEAR(seen.x, 0.5 * (1 - expected * (sun ? 0.5 : 1)), 0.02);
    }
  }
}

/// A shield before a fire that lets its light through, or blocks nothing else.
TEST(SurfacePicture, TheLightOfAFirePassesWhatCastsNoShadow) {
  proof::Family family;
  const double open = irradiance_of_the_fire(false), shielded = irradiance_of_the_fire(true);
  for (const bool shadow : {true, false}) {
    for (const bool light : {true, false}) {
      for (const float albedo : {0.0f, 1e-7f}) {
        Pixel p(component(kFireExtinction, Rgb(albedo), 0, Rgb(5.0f), kFirePlace), {9, 4, 7},
                {4, 0, 3});
        BallSurface shield = kShield;
        shield.material.visible_shadow = shadow, shield.material.visible_light = light;
        p.scene.surfaces = {ground(0.9), shield};
        p.scene.options.line_emission = LineEmission::on;
        p.scene.options.samples = 100'000;
        expect_mean(p.sums(), 0.9 / kPi * (shadow ? shielded : open),
                    std::string(shadow ? "shadow, " : "no shadow, ") +
                        (light ? "light, " : "no light, ") + std::to_string(albedo),
                    family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A sky and a sun of other colours count by luminance.
TEST(SurfacePicture, AShadowCatcherInColouredLight) {
  const Rgb sky(0.9f, 0.2f, 0.1f), sun(0.1f, 0.3f, 1.0f);
  ImageSky even{4, 2, std::vector<Rgb>(8, sky)};
  const Environment skies[] = {ConstantSky{sky}, even};
  for (const Environment& environment : skies) {
    Pixel p = catcher_below_a_ball(environment, sun);
    p.scene.options.background = false;
    const double of_sky = double(luminance(sky)), of_sun = double(luminance(sun));
    expect_alpha(p.sums(), 0.36 * of_sky / (of_sky + of_sun));
    // The sky behind it is the sky's light, and unscattered.
    p.scene.options.background = true;
    p.scene.options.aovs.add(Aov::lights);
    p.scene.options.aovs.add(Aov::scattering);
    const Film film = p.result().film;
    const double all = film.pixels.front().sum.x;
    EXPECT_GT(all, 0);
    for (const Layer& l : film.layers) {
      const bool own = l.name == "sky" || l.name == "unscattered";
      EXPECT_NEAR(l.sums.front().x, own ? all : 0, 1e-4 * all) << l.name;
    }
  }
}

/// A catcher of many normals, of which none sees all of the sky, and where nothing hides any of it.
TEST(SurfacePicture, ARoundShadowCatcherInTheOpenIsNotSeen) {
  const Environment skies[] = {GradientSky{Rgb(2.0f), Rgb(0.3f), Rgb(0.01f), {0, 1, 0}},
                               ImageSky{2, 2, {Rgb(4.0f), Rgb(0.5f), Rgb(0.1f), Rgb(1.0f)}}};
  for (const Environment& sky : skies) {
    CloudScene s = cloud_scene_of_cube();
    s.medium = far_away();
    s.surfaces = {BallSurface{{6, 5, 6}, 30, {Rgb(0.0f), Visibility::shadow_catcher}}};
    s.environment = sky;
    s.lights.clear();
    s.camera.position = {90, 40, 60};
    s.camera.fov = 30;
    s.options.width = s.options.height = 8;
    s.options.samples = 250;
    double alpha = 0, samples = 0;
    for (const PixelSums& p : run_cube(s).film.pixels) alpha += p.alpha, samples += p.samples;
    // Samples lie in [-3, 1], nearly.
    EXPECT_NEAR(alpha / samples, 0, 5 * 2 / std::sqrt(samples));
  }
}

/// In white light that is the same from everywhere what a white catcher lacks by its shadow, white
/// things throw on it: paths that left it and met one bring light, and nothing of alpha.
TEST(SurfacePicture, AWhiteCatcherIsThrownTheLightThatItsShadowLacks) {
  proof::Family family;
  ImageSky even{4, 2, std::vector<Rgb>(8, Rgb(1.0f))};
  const Environment skies[] = {ConstantSky{Rgb(1.0f)}, even};
  const Slab slab({2, 1, 0.3}, {1.0});
  const Affine wide =
      translation({0, 2, 0}) * scaling({1e6 / 13, 1.0 / 13, 1e6 / 13}) * translation({-6, 0.5, -6});
  for (const Environment& sky : skies) {
    for (const bool ball : {true, false}) {
      Pixel p(ball ? far_away() : component(2, Rgb(1.0f), 0.3, Rgb(0.0f), wide), {5, 0.5, 0},
              {0, 0, 0});
      p.scene.surfaces = {ground(1, Visibility::shadow_catcher)};
      if (ball) p.scene.surfaces.emplace_back(BallSurface{{0, 2, 0}, 1.2, {Rgb(1.0f)}});
      p.scene.environment = sky;
      p.scene.options.background = false;
      p.scene.options.samples = 60'000;
      const PixelSums sums = p.sums();
      const double expected = ball ? 0.36 : 1 - slab.diffuse().direct;
      expect_alpha(sums, expected);
      expect_mean(sums, expected, ball ? "ball" : "slab", family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Lamps that rays meet: of two that are as bright on the catcher a black ball hides one, both or
/// none.
TEST(SurfacePicture, AShadowCatcherByTheLightOfLamps) {
  const Light kinds[] = {PointLight{{-6, 8, 0}, Rgb(50.0f), "", 2},
                         AreaLight{{-6, 8, 0}, {0.6, -0.8, 0}, {4, 3}, {0, 0, 1}, Rgb(9.0f), ""}};
  for (const Light& left : kinds) {
    Light right = left;
    std::visit(
        [](auto& l) {
          if constexpr (requires { l.position; }) l.position.x = 6;
          if constexpr (requires { l.size; }) l.direction.x = -0.6;
        },
        right);
    for (const int hidden : {0, 1, 2}) {
      Pixel p(far_away(), {0, 5, 9}, {0, 0, 0});
      p.scene.lights = {left, right};
      p.scene.surfaces = {ground(0.5, Visibility::shadow_catcher)};
      for (int k = 0; k < hidden; ++k) {
        p.scene.surfaces.emplace_back(BallSurface{{k ? 3.0 : -3.0, 4, 0}, 2.4, {Rgb(0.0f)}});
      }
      p.scene.options.background = false;
      p.scene.options.samples = 60'000;
      const PixelSums sums = p.sums();
      expect_alpha(sums, hidden / 2.0);
      EXPECT_EQ(mean(sums), Vec3d(0.0)) << "nothing throws light on it";
    }
  }
}

/// The camera sees lamps beside a catcher as they are, and those behind it not at all.
TEST(SurfacePicture, LampsAreSeenBesideWhatCatchesShadows) {
  const double radiance = 40 / (kPi * 4);
  for (const double up : {1.0, -1.0}) {  // above and below one another in the picture
    CloudScene s = cloud_scene_of_cube();
    s.medium = far_away();
    s.camera.position = {0, 10, 20};
    s.camera.target = {0, 10, 0};
    s.camera.up = {0, up, 0};
    s.camera.fov = 60;
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights = {PointLight{{0, 16, 0}, Rgb(40.0f), "", 2},
                PointLight{{0, -6, 0}, Rgb(40.0f), "", 2}};
    s.surfaces = {ground(0.5, Visibility::shadow_catcher)};
    s.options.width = 1, s.options.height = 40;
    s.options.threads = 1;
    const Film film = run_cube(s).film;
    int seen = 0;
    for (int y = 0; y < 40; ++y) {
      const double slope = (0.5 - (y + 0.5) / 40) * 2 * std::tan(kPi / 6) * up;
      const double past = std::abs(20 * slope - 6) / std::sqrt(1 + slope * slope);  // the lamp
      const PixelSums& p = film.at(0, y);
      if (past < 1.5) {
        ++seen;
        EXPECT_NEAR(mean(p).x, radiance, 1e-5 * radiance) << y;
        EXPECT_EQ(p.alpha, 0) << y;
      } else if (past > 2.5) {
        EXPECT_EQ(mean(p), Vec3d(0.0)) << y;
      }
    }
    EXPECT_GE(seen, 4);
  }
}

/// The sky behind is seen where it is asked for, and nothing of it is opaque; surfaces are.
TEST(SurfacePicture, AlphaIsThatOfSurfacesAndNotOfTheSky) {
  for (const bool background : {true, false}) {
    // A cloud under the ground, which nothing of it reaches.
    Pixel p(component(1, Rgb(0.9f), 0, Rgb(0.0f), translation({-6, -20, -6})), {3, 5, 2},
            {3, 50, 9});
    p.scene.surfaces = {ground(0.6)};
    p.scene.environment = ConstantSky{Rgb(0.8f)};
    p.scene.options.background = background;
    p.scene.options.samples = 100;
    const PixelSums sky = p.sums();
    EXPECT_NEAR(mean(sky).x, background ? 0.8 : 0, 1e-6);
    EXPECT_EQ(sky.alpha, 0);
    p.scene.camera.target = {0, 0, 0};
    const PixelSums lit = p.sums();
    EXPECT_NEAR(mean(lit).x, 0.6 * 0.8, 0.6 * 0.8 * 1e-5);
    EXPECT_EQ(lit.alpha, lit.samples);
    // What shines behind the ground is hidden by it, be it met or looked for.
    p.scene.lights = {PointLight{{-3, -5, -2}, Rgb(9.0f), "", 2}};
    EXPECT_NEAR(mean(p.sums()).x, 0.6 * 0.8, 0.6 * 0.8 * 1e-5);
  }
}

/// What scatters to a catcher is added, as its albedo has it.
TEST(SurfacePicture, AShadowCatcherShowsLightThatIsThrownOnIt) {
  proof::Family family;
  const SlabOptics optics{2, 1, 0.3};
  const Slab slab(optics, {0.6});
  const Affine wide =
      translation({0, 2, 0}) * scaling({1e6 / 13, 1.0 / 13, 1e6 / 13}) * translation({-6, 0.5, -6});
  Pixel p(component(2, Rgb(1.0f), 0.3, Rgb(0.0f), wide), {0.3, 1.5, 0.2}, {0, 0, 0});
  p.scene.surfaces = {ground(0.5, Visibility::shadow_catcher)};
  p.scene.lights = {Sun{{0.8, 0.6, 0}, Rgb(2.0f), 0}};
  p.scene.options.background = false;
  p.scene.options.samples = 60'000;
  const PixelSums sums = p.sums();
  const Fluxes beam = slab.collimated(0), back = slab.diffuse();
  expect_alpha(sums, 1 - beam.direct);
  // All light on the ground but the beam as it arrives at first.
  const double all = (beam.direct + beam.transmitted) / (1 - 0.5 * back.reflected);
  expect_mean(sums, 0.5 / kPi * 2 * 0.6 * (all - beam.direct), "thrown", family);
  EXPECT_TRUE(family.passes());
}

/// Where no light arrives unscattered there is no shadow, and light that is thrown there is shown:
/// an area that shines up on a ball, of which the catcher is dark by itself.
TEST(SurfacePicture, AShadowCatcherInTheDarkShowsLightThatIsThrownOnIt) {
  const auto picture = [](Visibility visibility) {
    Pixel p(far_away(), {3, 1, 0.3}, {0.4, 0, 0});
    p.scene.surfaces = {ground(0.5, visibility), BallSurface{{0, 3, 0}, 1, {Rgb(0.8f)}}};
    p.scene.lights.emplace_back(
        AreaLight{{0, 0.5, 0}, {0, 1, 0}, {1, 1}, {0, 0, 1}, Rgb(3.0f), ""});
    p.scene.options.background = false;
    p.scene.options.samples = 400'000;
    return p.sums();
  };
  const PixelSums seen = picture(Visibility::surface), caught = picture(Visibility::shadow_catcher);
  EXPECT_EQ(caught.alpha, 0);
  EXPECT_GT(mean(seen).x, 0);
  const double error = std::sqrt(variance_of_mean(seen).x + variance_of_mean(caught).x);
  EXPECT_LT(error, 0.01 * mean(seen).x);
  EXPECT_NEAR(mean(caught).x, mean(seen).x, 4.5 * error);
}

/// Bounces limit what is scattered to a catcher, not its shadow; paths end all the same.
TEST(SurfacePicture, AShadowCatcherKeepsToTheLimitOfBounces) {
  for (const std::uint32_t bounces : {0u, 1u}) {
    Pixel p(far_away(), {5, 0.5, 0}, {0, 0, 0});
    p.scene.surfaces = {ground(1, Visibility::shadow_catcher),
                        BallSurface{{0, 2, 0}, 1.2, {Rgb(1.0f)}}};
    p.scene.environment = ConstantSky{Rgb(0.5f)};
    p.scene.options.background = false;
    p.scene.options.max_bounces = bounces;
    p.scene.options.samples = 60'000;
    p.scene.options.count = true;
    const RenderResult r = p.result();
    expect_alpha(r.film.pixels.front(), 0.36);
    EXPECT_EQ(mean(r.film.pixels.front()), Vec3d(0.0)) << "light that was scattered twice";
    EXPECT_LE(r.counts.surface_hits, 2 * 60'000u);
  }
}

/// A lamp that lies on a wall or ceiling lights what it faces, and is seen, as one just before it.
TEST(SurfacePicture, ALampMayLieOnAWall) {
  proof::Family family;
  MeshSurface ceiling;
  ceiling.mesh = std::make_shared<const TriangleMesh>(square_mesh(5));
  ceiling.place.translate = Vec3d(0, 2, 0);
  const Surface walls[] = {PlaneSurface{{0, 2, 0}, {0, 1, 0}, {Rgb(0.0f)}}, ceiling};
  for (Surface wall : walls) {
    std::visit([](auto& s) { s.material.albedo = Rgb(0.0f); }, wall);
    Pixel p(far_away(), {1, 1, 0.3}, {0, 0, 0});
    const AreaLight lamp{{0, 2, 0}, {0, -1, 0}, {0.5, 0.5}, {0, 0, 1}, Rgb(3.0f), ""};
    const double irradiance = double(AreaSource(lamp).on_plane({0, 0, 0}, {0, 1, 0}).x);
    p.scene.surfaces = {ground(0.5), wall};
    p.scene.lights.emplace_back(lamp);
    expect_mean(p.sums(), 0.5 / kPi * irradiance, "lit", family);
    p.scene.camera.target = {0.1, 2, 0.1};
    EXPECT_NEAR(mean(p.sums()).x, 3, 1e-5) << "seen";
  }
  EXPECT_TRUE(family.passes());
}

TEST(SurfacePicture, AHoldoutIsAHole) {
  // A cube of optical depth 1 before it, whose light is what it is without.
  Pixel p(component(1.0 / 13, Rgb(0.9f), 0), {6, 6, 40}, {6, 6, 6});
  p.scene.environment = ConstantSky{Rgb(1.0f)};
  p.scene.surfaces = {BallSurface{{6, 6, -20}, 5, {Rgb(0.5f), Visibility::holdout}}};
  p.scene.options.max_bounces = 0;
  const PixelSums hole = p.sums();
  expect_alpha(hole, 1 - std::exp(-1.0));
  EXPECT_EQ(mean(hole), Vec3d(0.0)) << "no sky behind it";
  // Others see it: its light falls on the ground before the camera.
  Pixel seen(far_away(), {0, 1, 0}, {0, 0, 0});
  seen.scene.surfaces = {ground(0.5), BallSurface{{0, 10, 0}, 8, {Rgb(1.0f), Visibility::holdout}}};
  seen.scene.environment = ConstantSky{Rgb(1.0f)};
  seen.scene.options.samples = 2000;
  EXPECT_GT(mean(seen.sums()).x, 0.2);
}

TEST(SurfacePicture, LayersAreTheSurfacesAndSumUp) {
  CloudScene s = cloud_scene_of_cube();
  s.surfaces = {ground(0.5), BallSurface{{6, 14, 6}, 2, {Rgb(0.2f, 0.4f, 0.6f)}}};
  s.lights = {Sun{{1, 2, 0.5}, Rgb(2.0f), 3}, PointLight{{20, 20, 20}, Rgb(100.0f)}};
  s.options.width = s.options.height = 16;
  for (const Aov a :
       {Aov::lights, Aov::scattering, Aov::albedo, Aov::normal, Aov::depth, Aov::position}) {
    s.options.aovs.add(a);
  }
  const RenderResult r = run_cube(s);
  const auto layer = [&](const std::string& name) -> const Layer& {
    for (const Layer& l : r.film.layers) {
      if (l.name == name) return l;
    }
    throw Error("no layer " + name);
  };
  for (std::size_t i = 0; i < r.film.pixels.size(); ++i) {
    const Vec3d sum = r.film.pixels[i].sum;
    const Vec3d lights = layer("sun_1").sums[i] + layer("point_1").sums[i] + layer("sky").sums[i];
    const Vec3d orders =
        layer("unscattered").sums[i] + layer("single").sums[i] + layer("multiple").sums[i];
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(lights[c], sum[c], 1e-4 * (1 + sum[c]));
      EXPECT_NEAR(orders[c], sum[c], 1e-4 * (1 + sum[c]));
    }
  }
  // The lowest row sees the ground alone.
  const std::size_t last = r.film.pixels.size() - 1;
  const auto value = [&](const char* name) {
    return layer(name).sums[last] / layer(name).weights[last];
  };
  EXPECT_EQ(value("albedo"), Vec3d(0.5));
  EXPECT_NEAR(value("normal").y, 1, 1e-6);
  EXPECT_NEAR(value("position").y, 0, 1e-6);
  EXPECT_GT(value("depth").x, 1);
}

/// What is first met is now the cloud's, now that of the ground behind it.
TEST(SurfacePicture, TheFirstAlbedoIsThatOfWhatIsMet) {
  Pixel p(component(1.0 / 13, Rgb(0.9f), 0), {6, 6, 40}, {6, 6, 6});
  p.scene.surfaces = {PlaneSurface{{0, 0, -20}, {0, 0, 1}, {Rgb(0.4f)}}};
  p.scene.options.aovs.add(Aov::albedo);
  const Film film = p.result().film;
  const Layer& layer = film.layers.front();
  const double cloud = 1 - std::exp(-1.0);
  EXPECT_NEAR(layer.sums.front().x / layer.weights.front(), 0.9 * cloud + 0.4 * (1 - cloud), 0.01);
}

/// Guided paths end, split and turn, and bring the same light on average: of all lights, over
/// ground and beside it, on a catcher, too.
TEST(SurfacePicture, GuidingChangesNoMean) {
  proof::Family family;
  for (const Visibility visibility : {Visibility::surface, Visibility::shadow_catcher}) {
    CloudScene s = cloud_scene_of_cube();
    s.medium = component(0.6, Rgb(0.95f), 0.8);
    s.surfaces = {ground(0.6, visibility), BallSurface{{14, 4, 9}, 3, {Rgb(0.8f)}}};
    s.lights = {Sun{{1, 2, -1}, Rgb(3.0f), 2}, PointLight{{-9, 9, 9}, Rgb(200.0f), "", 1.5},
                AreaLight{{6, 25, 6}, {0, -1, 0}, {6, 6}, {0, 0, 1}, Rgb(2.0f), ""}};
    s.environment = ImageSky{2, 2, {Rgb(0.4f), Rgb(0.1f), Rgb(0.2f), Rgb(0.3f)}};
    s.options.width = s.options.height = 16;
    s.options.samples = 256;
    s.options.guide = GuideUse::off;
    const RenderResult plain = run_cube(s);
    s.options.guide = GuideUse::on;
    s.options.seed = 7;
    const RenderResult guided = run_cube(s);
    EXPECT_TRUE(guided.guided);
    compare(average(guided.film), average(plain.film), name(visibility), family, 1e-4);
    // The cube in the middle and the ground before it, each by itself.
    compare(average(guided.film, 6, 4, 4, 4), average(plain.film, 6, 4, 4, 4), "cube", family,
            1e-4);
    compare(average(guided.film, 4, 12, 8, 4), average(plain.film, 4, 12, 8, 4), "ground", family,
            1e-4);
  }
  EXPECT_TRUE(family.passes());
}

/// Branches go on from where they were made: in a cloud that is lit from behind and by a lamp in
/// it, without surfaces that would even things out.
TEST(SurfacePicture, BranchesBringTheSameLight) {
  CloudScene s = cloud_scene_of_cube();
  s.medium = component(0.6, Rgb(0.95f), 0.85);
  s.lights = {Sun{{30, 10, -30}, Rgb(3.0f), 5}, PointLight{{2, 9, 4}, Rgb(3.0f), "", 1}};
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 12;
  s.options.samples = 6144;
  s.options.guide = GuideUse::off;
  const Film plain = run_cube(s).film;
  // Far off: nothing meets it, but another tracer renders.
  s.surfaces = {BallSurface{{0, 0, 1e7}, 1, {}}};
  s.options.guide = GuideUse::on;
  s.options.seed = 8;
  s.options.samples = 2048;
  const RenderResult guided = run_cube(s);
  EXPECT_TRUE(guided.guided);
  proof::Family family;
  compare(average(guided.film), average(plain), "all", family, 1e-5);
  EXPECT_TRUE(family.passes());
}

TEST(SurfacePicture, IsTheSameForAnyThreads) {
  CloudScene s = cloud_scene_of_cube();
  s.surfaces = {ground(0.5), BallSurface{{6, 14, 6}, 2, {}}};
  s.options.width = s.options.height = 24;
  s.options.threads = 1;
  const Film one = run_cube(s).film;
  s.options.threads = 3;
  const Film three = run_cube(s).film;
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    EXPECT_EQ(one.pixels[i].sum, three.pixels[i].sum);
    EXPECT_EQ(one.pixels[i].alpha, three.pixels[i].alpha);
  }
}

void expect_refused(CloudScene s, const std::string& key) {
  if (s.surfaces.empty()) s.surfaces.push_back(ground(0.5));
  const Field& f = cube();
  const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
  const Scene scene = s.scene();
  try {
    (void)plan({&v, 1}, scene);
    FAIL() << key;
  } catch (const Error& e) {
    EXPECT_TRUE(says(e.what(), key));
  }
}

/// A catcher whose paths may not scatter shows no light of a fire.
TEST(SurfacePicture, ACatcherWithoutBouncesThrowsNoFire) {
  for (const std::uint32_t bounces : {0u, 1u}) {
    Pixel p(component(kFireExtinction, Rgb(0.0f), 0, Rgb(5.0f), kFirePlace), {9, 4, 7}, {4, 0, 3});
    p.scene.surfaces = {ground(0.9, Visibility::shadow_catcher)};
    p.scene.lights = {Sun{{1, 2, 1}, Rgb(2.0f), 0}};
    p.scene.options.background = false;
    p.scene.options.line_emission = LineEmission::on;
    p.scene.options.max_bounces = bounces;
    EXPECT_EQ(mean(p.sums()).x > 0, bounces > 0);
  }
}

/// Flights with weights end at surfaces as all others do.
TEST(SurfacePicture, WeightedTrackersHaveTheMeansOfTheOthers) {
  CloudScene s = cloud_scene_of_cube();
  s.surfaces.push_back(ground(0.5));
  s.options.guide = GuideUse::off;
  s.options.width = s.options.height = 64;
  s.options.samples = proof::samples(400);
  const Film analog = run_cube(s).film;
  proof::Family family;
  for (const Tracker tracker : {Tracker::weighted_delta, Tracker::weighted_decomposition}) {
    s.options.tracker = tracker, s.options.seed = 2 + std::uint64_t(tracker);
    compare(run_cube(s).film, analog, name(tracker), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(SurfacePicture, WhatDoesNotGoTogetherIsRefused) {
  CloudScene room = cloud_scene_of_cube();
  room.surfaces = {BallSurface{{6, 6, 6}, 60, {Rgb(1.0f)}}};
  expect_refused(room, "surfaces.most_paths_bounce");
  room.options.max_bounces = 10;
  room.options.width = room.options.height = 4;
  EXPECT_NO_THROW((void)run_cube(room));
}

}  // namespace surface_picture_test
}  // namespace pvol::test
