// What becomes of the parts of pbrt's scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/formats/image.h"
#include "pvol/formats/vdb.h"
#include "pvol/render/near_lights.h"
#include "pvol/volume/blackbody.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/pbrt_text.h"

namespace pvol::formats {
namespace pbrt_scene_test {

using test::error_of;
using test::kPbrtFog;
using test::notes_of;
using test::pbrt_text;
using test::read_pbrt_text;

const std::string kCamera = "LookAt 0 0 -5 0 0 0 0 1 0\nCamera \"perspective\"\n";

PbrtScene scene_of(const std::string& after, const std::string& fog = kPbrtFog,
                   const std::string& before = kCamera) {
  return read_pbrt_text(pbrt_text(before, after, fog));
}

void expect_near(Vec3d a, Vec3d b, double error = 1e-6) {
  EXPECT_LT(length(a - b), error * std::max(1.0, length(b)))
      << a.x << ", " << a.y << ", " << a.z << " and " << b.x << ", " << b.y << ", " << b.z;
}

// Of pbrt's world with the camera above, whose z points the other way in pvol's.
Vec3d mirrored(Vec3d v) { return {v.x, v.y, -v.z}; }

TEST(PbrtScene, SunsShineFromWherePbrtsDo) {
  const PbrtScene s = scene_of(
      "LightSource \"distant\" \"point3 from\" [ 1 2 3 ] \"point3 to\" [ 0 0 1 ] \"rgb L\" [ 1 2 3 "
      "]"
      " \"float scale\" 2\n"
      "AttributeBegin Rotate 90 0 1 0 LightSource \"distant\" \"float illuminance\" 5 "
      "AttributeEnd");
  const auto& first = std::get<Sun>(s.file.scene.lights.at(0));
  expect_near(normalize(first.direction), normalize(mirrored({1, 2, 2})));
  expect_near(Vec3d(first.irradiance), {2, 4, 6});
  // By default light goes along +z, which the turn takes to +x: it comes from -x.
  const auto& second = std::get<Sun>(s.file.scene.lights.at(1));
  expect_near(normalize(second.direction), {-1, 0, 0});
  expect_near(Vec3d(second.irradiance), {5, 5, 5});
}

TEST(PbrtScene, PointLightsByIntensityPowerAndTemperature) {
  const PbrtScene s = scene_of(
      "Translate 1 2 3 LightSource \"point\" \"rgb I\" [ 4 5 6 ] \"point3 from\" [ 0 0 1 ]\n"
      "LightSource \"point\" \"float power\" 100\n"
      "LightSource \"point\" \"blackbody I\" 2500 \"float scale\" 3");
  const auto at = [&](std::size_t i) { return std::get<PointLight>(s.file.scene.lights.at(i)); };
  expect_near(at(0).position, mirrored({1, 2, 4}));
  expect_near(Vec3d(at(0).intensity), {4, 5, 6});
  expect_near(Vec3d(at(1).intensity), Vec3d(100 / (4 * std::numbers::pi)));
  expect_near(Vec3d(at(2).intensity), Vec3d(blackbody_color(2500)) * 3.0);
  EXPECT_NEAR(luminance(at(2).intensity), 3, 1e-3);
}

/// What pbrt-v4's film has of spectra by wavelength, 16384 samples: of lights over their luminance,
/// of reflectances in the light of rgb 1 1 1.
TEST(PbrtScene, SpectraHaveTheColoursThatPbrtsFilmSees) {
  const auto light = [](const std::string& pairs) {
    const PbrtScene s = scene_of("LightSource \"point\" \"spectrum I\" [ " + pairs + " ]");
    return Vec3d(std::get<PointLight>(s.file.scene.lights.at(0)).intensity);
  };
  expect_near(light("400 0 700 6"), {1.764, 0.852, 0.214}, 3e-3);
  expect_near(light("200 1 900 1"), {1.205, 0.948, 0.909}, 3e-3);
  const Vec3d green = light("500 1 600 1");  // 0 beyond: (0.364, 1.302, -0.112)
  EXPECT_EQ(green.z, 0);
  EXPECT_NEAR(green.x / green.y, 0.364 / 1.302, 5e-3);
  EXPECT_NEAR(double(luminance(Rgb(green))), 1, 1e-6);
  const auto matter = [](const std::string& pairs) {
    const PbrtScene s = scene_of("Material \"diffuse\" \"spectrum reflectance\" [ " + pairs +
                                 " ] Shape \"sphere\"");
    return Vec3d(std::get<BallSurface>(s.file.scene.surfaces.at(0)).material.albedo);
  };
  expect_near(matter("400 .1 550 .4 700 .8"), {0.638, 0.389, 0.180}, 2e-3);
  expect_near(matter("360 .5 830 .5"), {0.5, 0.5, 0.5});
  expect_near(matter("450 0 500 .6 560 .6 600 0"), {0, 0.601, 0.084}, 4e-3);
}

TEST(PbrtScene, SpectraByWavelengthAreNamed) {
  const PbrtScene s = scene_of(
      "LightSource \"point\" \"spectrum I\" [ 400 0 700 6 ]\n"
      "LightSource \"distant\" \"spectrum L\" [ 500 1 550 1 ]");
  EXPECT_TRUE(says(notes_of(s), "pbrt.by_wavelength"));
  EXPECT_TRUE(says(notes_of(s), "pbrt.by_wavelength_outside"));
  EXPECT_TRUE(says(
      error_of([] { (void)scene_of("LightSource \"point\" \"spectrum I\" [ 400 0 700 -1 ]"); }),
      "pbrt.by_wavelength_negative"));
}

/// What pbrt's spot light sends along a direction at an angle from its axis.
double falloff(double degrees, double cone, double fade) {
  const auto cosine = [](double d) { return std::cos(d * std::numbers::pi / 180); };
  const double share = (cosine(degrees) - cosine(cone)) / (cosine(cone - fade) - cosine(cone));
  const double x = std::clamp(share, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

TEST(PbrtScene, SpotsFadeAsPbrtsDo) {
  const PbrtScene s = scene_of(
      "Translate 0 0 2 LightSource \"spot\" \"point3 from\" [ 1 0 0 ] \"point3 to\" [ 1 0 4 ] "
      "\"float coneangle\" 40 \"float conedeltaangle\" 15 \"rgb I\" [ 2 4 6 ]\n"
      "LightSource \"spot\" \"float power\" 10");
  const auto& spot = std::get<SpotLight>(s.file.scene.lights.at(0));
  expect_near(spot.position, mirrored({1, 0, 2}));
  expect_near(spot.direction, {0, 0, -1});
  expect_near(Vec3d(spot.intensity), {2, 4, 6});
  const SpotSource source(spot);
  for (const double degrees : {0.0, 20.0, 26.0, 33.0, 39.0, 41.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const double share = source.share({std::sin(angle), 0, -std::cos(angle)});
    EXPECT_NEAR(share, falloff(degrees, 40, 15), 1e-6) << degrees;
  }
  double power = 0;  // of the second, 30 and 5 degrees, over rings
  for (int i = 0; i < 3000; ++i) {
    const double degrees = (i + 0.5) / 100, step = std::numbers::pi / 180 / 100;
    power += 2 * std::numbers::pi * std::sin(degrees * std::numbers::pi / 180) * step *
             falloff(degrees, 30, 5);
  }
  const auto& second = std::get<SpotLight>(s.file.scene.lights.at(1));
  EXPECT_NEAR(double(second.intensity.x) * power, 10, 1e-3);
}

TEST(PbrtScene, SpheresThatShineAreBallsOfLight) {
  const PbrtScene s = scene_of(
      "AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ] \"float scale\" 2 Translate 1 2 3 Scale 2 2 "
      "2 "
      "Shape \"sphere\" \"float radius\" .25\n"
      "AreaLightSource \"diffuse\" \"float power\" 7 Shape \"sphere\" Shape \"disk\"\n"
      "AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" 7 Shape \"sphere\"");
  const auto& ball = std::get<PointLight>(s.file.scene.lights.at(0));
  expect_near(ball.position, mirrored({1, 2, 3}));
  EXPECT_DOUBLE_EQ(ball.radius, 0.5);
  expect_near(Vec3d(ball.intensity), Vec3d{2, 4, 6} * (std::numbers::pi / 4));
  // All of its power over the sphere around it.
  const auto& second = std::get<PointLight>(s.file.scene.lights.at(1));
  EXPECT_NEAR(double(second.intensity.y) * 4 * std::numbers::pi, 7, 1e-5);
  // Half of it, as the other half shines inwards.
  const auto& third = std::get<PointLight>(s.file.scene.lights.at(2));
  EXPECT_NEAR(double(third.intensity.y) * 4 * std::numbers::pi, 3.5, 1e-5);
  EXPECT_EQ(s.file.scene.lights.size(), 3u);
  EXPECT_EQ(s.file.scene.surfaces.size(), 1u);  // the disk, which shines no more
  EXPECT_TRUE(says(notes_of(s), "pbrt.light_disk_left"));
}

TEST(PbrtScene, RectanglesThatShineFaceTheWayOfPbrts) {
  const std::string patch =
      "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  2 0 0  0 1 0  2 1 0 ]\n";  // its front is +z
  const PbrtScene s = scene_of(
      "AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ] Translate 0 0 5 " + patch +
      "AttributeBegin Scale 1 1 -1 " + patch + "AttributeEnd ReverseOrientation " + patch +
      "ReverseOrientation Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  0 1 0  2 1 0  2 0 0 ] "
      "\"integer indices\" [ 0 1 2 0 2 3 ]\n"
      "AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" 12 " +
      patch);
  const double fronts[] = {1, -1, -1, -1, 1, -1};  // in pbrt's world
  ASSERT_EQ(s.file.scene.lights.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto& area = std::get<AreaLight>(s.file.scene.lights[i]);
    expect_near(area.position, mirrored({1, 0.5, 5}));
    expect_near(normalize(area.direction), mirrored({0, 0, fronts[i]}));
    const double along_y = area.size[std::abs(area.up.y) > 0.5 ? 1 : 0];
    EXPECT_NEAR(along_y, 1, 1e-12) << i;
    EXPECT_NEAR(area.size[0] * area.size[1], 2, 1e-12);
    const double power = std::numbers::pi * 2 * 2;  // per radiance, of both sides
    expect_near(Vec3d(area.radiance), i < 4 ? Vec3d{1, 2, 3} : Vec3d(12 / power));
  }
  EXPECT_TRUE(s.file.scene.surfaces.empty());
}

TEST(PbrtScene, PatchesThatAreNotFlatAreNoted) {
  const auto notes = [](const std::string& last) {
    return notes_of(scene_of("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0  1 0 0  0 .001 0  " +
                             last + " ]"));
  };
  EXPECT_TRUE(says(notes("1 .001 .01"), "pbrt.patch_bent"));
  // Beside its longer side this one is as flat as single precision tells.
  EXPECT_EQ(times_said(notes("1 .001 .0001"), "pbrt.patch_bent"), 0);
}

// pbrt-v4 renders this rectangle at 3.80, and the patch of its corners at 1.90.
TEST(PbrtScene, EachTriangleOfARectangleHasThePower) {
  const std::string corners = "\"point3 P\" [ -1 -.5 0  1 -.5 0  -1 .5 0  1 .5 0 ]\n";
  const PbrtScene s = scene_of(
      "AreaLightSource \"diffuse\" \"float power\" 12\n"
      "Shape \"trianglemesh\" \"integer indices\" [ 0 1 3 0 3 2 ] " +
      corners + "Shape \"bilinearmesh\" " + corners);
  const auto radiance = [&](std::size_t i) {
    return Vec3d(std::get<AreaLight>(s.file.scene.lights.at(i)).radiance);
  };
  const double one = 12 / (std::numbers::pi * 2);
  expect_near(radiance(0), Vec3d(2 * one));
  expect_near(radiance(1), Vec3d(one));
}

TEST(PbrtScene, EvenSkiesAddUpAndWithoutLightIsNight) {
  EXPECT_EQ(std::get<ConstantSky>(scene_of("").file.scene.environment).radiance, Rgb(0.0f));
  const PbrtScene s = scene_of(
      "LightSource \"infinite\" \"rgb L\" [ .1 .2 .3 ] LightSource \"infinite\" \"float scale\" "
      ".5\n"
      "LightSource \"infinite\" \"float illuminance\" 3.14159265");
  expect_near(Vec3d(std::get<ConstantSky>(s.file.scene.environment).radiance), {1.6, 1.7, 1.8});
}

/// The book's map from the square to the sphere, the other way than the importer's.
Vec3d from_square(double s, double t) {
  const double u = 2 * s - 1, v = 2 * t - 1;
  const double distance = 1 - std::abs(u) - std::abs(v), r = 1 - std::abs(distance);
  const double phi = (r == 0 ? 1 : (std::abs(v) - std::abs(u)) / r + 1) * (std::numbers::pi / 4);
  const double level = r * std::sqrt(2 - r * r);
  return {std::copysign(std::cos(phi), u) * level, std::copysign(std::sin(phi), v) * level,
          std::copysign(1 - r * r, distance)};
}

/// Radiance by direction in the light's space, without symmetries.
Vec3d sky_color(Vec3d d) { return {2 + d.x, 2 + d.y + 0.3 * d.x * d.z, 2 + d.z}; }

void write_sky(const std::filesystem::path& file, int n) {
  Film film;
  film.width = film.height = film.crop_width = film.crop_height = n;
  for (int i = 0; i < n * n; ++i) {
    PixelSums p;
    p.sum = sky_color(from_square((i % n + 0.5) / n, (double(i / n) + 0.5) / n));
    p.samples = 1;
    film.pixels.push_back(p);
  }
  (void)write_exr(file, film, {});
}

TEST(PbrtScene, SkyPicturesStandWherePbrtsDo) {
  const TemporaryFolder folder;
  write_sky(folder.file("sky.exr"), 64);
  write_bytes(
      folder.file("a.pbrt"),
      pbrt_text(kCamera,
                "LightSource \"infinite\" \"rgb L\" [ 0 0 0 ]\n"
                "Rotate 90 1 0 0 Rotate 90 0 0 1 LightSource \"infinite\" \"string filename\" "
                "\"sky.exr\" \"float scale\" 2"));
  const PbrtScene s = read_pbrt(folder.file("a.pbrt"), "out");
  EXPECT_EQ(std::get<ImageSky>(s.file.scene.environment).file, "out_sky.exr");
  ASSERT_EQ(s.sky.pixels.size(), 128u * 64);
  double worst = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double azimuth = 2 * std::numbers::pi * (x + 0.5) / 128;
      const double angle = std::numbers::pi * (y + 0.5) / 64;
      const Vec3d d = mirrored({std::sin(angle) * std::cos(azimuth), std::cos(angle),
                                std::sin(angle) * std::sin(azimuth)});  // in pbrt's world
      // The turns take the light's +x to the world's +z, +y to -x and +z to -y.
      const Vec3d expected = 2.0 * sky_color({d.z, -d.x, -d.y});
      const Vec3d found(s.sky.pixels[std::size_t(y * 128 + x)]);
      worst = std::max(worst, length(found - expected));
    }
  }
  EXPECT_LT(worst, 0.25);  // of up to 6: a pixel is 1/64 of half a turn
}

TEST(PbrtScene, SamplesOfAUniformGridAreWherePbrtsAre) {
  const PbrtScene s = scene_of("", "Translate 1 2 3 Scale 2 4 6\n" + kPbrtFog);
  ASSERT_EQ(s.volumes.size(), 1u);
  EXPECT_EQ(s.volumes[0].name, "out_fog.vdb");
  EXPECT_EQ(s.file.volumes.at(0).file, "out_fog.vdb");
  const VoxelGrid& grid = s.volumes[0].grids.at(0);
  for (int i = 0; i < 8; ++i) {
    const Vec3i at{i % 2, i / 2 % 2, i / 4};  // x runs fastest
    EXPECT_EQ(sample(grid, at), float(i + 1));
    const Vec3d in_box = (Vec3d(at) + Vec3d(0.5)) * 0.5;
    const Vec3d place = mirrored({1 + 2 * in_box.x, 2 + 4 * in_box.y, 3 + 6 * in_box.z});
    const Affine all = s.file.volumes[0].object_to_world * grid.index_to_world;
    expect_near(all.point(Vec3d(at)), place);
  }
}

TEST(PbrtScene, AMediumMadeBeforeTheCameraStandsWherePbrtHasIt) {
  const std::string medium =
      "MakeNamedMedium \"b\" \"string type\" \"uniformgrid\" \"float density\" 1\n";
  const PbrtScene s = scene_of("",
                               "AttributeBegin MediumInterface \"b\" \"\" Material \"interface\" "
                               "Shape \"sphere\" AttributeEnd\n",
                               "Translate 1 2 3\n" + medium + kCamera);
  // The camera is at (-1, -2, -8).
  expect_near(s.file.volumes.at(0).object_to_world.point({0, 0, 0}), mirrored({0, 0, -5}));
  EXPECT_TRUE(says(notes_of(s), "pbrt.medium_before_camera"));
}

std::string fog_of(const std::string& parameters) {
  std::string text = kPbrtFog;
  return text.insert(text.find("\"float density\""), parameters + " ");
}

TEST(PbrtScene, ExtinctionAlbedoAndPhase) {
  const PbrtScene s =
      scene_of("", fog_of("\"rgb sigma_a\" [ 1 2 0 ] \"rgb sigma_s\" [ 3 6 4 ] \"float scale\" 2 "
                          "\"float g\" .7"));
  const Medium& m = s.file.volumes.at(0).medium;
  EXPECT_TRUE(s.file.volumes[0].has_extinction);
  EXPECT_DOUBLE_EQ(m.extinction, 16);
  expect_near(Vec3d(m.extinction_color), {0.5, 1, 0.5});
  expect_near(Vec3d(m.components.front().albedo), {0.75, 0.75, 1});
  EXPECT_DOUBLE_EQ(std::get<HenyeyGreenstein>(m.components.front().phase).mean_cosine, 0.7);
  const Medium usual = scene_of("").file.volumes.at(0).medium;
  EXPECT_DOUBLE_EQ(usual.extinction, 2);
  expect_near(Vec3d(usual.components.front().albedo), Vec3d(0.5));
}

TEST(PbrtScene, EmissionBySamples) {
  const PbrtScene s = scene_of(
      "",
      fog_of("\"rgb Le\" [ 1 2 3 ] \"rgb sigma_a\" [ 1 1 2 ] \"float scale\" 5 \"float Lescale\" "
             "[ 1 0 0 0 0 0 0 2 ]"));
  const SceneVolume& v = s.file.volumes.at(0);
  EXPECT_EQ(v.grid, "density");
  ASSERT_TRUE(v.fire);
  expect_near(Vec3d(emission(*v.fire, 1, 0)), {5, 10, 30});
  EXPECT_EQ(v.fire->field, "glow");
  EXPECT_EQ(sample(s.volumes.at(0).grids.at(1), {1, 1, 1}), 16);
}

// pbrt then takes a single sample in the middle of the box, and 0 around it: 3/4 of it along each
// axis at a quarter of the box.
TEST(PbrtScene, EmissionWithoutLescaleFadesToTheCorners) {
  const PbrtScene s = scene_of("", fog_of("\"rgb Le\" [ 1 2 3 ] \"rgb sigma_a\" [ 1 1 2 ]"));
  const SceneVolume& v = s.file.volumes.at(0);
  ASSERT_TRUE(v.fire);
  expect_near(Vec3d(emission(*v.fire, 1, 0)), {1, 2, 6});
  EXPECT_EQ(v.fire->field, "glow");
  EXPECT_FLOAT_EQ(sample(s.volumes.at(0).grids.at(1), {1, 0, 1}), 6 * 27 / 64.0f);
  EXPECT_TRUE(says(notes_of(s), "pbrt.without_lescale"));
}

/// pbrt's radiance of a temperature: Planck's law over its peak, weighed by the observer, in steps
/// of its own.
double luminance_of(double kelvin) {
  const auto planck = [&](double nm) {
    return std::pow(nm, -5) / std::expm1(1.438776877e7 / (nm * kelvin));
  };
  // CIE 1931 y at 400, 420 ... 700 nm.
  constexpr double kObserver[] = {0.0004, 0.0040, 0.0230, 0.0600, 0.1390, 0.3230, 0.7100, 0.9540,
                                  0.9950, 0.8700, 0.6310, 0.3810, 0.1750, 0.0610, 0.0170, 0.0041};
  double sum = 0;
  for (int i = 0; i < 16; ++i) sum += 20 * kObserver[i] * planck(400 + 20 * i);
  return sum / planck(2.897771955e6 / kelvin);
}

TEST(PbrtScene, TemperaturesGlowAsPbrtsDo) {
  const PbrtScene s = scene_of(
      "",
      fog_of("\"rgb sigma_a\" [ 3 3 3 ] \"float temperatureoffset\" 1 \"float Lescale\" [ 1 1 1 1 "
             ".5 .5 .5 .5 ] \"float temperaturescale\" 1000 "
             "\"float temperature\" [ 1 1 2 2 3 3 4 4 ]"));
  const SceneVolume& v = s.file.volumes.at(0);
  ASSERT_TRUE(v.fire);
  EXPECT_EQ(v.fire->field, "glow");
  EXPECT_EQ(v.fire->color_by, "temperature");
  const auto& grids = s.volumes.at(0).grids;
  EXPECT_EQ(grids.at(1).name, "temperature");
  EXPECT_EQ(sample(grids.at(2), {1, 1, 0}), 4);  // Lescale times density
  EXPECT_EQ(sample(grids.at(2), {1, 1, 1}), 4);
  for (const double value : {2.5, 3.0, 3.9}) {  // 1500 to 2900 K, at strength 2
    const double expected = 2 * 3 * luminance_of((value - 1) * 1000);
    EXPECT_NEAR(double(luminance(emission(*v.fire, 2, float(value)))) / expected, 1, 0.03) << value;
  }
  EXPECT_EQ(emission(*v.fire, 2, 1.05f), Rgb(0.0f));
}

TEST(PbrtScene, ScalesOfEmissionNeedEmission) {
  const std::string scales = "\"float Lescale\" [ 1 1 1 1 1 1 1 1 ] ";
  EXPECT_TRUE(says(notes_of(scene_of("", fog_of(scales))), "pbrt.lescale_alone"));
  const std::string both = error_of([&] {
    (void)scene_of("", fog_of("\"rgb Le\" [ 1 1 1 ] \"float temperature\" [ 1 1 1 1 1 1 1 1 ]"));
  });
  EXPECT_TRUE(says(both, "pbrt.le_and_temperature"));
}

TEST(PbrtScene, NanovdbKeepsItsFileAndPlace) {
  const std::string shapes =
      "AttributeBegin Material \"\" MediumInterface \"c\" \"\" Shape \"sphere\" AttributeEnd\n";
  const std::string missing = error_of([&] {
    (void)scene_of("",
                   "MakeNamedMedium \"c\" \"string type\" \"nanovdb\" \"string filename\" "
                   "\"none.nvdb\"\n" +
                       shapes);
  });
  EXPECT_NE(missing.find("none.nvdb"), missing.npos) << missing;
}

TEST(PbrtScene, HomogeneousMediaFillBallsWhereverTheyAre) {
  const std::string ball = " Shape \"sphere\" \"float radius\" 2 ";
  const std::string fog =
      "Translate 7 0 0 MakeNamedMedium \"f\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 0 0 "
      "0 ] \"rgb sigma_s\" [ 1 1 1 ]\nTranslate -6 2 3 MediumInterface \"f\" \"\" Material "
      "\"interface\"" +
      ball + "Translate 5 0 1 Scale .5 1 1" + ball +
      "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]";
  const PbrtScene s = scene_of("", fog);
  const VoxelGrid& grid = s.volumes.at(0).grids.at(0);
  const SceneVolume& v = s.file.volumes.at(0);
  ASSERT_EQ(v.instances.size(), 2u);
  const double volume = 4 * std::numbers::pi / 3 * 8;
  for (const std::size_t i : {0u, 1u}) {
    const Affine place = v.instances[i] * v.object_to_world * grid.index_to_world;
    double sum = 0;
    Vec3d middle;
    for (const Brick& b : grid.bricks) {
      for (int n = 0; n < kBrickSamples; ++n) {
        const Vec3d at(b.origin + Vec3i{n / 64, n / 8 % 8, n % 8});
        sum += double(b.values[n]);
        middle += place.point(at) * double(b.values[n]);
      }
    }
    EXPECT_NEAR(sum * std::abs(determinant(place)) / volume, i == 0 ? 1 : 0.5, 1e-3);
    expect_near(middle / sum, mirrored(i == 0 ? Vec3d{1, 2, 3} : Vec3d{6, 2, 4}), 1e-3);
  }
  EXPECT_TRUE(says(notes_of(s), "pbrt.medium_f_inside"));
}

TEST(PbrtScene, PresetsAreMatterByName) {
  const auto ball_of = [](const std::string& preset) {
    return kPbrtFog +
           "MakeNamedMedium \"b\" \"string type\" \"homogeneous\" \"float scale\" 10 \"rgb "
           "sigma_s\" "
           "[ 9 9 9 ] \"string preset\" \"" +
           preset + "\"\nMediumInterface \"b\" \"\" Material \"interface\" Shape \"sphere\"";
  };
  const PbrtScene s = scene_of("", ball_of("Ketchup"));
  const Medium& m = s.file.volumes.at(1).medium;
  EXPECT_NEAR(m.extinction, 14.8, 1e-5);  // 10 (0.03 + 1.45) in blue
  expect_near(Vec3d(m.extinction_color), {0.241 / 1.48, 1.04 / 1.48, 1});
  expect_near(Vec3d(m.components.front().albedo), {0.18 / 0.241, 0.07 / 1.04, 0.03 / 1.48});
  const PbrtScene other = scene_of("", ball_of("Coke"));
  EXPECT_EQ(other.file.volumes.size(), 1u);
  EXPECT_TRUE(says(notes_of(other), "pbrt.preset_coke"));
}

TEST(PbrtScene, ShapesThatCutMediaOffAreNamed) {
  EXPECT_EQ(times_said(notes_of(scene_of("")), "pbrt.sphere_cuts_off"), 0);
  const std::string small =
      "AttributeBegin Material \"interface\" MediumInterface \"fog\" \"\"\n"
      "Shape \"sphere\" \"float radius\" .8 AttributeEnd";
  EXPECT_TRUE(says(notes_of(scene_of(small)), "pbrt.sphere_cuts_off"));
  const std::string large =
      "AttributeBegin Material \"interface\" MediumInterface \"fog\" \"\"\n"
      "Shape \"sphere\" \"float radius\" 1.8 AttributeEnd";
  EXPECT_EQ(times_said(notes_of(scene_of(large)), "pbrt.sphere_cuts_off"), 0);
}

TEST(PbrtScene, ShapesWithAnotherMediumInsideAreNamed) {
  const std::string ball =
      kPbrtFog + "MakeNamedMedium \"b\" \"string type\" \"uniformgrid\" \"float density\" 1\n";
  const auto notes = [&](const std::string& sides, const std::string& material) {
    return notes_of(scene_of("", ball + "MediumInterface " + sides + " Material \"" + material +
                                     "\" Shape \"sphere\" \"float radius\" .1"));
  };
  EXPECT_TRUE(says(notes("\"b\" \"fog\"", "interface"), "pbrt.medium_nested"));
  EXPECT_TRUE(says(notes("\"\" \"fog\"", "interface"), "pbrt.medium_with_hole"));
  EXPECT_EQ(times_said(notes("\"\" \"fog\"", "diffuse"), "pbrt.medium_with_hole"), 0);
  EXPECT_EQ(times_said(notes("\"fog\" \"fog\"", "interface"), "pbrt.medium_with_hole"), 0);
}

TEST(PbrtScene, AMediumOnBothSidesOfItsShapesIsLeftOut) {
  const std::string both =
      kPbrtFog +
      "MakeNamedMedium \"b\" \"string type\" \"uniformgrid\" \"float density\" 1\n"
      "MediumInterface \"b\" Material \"interface\" Shape \"sphere\"";
  const PbrtScene s = scene_of("", both);
  EXPECT_EQ(s.file.volumes.size(), 1u);
  EXPECT_TRUE(says(notes_of(s), "pbrt.medium_on_both_sides"));
}

TEST(PbrtScene, SurfacesOfEachKind) {
  const PbrtScene s = scene_of(
      "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [ .8 .1 .1 ]\n"
      "AttributeBegin NamedMaterial \"red\" Translate 1 2 3 Scale 2 2 2 Shape \"sphere\" \"float "
      "radius\" .5 AttributeEnd\n"
      "AttributeBegin Material \"conductor\" Translate 0 0 1 Shape \"trianglemesh\" \"point3 P\" [ "
      "0 "
      "0 0 1 0 0 0 1 0 ] Shape \"disk\" \"float radius\" 2 AttributeEnd\n"
      "AttributeBegin Scale 1 2 1 Shape \"sphere\" AttributeEnd Shape \"curve\"");
  ASSERT_EQ(s.file.scene.surfaces.size(), 2u);
  const auto& ball = std::get<BallSurface>(s.file.scene.surfaces[0]);
  expect_near(ball.centre, mirrored({1, 2, 3}));
  EXPECT_DOUBLE_EQ(ball.radius, 1);
  expect_near(Vec3d(ball.material.albedo), {0.8, 0.1, 0.1});
  const auto& mesh = std::get<MeshSurface>(s.file.scene.surfaces[1]);  // all of 0.5
  EXPECT_EQ(mesh.file, "out_mesh1.ply");
  ASSERT_EQ(s.meshes.size(), 1u);
  expect_near(s.meshes[0].mesh.vertices.at(1), mirrored({1, 0, 1}));
  double area = 0, highest = 0;  // of the disk, which follows one triangle and is 96 by 1
  const TriangleMesh& all = s.meshes[0].mesh;
  for (std::size_t i = 1; i < 1 + 2 * 96; ++i) {
    const auto& t = all.triangles.at(i);
    const Vec3d a = all.vertices[t[0]];
    area += length(cross(all.vertices[t[1]] - a, all.vertices[t[2]] - a)) / 2;
  }
  for (const Vec3d v : all.vertices) highest = std::max(highest, v.y);
  EXPECT_NEAR(area, 4 * std::numbers::pi, 0.02);
  EXPECT_NEAR(highest, 2, 1e-9);  // the stretched sphere, and the disk's rim
  EXPECT_TRUE(says(notes_of(s), "pbrt.material_conductor_diffuse"));
  EXPECT_TRUE(says(notes_of(s), "pbrt.shapes_type_curve"));
}

TEST(PbrtScene, MaterialsMayBeMadeAfterTheShapesThatNameThem) {
  const PbrtScene s = scene_of(
      "NamedMaterial \"unused\" NamedMaterial \"late\" Shape \"sphere\"\n"
      "AttributeBegin Material \"diffuse\" Shape \"sphere\" AttributeEnd Shape \"sphere\"\n"
      "MakeNamedMaterial \"late\" \"string type\" \"diffuse\" \"rgb reflectance\" [ .8 .1 .1 ]");
  ASSERT_EQ(s.file.scene.surfaces.size(), 3u);
  for (const std::size_t i : {0u, 1u, 2u}) {
    const auto& ball = std::get<BallSurface>(s.file.scene.surfaces[i]);
    expect_near(Vec3d(ball.material.albedo), i == 1 ? Vec3d(0.5) : Vec3d{0.8, 0.1, 0.1});
  }
}

TEST(PbrtScene, FilmSamplerFilterAndDepth) {
  const PbrtScene s = read_pbrt_text(
      pbrt_text(kCamera +
                "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 \"float "
                "cropwindow\" [ .25 .5 0 .3 ] \"float iso\" 400\nSampler \"halton\" \"integer "
                "pixelsamples\" 7\nPixelFilter \"box\" \"float xradius\" 1 \"float yradius\" 1\n"
                "Integrator \"volpath\" \"integer maxdepth\" 12\n"));
  const RenderOptions& o = s.file.scene.options;
  EXPECT_EQ(o.width, 200);
  EXPECT_EQ(o.height, 100);
  EXPECT_EQ(o.crop_x, 50);
  EXPECT_EQ(o.crop_width, 50);
  EXPECT_EQ(o.crop_y, 0);
  EXPECT_EQ(o.crop_height, 30);
  EXPECT_EQ(o.samples, 7u);
  EXPECT_EQ(o.filter, PixelFilter::box);
  EXPECT_EQ(o.filter_width, 2);
  EXPECT_EQ(o.max_bounces, 12u);
  EXPECT_TRUE(says(notes_of(s), "pbrt.sensor_factor_left"));
  const RenderOptions usual = scene_of("").file.scene.options;
  EXPECT_EQ(usual.width, 1280);
  EXPECT_EQ(usual.samples, 16u);
  EXPECT_EQ(usual.max_bounces, 5u);
  const PbrtScene deep = scene_of("Integrator \"volpath\" \"integer maxdepth\" 100000\n");
  EXPECT_EQ(deep.file.scene.options.max_bounces, std::nullopt);
  EXPECT_TRUE(says(notes_of(deep), "pbrt.depth_is_no_limit"));
  EXPECT_EQ(usual.filter, PixelFilter::gaussian);
  EXPECT_EQ(usual.filter_width, 3);
}

TEST(PbrtScene, WhatIsNotMappedIsNamedOnceWithItsLine) {
  const PbrtScene s = scene_of(
      "LightSource \"goniometric\"\nLightSource \"goniometric\"\nLightSource \"point\" \"float "
      "colour\" 1"
      "\nObjectBegin \"tree\" Shape \"sphere\" ObjectEnd ObjectInstance \"tree\"",
      kPbrtFog + "MakeNamedMedium \"c\" \"string type\" \"cloud\"\n");
  EXPECT_TRUE(says(notes_of(s), "pbrt.lights_type_goniometric"));
  EXPECT_EQ(times_said(notes_of(s), "pbrt.lights_type_goniometric"), 1);
  EXPECT_TRUE(says(notes_of(s), "pbrt.point_light_colour"));
  EXPECT_TRUE(says(notes_of(s), "pbrt.instances_object_tree"));
  EXPECT_TRUE(says(notes_of(s), "pbrt.medium_c_left"));
}

TEST(PbrtScene, WithoutAMediumIsAnError) {
  const std::string why = error_of([] {
    (void)scene_of("",
                   "MakeNamedMedium \"c\" \"string type\" \"cloud\"\nMediumInterface \"c\" \"\" "
                   "Shape \"sphere\"");
  });
  EXPECT_TRUE(says(why, "pbrt.no_medium_renders"));
  EXPECT_TRUE(says(why, "pbrt.medium_c_left_out_media"));
}

TEST(PbrtScene, FilesAreWrittenThatReadBackAsTheScene) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.pbrt"),
              pbrt_text(kCamera,
                        "LightSource \"point\" Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 "
                        "0 0 0 1 0 ]"));
  const PbrtScene scene = read_pbrt(folder.file("a.pbrt"), "b");
  write_imported(folder.file("b.toml"), scene);
  const SceneFile back = read_scene(folder.file("b.toml"));
  SceneFile expected = scene.file;
  expected.volumes.front().file = folder.file("b_fog.vdb");
  std::get<MeshSurface>(expected.scene.surfaces.front()).file = folder.file("b_mesh1.ply").string();
  EXPECT_EQ(to_toml(back), to_toml(expected));
  EXPECT_TRUE(std::filesystem::exists(folder.file("b_mesh1.ply")));
  EXPECT_EQ(read_vdb(folder.file("b_fog.vdb")).report.largest, 8);
}

TEST(PbrtScene, WritingReplacesOnlyWhatEarlierWritingLeft) {
  const TemporaryFolder folder;
  const std::string sky = "LightSource \"infinite\" \"string filename\" \"sky.exr\"\n";
  write_sky(folder.file("sky.exr"), 8);
  const auto write = [&](const std::string& after, const std::string& stem) {
    write_bytes(folder.file("a.pbrt"), pbrt_text(kCamera, after));
    write_imported(folder.file(stem + ".toml"), read_pbrt(folder.file("a.pbrt"), stem));
  };
  write(sky, "b");
  write(sky, "b");
  write("", "b");  // which leaves the picture of the sky behind
  write(sky, "b");
  std::filesystem::remove(folder.file("b.toml"));
  EXPECT_TRUE(says(error_of([&] { write(sky, "b"); }), "pbrt.fog_is_there"));
  write_bytes(folder.file("c_fog.vdb"), "mine");
  EXPECT_THROW(write(sky, "c"), std::runtime_error);
  EXPECT_EQ(read_bytes(folder.file("c_fog.vdb")), "mine");
  EXPECT_FALSE(std::filesystem::exists(folder.file("c_sky.exr")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("c.toml")));
}

TEST(PbrtScene, WritingReplacesNothingThatTheSceneRefersTo) {
  const TemporaryFolder folder;
  write_sky(folder.file("b_sky.exr"), 8);
  write_bytes(folder.file("b_mesh1.ply"), "ply");
  // As if an earlier conversion had written them.
  write_bytes(folder.file("b.toml"),
              "# Written beside it: b_sky.exr\n# Written beside it: b_mesh1.ply\n");
  const auto fault = [&](const std::string& after) {
    const std::string before = read_bytes(folder.file("b_sky.exr"));
    write_bytes(folder.file("a.pbrt"), pbrt_text(kCamera, after));
    const PbrtScene scene = read_pbrt(folder.file("a.pbrt"), "b");
    std::string message = error_of([&] { write_imported(folder.file("b.toml"), scene); });
    EXPECT_EQ(read_bytes(folder.file("b_mesh1.ply")), "ply");
    EXPECT_TRUE(read_bytes(folder.file("b_sky.exr")) == before);
    EXPECT_FALSE(std::filesystem::exists(folder.file("b_fog.vdb")));
    return message;
  };
  EXPECT_TRUE(says(fault("LightSource \"infinite\" \"string filename\" \"b_sky.exr\""),
                   "pbrt.sky_is_read"));
  const std::string triangle = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n";
  const std::string file = "Shape \"plymesh\" \"string filename\" \"b_mesh1.ply\"\n";
  EXPECT_TRUE(says(fault(triangle + file), "pbrt.mesh_is_read"));
  EXPECT_TRUE(says(fault(triangle + "Material \"interface\" " + file), "pbrt.mesh_is_read"));
}

TEST(PbrtScene, WhereWritingFailsNothingStays) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.pbrt"), pbrt_text(kCamera));
  std::filesystem::create_directory(folder.file("b.toml"));
  const PbrtScene scene = read_pbrt(folder.file("a.pbrt"), "b");
  EXPECT_THROW(write_imported(folder.file("b.toml"), scene), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("b_fog.vdb")));
}

}  // namespace pbrt_scene_test
}  // namespace pvol::formats
