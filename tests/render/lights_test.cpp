// Suns and skies: what is sampled is what is there, at the density that is claimed.
#include "pvol/render/lights.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "pvol/volume/phase.h"
#include "render/light/smooth_luminance.h"
#include "support/sky_pictures.h"
#include "support/statistics.h"

namespace pvol {
namespace lights_test {

using proof::Family;
using proof::Histogram;
using proof::Moments;
using std::numbers::pi;
using test::make_picture, test::noise_picture, test::pictures, test::set;
using Picture = test::TestSky;

constexpr int kSamples = 200'000;
constexpr double kAngles[] = {0.01, 0.1, 0.53, 5, 30, 90, 170};  // diameters of suns, degrees
const Rgb kIrradiance{3, 2, 0.5f};

Sun make_sun(double angle, Vec3d direction = {-1, 3, 2}) { return {direction, kIrradiance, angle}; }

constexpr auto kAnywhere = [] { return Vec3d(0.0); };

bool hit(const SunLight& sun, Vec3f d) { return max_component(sun.seen(d)) > 0; }

/// 1 - cos of the sun's radius.
double exact_cap(double angle) {
  const double s = std::sin(angle / 4 * pi / 180);
  return 2 * s * s;
}

double one_minus_cos_exact(Vec3f a, Vec3f b) {
  const Vec3d d = Vec3d(a) - Vec3d(b);
  return 0.5 * dot(d, d);
}

double cosine(Vec3f a, Vec3f b) { return 1 - one_minus_cos_exact(a, b); }

/// A direction at 1 - cos = c from n, computed in double.
Vec3f tilted(Vec3d n, double c, double azimuth) {
  Vec3d s, t;
  orthonormal_basis(n, s, t);
  const double sine = std::sqrt(c * (2 - c));
  return Vec3f(s * (sine * std::cos(azimuth)) + t * (sine * std::sin(azimuth)) + n * (1 - c));
}

TEST(SunLight, HasItsSolidAngleAsDensity) {
  for (const double angle : kAngles) {
    const SunLight sun(make_sun(angle));
    EXPECT_GT(sun.disc_pdf, 0);
    EXPECT_NEAR(double(sun.disc_pdf) * 2 * pi * exact_cap(angle), 1, 1e-6) << angle;
    EXPECT_NEAR(length(Vec3d(sun.direction)), 1, 1e-7);
  }
}

TEST(SunLight, DiscIntegratesToTheGivenIrradiance) {
  // Sum of radiance x cos over the directions that hit, by rings of equal solid angle.
  constexpr int kRings = 20'000;
  for (const double angle : kAngles) {
    const SunLight sun(make_sun(angle));
    const Vec3d n = normalize(Vec3d{-1, 3, 2});
    const double wide = std::min(2.0, 1.5 * exact_cap(angle)), ring = wide / kRings;
    double sum = 0;
    for (int i = 0; i < kRings; ++i) {
      const double c = (i + 0.5) * ring;
      if (hit(sun, tilted(n, c, i * 0.7))) sum += (1 - c) * 2 * pi * ring;
    }
    // hit() sees directions in float: the disc's edge is blurred by 1e-7 of an angle.
    const double radius = angle / 2 * pi / 180, blur = 2e-4 + 2e-7 / radius;
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(sum * double(sun.disc_radiance[i]) / double(kIrradiance[i]), 1, blur) << angle;
    }
  }
}

TEST(SunLight, SamplesFillTheDiscEvenlyAndCarryTheIrradiance) {
  Family family;
  for (const double angle : kAngles) {
    const SunLight sun(make_sun(angle));
    const double cap = exact_cap(angle);
    const auto name = [&](const char* what) { return what + (" " + std::to_string(angle)); };
    Rng rng(proof::seeded(31), std::uint64_t(angle * 100), 0);
    Moments irradiance;
    Histogram area(32), azimuth(32);
    const Vec3d n(sun.direction), s = normalize(cross(n, Vec3d{0, 0, 1})), t = cross(n, s);
    for (int i = 0; i < kSamples; ++i) {
      const LightSample l = sun.sample(kAnywhere, rng);
      ASSERT_EQ(l.pdf, sun.disc_pdf);
      ASSERT_EQ(l.radiance, sun.disc_radiance);
      const double c = one_minus_cos_exact(l.direction, sun.direction);
      const double rounding = 3e-7 * std::sqrt(2 * cap) + 1e-13;
      ASSERT_LE(c, cap + rounding);
      ASSERT_TRUE(hit(sun, l.direction) || c >= cap - rounding) << c / cap;
      irradiance.add(double(l.radiance.x / l.pdf) * cosine(l.direction, sun.direction));
      area.add(std::min(c / cap, 1.0));
      azimuth.add(0.5 +
                  std::atan2(dot(t, Vec3d(l.direction)), dot(s, Vec3d(l.direction))) / (2 * pi));
    }
    family.add(name("irradiance"), proof::mean_p_value(irradiance, double(kIrradiance.x), 1e-6));
    family.add(name("area"), area.uniform_p_value());
    family.add(name("azimuth"), azimuth.uniform_p_value());
  }
  EXPECT_TRUE(family.passes());
}

TEST(SunLight, HitIsTheDiscAndNothingElse) {
  for (const double angle : kAngles) {
    for (const Vec3d toward : {Vec3d{0, 1, 0}, Vec3d{0, 0, -5}, Vec3d{1e-3, 1e-3, 1e-3}}) {
      const SunLight sun(make_sun(angle, toward));
      const double cap = exact_cap(angle);
      const double margin = 1e-3 + 2e-7 / std::sqrt(cap);
      EXPECT_TRUE(hit(sun, sun.direction));
      EXPECT_FALSE(hit(sun, -sun.direction));
      for (int i = 0; i < 100; ++i) {
        const Vec3d n = normalize(toward);
        EXPECT_TRUE(hit(sun, tilted(n, cap * (1 - margin), i))) << angle;
        EXPECT_FALSE(hit(sun, tilted(n, cap * (1 + margin), i))) << angle;
      }
    }
  }
}

TEST(SunLight, OfNoExtentIsOneDirection) {
  // From exactly 0 up to discs that float directions cannot resolve, whose density may overflow.
  for (const double angle : {0.0, 1e-300, 1e-18, 1e-6}) {
    const SunLight sun(make_sun(angle));
    Rng rng(32, 0, 0);
    const LightSample l = sun.sample(kAnywhere, rng);
    EXPECT_EQ(sun.disc_pdf, 0) << angle;
    EXPECT_EQ(l.direction, sun.direction);
    EXPECT_EQ(l.radiance, kIrradiance);
    EXPECT_EQ(l.pdf, 0);
    EXPECT_FALSE(hit(sun, sun.direction)) << "no ray meets a delta light by chance";
    EXPECT_EQ(sun.disc_radiance, Rgb(0.0f));
  }
  EXPECT_GT(SunLight(make_sun(1e-4)).disc_pdf, 0);
}

TEST(SunLight, RadianceAndDensityAreFiniteOverAllAngles) {
  for (double angle = 1e-10; angle < 180; angle *= 1.5) {
    const SunLight sun(make_sun(angle));
    EXPECT_TRUE(is_finite(sun.disc_radiance) && std::isfinite(sun.disc_pdf)) << angle;
    Rng rng(33, 0, 0);
    EXPECT_TRUE(is_finite(sun.sample(kAnywhere, rng).direction));
  }
}

TEST(SkyLight, ConstantSkyIsTheSameEverywhereAndNotSampled) {
  const SkyLight sky(ConstantSky{{1, 2, 3}});
  EXPECT_FALSE(sky.sampled());
  for (const Vec3f d : {Vec3f{1, 0, 0}, Vec3f{0, -1, 0}, Vec3f{0.6f, 0, -0.8f}}) {
    EXPECT_EQ(sky.radiance(d), (Rgb{1, 2, 3}));
    EXPECT_EQ(sky.pdf(d), 0);
  }
}

void expect_near(Rgb found, Rgb expected) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], 1e-6f * (1 + expected[i]));
}

TEST(SkyLight, SmoothLuminanceIsTheMeanOverTheAxes) {
  const Rgb grey(0.2f, 0.5f, 0.9f);
  EXPECT_FLOAT_EQ(detail::smooth_luminance(SkyLight(ConstantSky{grey})), luminance(grey));
  const GradientSky g{.zenith = Rgb(1.0f), .horizon = Rgb(0.3f), .ground = Rgb(0.7f)};
  EXPECT_FLOAT_EQ(detail::smooth_luminance(SkyLight(g)), (1.0f + 0.7f + 4 * 0.3f) / 6);
  const SkyLight sampled(ImageSky{2, 1, std::vector<Rgb>{Rgb(1.0f), Rgb(5.0f)}});
  ASSERT_TRUE(sampled.sampled());
  EXPECT_EQ(detail::smooth_luminance(sampled), 0);
}

TEST(SkyLight, GradientMixesByTheCosineToUp) {
  const Rgb zenith{1, 2, 4}, horizon{0.5f, 0.25f, 1}, ground{0.125f, 0, 2};
  for (const Vec3d up : {Vec3d{0, 1, 0}, Vec3d{0, 0, 7}, Vec3d{-1e-3, 2e-3, 1e-3}}) {
    const SkyLight sky(GradientSky{zenith, horizon, ground, up});
    EXPECT_FALSE(sky.sampled());
    const Vec3d n = normalize(up);
    Vec3d s, t;
    orthonormal_basis(n, s, t);
    expect_near(sky.radiance(Vec3f(n)), zenith);
    expect_near(sky.radiance(Vec3f(-n)), ground);
    expect_near(sky.radiance(Vec3f(s)), horizon);
    expect_near(sky.radiance(Vec3f(-t)), horizon);
    const Vec3d side = s * std::sqrt(0.75);
    expect_near(sky.radiance(Vec3f(n * 0.5 + side)), (zenith + horizon) * 0.5f);
    expect_near(sky.radiance(Vec3f(n * -0.5 - side)), (ground + horizon) * 0.5f);
  }
}

TEST(SkyLight, PictureHasItsPixelsWhereTheConventionSays) {
  for (const Picture& p : pictures()) {
    const SkyLight sky(p.sky);
    p.for_each_pixel([&](int x, int y) {
      EXPECT_EQ(sky.radiance(p.direction(x + 0.5, y + 0.5)), p.pixel(x, y)) << p.name;
      for (const double dx : {0.001, 0.999}) {
        for (const double dy : {0.001, 0.999}) {
          EXPECT_EQ(sky.radiance(p.direction(x + dx, y + dy)), p.pixel(x, y))
              << p.name << " " << x << " " << y;
        }
      }
    });
  }
}

TEST(SkyLight, AzimuthRunsFromXTowardsZAndRowsFromTheTop) {
  Picture p = make_picture("octants", 4, 2);
  for (int i = 0; i < 8; ++i) p.sky.pixels.edit()[std::size_t(i)] = Rgb(float(i + 1));
  const auto seen = [&](Vec3d d) { return SkyLight(p.sky).radiance(Vec3f(normalize(d))).x; };
  EXPECT_EQ(seen({1, 1, 1}), 1);
  EXPECT_EQ(seen({-1, 1, 1}), 2);
  EXPECT_EQ(seen({-1, 1, -1}), 3);
  EXPECT_EQ(seen({1, 1, -1}), 4);
  EXPECT_EQ(seen({1, -1, 1}), 5);
  EXPECT_EQ(seen({1, -1, -1}), 8);
  p.sky.rotation = 90;  // what looked along +x looks along +z
  EXPECT_EQ(seen({-1, 1, 1}), 1);
  p.sky.rotation = -90;
  EXPECT_EQ(seen({1, 1, -1}), 1);
}

TEST(SkyLight, APictureMayStandOnAnotherAxis) {
  Picture p = make_picture("octants", 4, 2);
  for (int i = 0; i < 8; ++i) p.sky.pixels.edit()[std::size_t(i)] = Rgb(float(i + 1));
  p.sky.up = {0, 0, 1};  // what looked along +z looks along -y
  const auto seen = [&](Vec3d d) { return SkyLight(p.sky).radiance(Vec3f(normalize(d))).x; };
  EXPECT_EQ(seen({1, -1, 1}), 1);
  EXPECT_EQ(seen({-1, -1, 1}), 2);
  EXPECT_EQ(seen({1, 1, 1}), 4);
  EXPECT_EQ(seen({1, -1, -1}), 5);
  p.sky.up = {0, -1, 0};  // upside down, about x
  EXPECT_EQ(seen({1, -1, -1}), 1);
}

TEST(SkyLight, SeamAndPolesOfAPictureAreInsideIt) {
  const Picture p = noise_picture(7, 5, 8);
  for (const double rotation : {0.0, 360.0, -360.0, 1e-20, -1e-20, 123.0}) {
    ImageSky image = p.sky;
    image.rotation = rotation;
    const SkyLight sky(image);
    for (const float tiny : {0.0f, -0.0f, 1e-38f, -1e-38f, 1e-10f, -1e-10f}) {
      for (const Vec3f d : {Vec3f{1, tiny, tiny}, Vec3f{-1, tiny, tiny}, Vec3f{tiny, 1, tiny},
                            Vec3f{tiny, -1, tiny}, Vec3f{0.6f, 0.8f, tiny}}) {
        EXPECT_GT(sky.radiance(d).x, 0);
        EXPECT_GT(sky.pdf(d), 0);
      }
    }
    // Directions that rounding made a little too long.
    EXPECT_EQ(sky.radiance({0, 1.0000001f, 0}), sky.radiance({0, 1, 0}));
  }
}

TEST(SkyLight, DensityIsProportionalToLuminanceAndIntegratesToOne) {
  for (const Picture& p : pictures()) {
    const SkyLight sky(p.sky);
    ASSERT_TRUE(sky.sampled()) << p.name;
    double total = 0, power = 0;
    p.for_each_pixel([&](int x, int y) {
      total += double(sky.pdf(p.direction(x + 0.5, y + 0.5))) * p.solid_angle(y);
      power += double(luminance(p.pixel(x, y))) * p.solid_angle(y);
    });
    EXPECT_NEAR(total, 1, 1e-6) << p.name;
    p.for_each_pixel([&](int x, int y) {
      const double expected = double(luminance(p.pixel(x, y))) / power;
      EXPECT_NEAR(double(sky.pdf(p.direction(x + 0.5, y + 0.5))), expected, 1e-5 * expected)
          << p.name;
    });
  }
}

TEST(SkyLight, SamplesFallIntoPixelsAtTheirDensityAndEstimateTheLight) {
  Family family;
  std::uint64_t stream = 0;
  for (const Picture& p : pictures()) {
    const SkyLight sky(p.sky);
    Rng rng(proof::seeded(34), stream++, 0);
    test::add_samples(
        p, [&] { return sky.sample(rng); }, {0, 2e-7}, family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(SkyLight, SamplesAreEvenInAPixelsSolidAngle) {
  const Picture p = noise_picture(1, 1, 9);  // the whole sphere is one pixel
  const SkyLight sky(p.sky);
  Histogram heights(32), turns(32);
  Rng rng(proof::seeded(35), 0, 0);
  for (int i = 0; i < kSamples; ++i) {
    const Vec3f d = sky.sample(rng).direction;
    heights.add(std::clamp((1 + double(d.y)) / 2, 0.0, 1.0));
    turns.add(0.5 + std::atan2(double(d.z), double(d.x)) / (2 * pi));
  }
  Family family;
  family.add("heights", heights.uniform_p_value());
  family.add("azimuths", turns.uniform_p_value());
  EXPECT_TRUE(family.passes());
}

TEST(SkyLight, BlackPictureIsNotSampled) {
  const SkyLight sky(make_picture("black", 8, 4).sky);
  EXPECT_FALSE(sky.sampled());
  EXPECT_EQ(sky.pdf({1, 0, 0}), 0);
  EXPECT_EQ(sky.radiance({1, 0, 0}), Rgb(0.0f));
  Picture scaled = noise_picture(8, 4, 10);
  scaled.sky.scale = Rgb(0.0f);
  EXPECT_FALSE(SkyLight(scaled.sky).sampled());
}

TEST(SkyLight, RowsAtThePolesOfTallPicturesAreFoundAgain) {
  // A row of 0.02 degrees: there the y of a float direction is 1 to the last digit.
  Picture p = make_picture("tall", 2, 8192);
  for (int row = 0; row < 8; ++row) {
    for (const int y : {row, 8191 - row}) {
      set(p, 0, y, Rgb(1.0f + float(y)));
      set(p, 1, y, Rgb(0.5f + float(y)));
    }
  }
  const SkyLight sky(p.sky);
  Rng rng(36, 0, 0);
  int misplaced = 0;
  for (int i = 0; i < 10'000; ++i) {
    const LightSample l = sky.sample(rng);
    misplaced += l.radiance != sky.radiance(l.direction) || l.pdf != sky.pdf(l.direction);
  }
  EXPECT_LE(misplaced, 10);
}

TEST(SkyLight, FaintPixelsBesideAHotOneAreAllFoundAtTheirRate) {
  // The faint ones share the last 1e-3 of a row, 1.5e-8 each: less than the step of a float there.
  // If only every fourth could be drawn, repeated draws would be four times as common.
  constexpr int kFaint = 1 << 16, kDraws = 4'000'000;
  Picture p = make_picture("hot first", kFaint + 1, 1);
  for (Rgb& c : p.sky.pixels.edit()) c = Rgb(1.0f);
  set(p, 0, 0, Rgb(999.0f * kFaint));
  const SkyLight sky(p.sky);
  Rng rng(proof::seeded(37), 0, 0);
  std::vector<std::uint64_t> found(kFaint + 1);
  double draws = 0;
  for (int i = 0; i < kDraws; ++i) {
    const LightSample l = sky.sample(rng);
    if (l.radiance.x > 1) continue;
    double turns = std::atan2(double(l.direction.z), double(l.direction.x)) / (2 * pi);
    turns -= std::floor(turns);
    ++found[std::min(std::size_t(turns * (kFaint + 1)), std::size_t{kFaint})];
    ++draws;
  }
  std::uint64_t repeats = 0;
  for (const std::uint64_t n : found) repeats += n * (n - (n > 0)) / 2;
  Family family;
  family.add("faint draws", proof::poisson_p_value(std::uint64_t(draws), kDraws * 1e-3));
  family.add("repeats", proof::poisson_p_value(repeats, draws * (draws - 1) / 2 / kFaint));
  EXPECT_TRUE(family.passes());
}

}  // namespace lights_test
}  // namespace pvol
