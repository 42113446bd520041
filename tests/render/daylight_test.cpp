// What scenes see of a clear sky: directions, colours, keys, and the lights that come of it.
#include "pvol/render/daylight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/error.h"
#include "pvol/render/lighting.h"
#include "pvol/render/lights.h"
#include "pvol/render/render.h"
#include "support/lit_scenes.h"
#include "support/statistics.h"

namespace pvol {
namespace daylight_test {

using std::numbers::pi;
constexpr double kDegree = pi / 180;

ClearSky low_sun(double elevation, double azimuth = 0) {
  ClearSky sky;
  sky.elevation = elevation, sky.azimuth = azimuth;
  return sky;
}

SkyPicture picture_of(const ClearSky& sky) {
  return SkyPicture(make_daylight(sky).picture, SkyPixels::smooth);
}

/// Of the usual frame: north is -z, east +x.
Vec3f towards(double elevation, double azimuth) {
  const double e = elevation * kDegree, a = azimuth * kDegree;
  return Vec3f(Vec3d(std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a)));
}

void expect_near(Vec3d a, Vec3d b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

TEST(Daylight, TheSunStandsWhereItIsSaidToBe) {
  expect_near(make_daylight(low_sun(0, 0)).sun.direction, {0, 0, -1}, 1e-12);
  expect_near(make_daylight(low_sun(0, 90)).sun.direction, {1, 0, 0}, 1e-12);
  expect_near(make_daylight(low_sun(0, -90)).sun.direction, {-1, 0, 0}, 1e-12);
  expect_near(make_daylight(low_sun(90, 12)).sun.direction, {0, 1, 0}, 1e-12);
  ClearSky z_up = low_sun(0, 90);
  z_up.up = {0, 0, 2}, z_up.north = {0, 3, 1};
  expect_near(make_daylight(z_up).sun.direction, {1, 0, 0}, 1e-12);
  z_up.azimuth = 0;
  const Daylight north = make_daylight(z_up);
  expect_near(north.sun.direction, {0, 1, 0}, 1e-12);
  EXPECT_EQ(north.sun.angle, 0.53);
}

/// Where no gamut cuts anything off, the same light by other primaries: blue skies and suns lie
/// within all of them.
TEST(Daylight, HasTheSameColoursInEverySpace) {
  const Daylight usual = make_daylight(low_sun(35));
  const Daylight aces = make_daylight(low_sun(35), ColorSpace::acescg);
  const Affine map = conversion(ColorSpace::rec709, ColorSpace::acescg);
  const auto expect_same = [&](Rgb a, Rgb b) {
    const Vec3d wanted = map.vector(Vec3d(a));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(b[c]), wanted[c], 1e-5 * max_component(wanted));
  };
  expect_same(usual.sun.irradiance, aces.sun.irradiance);
  for (std::size_t i = 0; i < usual.picture.pixels.size(); i += 997) {
    if (min_component(usual.picture.pixels[i]) > 0) {
      expect_same(usual.picture.pixels[i], aces.picture.pixels[i]);
    }
  }
  Scene scene;
  scene.environment = low_sun(35);
  scene.options.color_space = ColorSpace::acescg;
  EXPECT_EQ(std::get<Sun>(make_lighting(scene).lights.back()), aces.sun);
}

TEST(Daylight, TheDateTellsWhereTheSunIs) {
  ClearSky sky;
  sky.date = "2003-10-17T12:30:30-07:00", sky.latitude = 39.742476, sky.longitude = -105.1786;
  const SunPosition seen = sun_of(sky);
  EXPECT_NEAR(seen.elevation, 90 - 50.11162, 0.02);  // in air a little thinner
  EXPECT_NEAR(seen.azimuth, 194.34024, 0.01);
  EXPECT_EQ(sun_of(ClearSky{}).elevation, 37);
}

TEST(Daylight, TheSkyIsBrightestAboutTheSun) {
  for (const double azimuth : {10.0, 100.0, 260.0}) {
    const SkyPicture sky = picture_of(low_sun(25, azimuth));
    const float beside = luminance(sky.radiance(towards(25, azimuth)));
    for (const double other : {40.0, 90.0, 180.0, 270.0, 320.0}) {
      EXPECT_LT(luminance(sky.radiance(towards(25, azimuth + other))), 0.6f * beside) << other;
    }
    // The two sides are alike.
    const Rgb left = sky.radiance(towards(30, azimuth - 50)),
              right = sky.radiance(towards(30, azimuth + 50));
    expect_near(Vec3d(left), Vec3d(right), 1e-3 * double(luminance(left)));
  }
}

TEST(Daylight, FramesTurnTheSkyWithThem) {
  ClearSky y_up = low_sun(20, 130), z_up = y_up;
  z_up.up = {0, 0, 1}, z_up.north = {0, 1, 0};
  const SkyPicture a = picture_of(y_up), b = picture_of(z_up);
  for (const double elevation : {-40.0, 1.0, 10.0, 35.0, 80.0}) {
    for (double azimuth = 3; azimuth < 360; azimuth += 37) {
      const Vec3f d = towards(elevation, azimuth), turned(d.x, -d.z, d.y);
      const Rgb one = a.radiance(d), other = b.radiance(turned);
      expect_near(Vec3d(one), Vec3d(other), 1e-4 * double(luminance(one)));
    }
  }
  expect_near(make_daylight(z_up).sun.direction,
              Vec3d(Vec3f(towards(20, 130).x, -towards(20, 130).z, towards(20, 130).y)), 1e-6);
}

TEST(Daylight, HasItsColours) {
  const auto zenith = [](const ClearSky& sky) { return picture_of(sky).radiance({0, 1, 0}); };
  const Rgb day = zenith(low_sun(40));
  EXPECT_GT(day.z, 1.4f * day.y);
  EXPECT_GT(day.y, day.x);
  // At sunset the sun is red, and ozone keeps the zenith blue.
  const Rgb low = make_daylight(low_sun(2)).sun.irradiance;
  EXPECT_GT(low.x, 3 * low.y);
  EXPECT_GT(low.y, 3 * low.z);
  const Rgb high = make_daylight(low_sun(60)).sun.irradiance;
  EXPECT_LT(high.x, 1.5f * high.z);
  ClearSky without = low_sun(-3);
  without.ozone = 0;
  const Rgb blue = zenith(low_sun(-3)), grey = zenith(without);
  EXPECT_GT(blue.z / blue.x, 1.4f * grey.z / grey.x);
  // Haze makes a white glare about a dimmer sun.
  ClearSky hazy = low_sun(40);
  hazy.turbidity = 8;
  const Rgb glare = zenith(hazy);
  EXPECT_LT(glare.z / glare.x, 0.6f * day.z / day.x);
  EXPECT_LT(luminance(make_daylight(hazy).sun.irradiance),
            0.6f * luminance(make_daylight(low_sun(40)).sun.irradiance));
}

TEST(Daylight, IsAsBrightAsTheUsualSun) {
  const float direct = luminance(make_daylight(ClearSky{}).sun.irradiance);
  EXPECT_NEAR(direct, 3, 0.4);
}

TEST(Daylight, ScalesWithTheIrradiance) {
  ClearSky sky = low_sun(15);
  const Daylight one = make_daylight(sky);
  sky.irradiance *= 16;
  const Daylight many = make_daylight(sky);
  EXPECT_EQ(many.sun.irradiance, one.sun.irradiance * 16.0f);
  for (std::size_t i = 0; i < one.picture.pixels.size(); i += 997) {
    expect_near(Vec3d(many.picture.pixels[i]), Vec3d(one.picture.pixels[i] * 16.0f), 1e-5);
  }
}

TEST(Daylight, TheGroundReflectsWhatFallsOnIt) {
  ClearSky sky = low_sun(30);
  sky.ground = {0.5f, 0.25f, 0.1f};
  const Daylight day = make_daylight(sky);
  const SkyPicture picture(day.picture, SkyPixels::smooth);
  Vec3d fallen = Vec3d(day.sun.irradiance) * std::sin(30 * kDegree);
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double s = std::sqrt((i + 0.5) / kSteps), turn = 2 * pi * (j + 0.5) / kSteps;
      const Vec3d d(std::sqrt(1 - s * s) * std::cos(turn), s,
                    std::sqrt(1 - s * s) * std::sin(turn));
      fallen += Vec3d(picture.radiance(Vec3f(d))) * (pi / (kSteps * kSteps));
    }
  }
  const Rgb seen = picture.radiance(towards(-20, 77));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(double(seen[c]), double(sky.ground[c]) * fallen[c] / pi, 2e-3 * double(seen[c]));
  }
  EXPECT_EQ(picture.radiance(towards(-1, 5)), seen);
  ClearSky snow = sky;
  snow.ground = Rgb(0.9f);
  EXPECT_GT(luminance(picture_of(snow).radiance({0, 1, 0})),
            1.1f * luminance(picture.radiance({0, 1, 0})))
      << "snow lights the air";
}

TEST(Daylight, FadesThroughDuskIntoNight) {
  double before = 1e9;
  for (const double elevation : {5.0, 0.3, -0.3, -3.0, -8.0, -12.0, -17.9}) {
    const Daylight day = make_daylight(low_sun(elevation));
    const double now = double(luminance(day.picture.pixels[0]));
    EXPECT_LT(now, before) << elevation;
    EXPECT_GT(now, 0) << elevation;
    EXPECT_EQ(luminance(day.sun.irradiance) > 0, elevation > -0.265) << elevation;
    before = now;
  }
  EXPECT_LT(before, 1e-4);
  const double step = double(luminance(make_daylight(low_sun(-0.01)).picture.pixels[0])) /
                      double(luminance(make_daylight(low_sun(0.01)).picture.pixels[0]));
  EXPECT_NEAR(step, 1, 0.02);
  const SkyLight night(Environment{low_sun(-40)});
  EXPECT_FALSE(night.sampled());
  EXPECT_EQ(night.radiance({0.6f, 0.8f, 0}), Rgb(0.0f));
  // Where the air is solved on another grid nothing jumps.
  const Rgb high = picture_of(low_sun(20.01)).radiance(towards(50, 60)),
            lower = picture_of(low_sun(19.99)).radiance(towards(50, 60));
  expect_near(Vec3d(high), Vec3d(lower), 5e-3 * double(luminance(high)));
}

TEST(Daylight, IsLightAtAllExtremes) {
  std::size_t turn = 0;
  for (const double elevation : {90.0, 1e-9, -17.0, -90.0}) {
    ++turn;  // on a commit every two extremes together, not every three
    for (const double turbidity : {1.0, 20.0}) {
      for (const double ozone : {0.0, 1000.0}) {
        if (!proof::has_turn(turn + (turbidity > 1) + (ozone > 0))) continue;
        ClearSky sky = low_sun(elevation, 359);
        sky.turbidity = turbidity, sky.ozone = ozone, sky.irradiance = 1e29;
        sky.ground = Rgb(turbidity > 1 ? 1.0f : 0.0f);
        EXPECT_NO_THROW(validate(Environment(sky)));
        const Daylight day = make_daylight(sky);
        EXPECT_NO_THROW(validate(Environment(day.picture))) << elevation << ' ' << turbidity;
        EXPECT_NO_THROW(validate(Light(day.sun)));
      }
    }
  }
}

TEST(Daylight, WhatDoesNotFitIsRefused) {
  const auto refused = [](const auto& change) {
    ClearSky sky;
    change(sky);
    EXPECT_THROW(validate(Environment(sky)), Error);
  };
  EXPECT_NO_THROW(validate(Environment(ClearSky{})));
  refused([](ClearSky& s) { s.elevation = 91; });
  refused([](ClearSky& s) { s.azimuth = NAN; });
  refused([](ClearSky& s) { s.turbidity = 0.9; });
  refused([](ClearSky& s) { s.turbidity = 21; });
  refused([](ClearSky& s) { s.ozone = -1; });
  refused([](ClearSky& s) { s.ground = {0, 1.1f, 0}; });
  refused([](ClearSky& s) { s.irradiance = -1; });
  refused([](ClearSky& s) { s.up = Vec3d(0.0); });
  refused([](ClearSky& s) { s.north = {0, -3, 0}; });
  refused([](ClearSky& s) { s.date = "yesterday", s.latitude = 1, s.longitude = 2; });
  refused([](ClearSky& s) { s.date = "2024-06-21T12:00Z"; });
  refused([](ClearSky& s) { s.date = "2024-06-21T12:00Z", s.latitude = 1; });
  refused([](ClearSky& s) { s.latitude = 1, s.longitude = 2; });
  refused([](ClearSky& s) {
    s.date = "2024-06-21T12:00Z", s.latitude = 1, s.longitude = 2, s.elevation = 3;
  });
}

TEST(SmoothPicture, IsContinuousButForTheHorizon) {
  const SkyPicture sky = picture_of(low_sun(12, 30));
  for (const double azimuth : {0.0, 30.0, 210.0, 359.9}) {
    Rgb before = sky.radiance(towards(0.05, azimuth));
    for (double e = 0.07; e < 90; e += 0.02) {
      const Rgb now = sky.radiance(towards(e, azimuth));
      EXPECT_NEAR(now.y, before.y, 0.02f * before.y) << e;
      before = now;
    }
  }
  Rgb before = sky.radiance(towards(8, 0));
  for (double azimuth = 0; azimuth < 361; azimuth += 0.05) {
    const Rgb now = sky.radiance(towards(8, azimuth));
    EXPECT_NEAR(now.y, before.y, 0.02f * before.y) << azimuth;
    before = now;
  }
  EXPECT_EQ(sky.radiance(towards(-0.01, 4)), sky.radiance(towards(-80, 200)));
}

TEST(SmoothPicture, DensitiesIntegrateToOneAndSamplesAreThere) {
  const SkyPicture sky = picture_of(low_sun(12, 30));
  ASSERT_TRUE(sky.sampled());
  const Vec3d n = normalize(Vec3d(0.3, 0.5, -0.8));
  double whole = 0, flux = 0, luminous = 0;
  constexpr int kRows = 1440, kColumns = 1440;
  for (int y = 0; y < kRows; ++y) {
    const double c = 1 - 2 * (y + 0.5) / kRows, s = std::sqrt(1 - c * c);
    for (int x = 0; x < kColumns; ++x) {
      const double turn = 2 * pi * (x + 0.5) / kColumns;
      const Vec3d d(s * std::cos(turn), c, s * std::sin(turn));
      const double area = 4 * pi / (double(kRows) * kColumns);
      const double l = double(luminance(sky.radiance(Vec3f(d))));
      whole += double(sky.pdf(Vec3f(d))) * area;
      flux += std::max(dot(d, n), 0.0) * l * area;
      luminous += l * area;
    }
  }
  EXPECT_NEAR(whole, 1, 1e-3);
  EXPECT_NEAR(double(sky.mean_luminance()) * 4 * pi / luminous, 1, 0.05);
  proof::Moments m;
  int misplaced = 0;
  for (int i = 0; i < 200'000; ++i) {
    Rng rng(5, 0, std::uint64_t(i));
    const LightSample l = sky.sample(rng);
    ASSERT_GT(l.pdf, 0);
    const Rgb there = sky.radiance(l.direction);
    misplaced += std::abs(luminance(there) - luminance(l.radiance)) > 1e-3f * luminance(there);
    misplaced += std::abs(l.pdf / sky.pdf(l.direction) - 1) > 1e-5f;
    m.add(std::max(dot(Vec3d(l.direction), n), 0.0) * double(luminance(l.radiance) / l.pdf));
  }
  EXPECT_LE(misplaced, 20) << "at borders of pixels alone";
  EXPECT_GT(proof::mean_p_value(m, flux, 1e-3 * flux), 1e-4);
  // It is sampled well: by luminance, estimates of all light hardly vary.
  EXPECT_LT(std::sqrt(m.variance()) / m.mean(), 1.2);
}

TEST(Lighting, AddsTheSunOfAClearSkyToTheLights) {
  Scene scene;
  scene.lights = {PointLight{}, Sun{}};
  EXPECT_EQ(make_lighting(scene).lights, scene.lights);
  EXPECT_EQ(most_lights(scene), 2u);
  ClearSky sky = low_sun(20, 90);
  scene.environment = sky;
  const Lighting all = make_lighting(scene);
  ASSERT_EQ(all.lights.size(), 3u);
  EXPECT_EQ(most_lights(scene), 3u);
  EXPECT_EQ(all.lights[0], scene.lights[0]);
  EXPECT_EQ(std::get<Sun>(all.lights[2]), make_daylight(sky).sun);
  sky.sun = false;
  scene.environment = sky;
  EXPECT_EQ(make_lighting(scene).lights, scene.lights);
  EXPECT_TRUE(make_lighting(scene).sky.sampled());
}

TEST(Lighting, ItsSunHasALayerAndLightsTheCloud) {
  test::CloudScene s = test::sunny();
  s.lights = {Sun{{0, 1, 0}, Rgb(0.5f), 0}};
  s.environment = low_sun(20, 90);
  s.options.aovs.add(Aov::lights);
  const Volume v = test::volume_of(s);
  const RenderResult r = render(v, s.scene());
  std::vector<std::string> names;
  double sums[4] = {};
  for (const Layer& layer : r.film.layers) {
    if (names.size() < 4) {
      for (const Vec3d& p : layer.sums) sums[names.size()] += p.y;
    }
    names.push_back(layer.name);
  }
  ASSERT_GE(names.size(), 3u);
  EXPECT_EQ(names[0], "sun_1");
  EXPECT_EQ(names[1], "sun_2");
  EXPECT_EQ(names[2], "sky");
  for (int i = 0; i < 3; ++i) EXPECT_GT(sums[i], 0) << i;
  // Without its disc the same scene lacks that part.
  ClearSky dim = low_sun(20, 90);
  dim.sun = false;
  s.environment = dim;
  double with = 0, without = 0;
  for (const PixelSums& p : r.film.pixels) with += p.sum.y;
  const RenderResult other = render(v, s.scene());
  for (const PixelSums& p : other.film.pixels) without += p.sum.y;
  EXPECT_NEAR((with - sums[1]) / without, 1, 0.05);
}

}  // namespace daylight_test
}  // namespace pvol
