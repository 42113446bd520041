// The clear sky: its air against published figures, its light against closed forms and a Monte
// Carlo estimate of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "pvol/math/rng.h"
#include "pvol/render/daylight.h"
#include "pvol/render/lighting.h"
#include "render/light/sky/scattered_light.h"
#include "support/statistics.h"

namespace pvol {
namespace clear_sky_test {

using namespace detail;
using std::numbers::pi;
constexpr double kDegree = pi / 180;

/// Band nearest to a wavelength.
int band_at(double nm) {
  return int(std::lround((nm - kFirstBand) / (kLastBand - kFirstBand) * (kBands - 1)));
}

Atmosphere pure_air(Rgb ground = Rgb(0.0f)) { return make_atmosphere(0, 0, ground); }

/// Radiance over the sun's irradiance.
Spectrum radiance(const Atmosphere& a, const ScatteredLight& light, double sun, double angle,
                  double azimuth) {
  const SkyLightParts p = light.seen(angle, {&azimuth, 1}).front();
  const auto c =
      float(std::cos(sun) * std::cos(angle) + std::sin(sun) * std::sin(angle) * std::cos(azimuth));
  return p.molecules * phase_of_molecules(c) + p.aerosols * phase_of_aerosols(a, c) + p.rest;
}

TEST(Spectrum, ExponentialIsAccurate) {
  for (double x = 0; x > -86; x -= 0.0137) {
    EXPECT_NEAR(double(exp_below(float(x))) / std::exp(double(float(x))), 1, 8e-6) << x;
  }
  EXPECT_LT(exp_below(-1e30f), 1e-37f);
}

TEST(Spectrum, TheSunAboveTheAirIsNearlyWhite) {
  const Vec3d sun = seen_as(Spectrum(1.0f), ColorSpace::rec709);
  EXPECT_NEAR(dot(sun, Vec3d(0.2126, 0.7152, 0.0722)), 1, 1e-4);
  // About that of a black body of 5800 K: a little red beside D65.
  EXPECT_GT(sun.x, sun.y);
  EXPECT_GT(sun.y, sun.z);
  EXPECT_NEAR(sun.x / sun.z, 1.18, 0.1);
}

TEST(Air, MoleculesScatterAsTheirIndexOfRefractionSays) {
  // Bodhaine et al. 1999 in full: the index of Peck and Reeder for 360 ppm of carbon dioxide, the
  // depolarisation of nitrogen, oxygen, argon and carbon dioxide, and the molecules above the sea
  // at 45 degrees north.
  for (const double nm : {380.0, 450.0, 550.0, 650.0, 720.0}) {
    const double k = 1e6 / (nm * nm), cm = nm * 1e-7;
    const double n300 = (8060.51 + 2480990 / (132.274 - k) + 17455.7 / (39.32957 - k)) * 1e-8;
    const double n = 1 + n300 * (1 + 0.54 * (0.00036 - 0.0003));
    const double king =
        (78.084 * (1.034 + 3.17e-4 * k) + 20.946 * (1.096 + 1.385e-3 * k + 1.448e-4 * k * k) +
         0.934 + 0.036 * 1.15) /
        (78.084 + 20.946 + 0.934 + 0.036);
    const double density = 2.546899e19, q = (n * n - 1) / (n * n + 2);
    const double section = 24 * pi * pi * pi * q * q / (std::pow(cm, 4) * density * density) * king;
    const double molecules = 1013250 * 6.0221367e23 / (28.9641 * 978.0 * 1.00231);
    EXPECT_NEAR(molecules_depth(nm) / (section * molecules), 1, 3e-3) << nm;
  }
  EXPECT_NEAR(molecules_depth(550), 0.0971, 1e-4);
}

TEST(Air, OzoneAbsorbsMostAt600Nanometres) {
  EXPECT_NEAR(300 * ozone_depth(605), 0.0405, 2e-4);  // 5.019e-25 m^2 a molecule
  EXPECT_GT(ozone_depth(605), ozone_depth(550));
  EXPECT_GT(ozone_depth(605), ozone_depth(650));
  EXPECT_LT(ozone_depth(400), 0.01 * ozone_depth(605));
  // The column through all levels.
  const Atmosphere a = make_atmosphere(0, 300, Rgb(0.0f));
  const int band = band_at(600);
  Atmosphere alone = a;
  alone.molecules = alone.aerosols = Spectrum();
  EXPECT_NEAR(-std::log(double(SunBeam(alone).at(0, 0)[band])), 300 * ozone_depth(band_nm(band)),
              2e-4);
}

TEST(Air, AerosolsHaveTheDepthOfTheTurbidity) {
  Atmosphere a = make_atmosphere(0.3, 0, Rgb(0.0f));
  a.molecules = Spectrum();
  const Spectrum t = SunBeam(a).at(0, 0);
  for (int b = 0; b < kBands; ++b) {
    const double depth = 0.3 * std::pow(band_nm(b) / 550, -1.3);
    EXPECT_NEAR(-std::log(double(t[b])) / depth, 1, 2e-3) << band_nm(b);
  }
}

TEST(Air, MassesAreThoseOfKastenAndYoung) {
  // Kasten and Young 1989: their fit of masses along bent rays, within 0.5 % of their table.
  const Atmosphere a = pure_air();
  const SunBeam beam(a);
  const int band = band_at(650);
  const double vertical = std::log(double(beam.at(0, 0)[band]));
  EXPECT_NEAR(vertical, -molecules_depth(band_nm(band)), 1e-5);
  for (const double elevation : {60.0, 30.0, 20.0, 10.0, 5.0, 3.0}) {
    const double mass =
        1 / (std::sin(elevation * kDegree) + 0.50572 * std::pow(elevation + 6.07995, -1.6364));
    const double ours = std::log(double(beam.at(0, (90 - elevation) * kDegree)[band])) / vertical;
    EXPECT_NEAR(ours / mass, 1, elevation < 5 ? 0.02 : 0.01) << elevation;
  }
}

TEST(SunBeam, HasTheClosedFormOfAnExponentialAtmosphere) {
  // Along the horizon the column is n sqrt(pi R H / 2) (1 + 3 H / (8 R) ...), from the expansion of
  // Chapman's function; far from it, over a planet that is all but flat, H / cos.
  Atmosphere a = pure_air();
  const int band = band_at(700);
  const double h = a.molecules_height;
  const double per_km = molecules_depth(band_nm(band)) / h;
  const double along = std::sqrt(pi * a.planet * h / 2) * (1 + 3 * h / (8 * a.planet));
  EXPECT_NEAR(-std::log(double(SunBeam(a).at(0, pi / 2)[band])) / (per_km * along), 1, 3e-3);
  a.planet = 1e7;
  const SunBeam flat(a);
  for (const double degrees : {0.0, 30.0, 60.0, 75.0, 84.0}) {
    const double depth = per_km * h / std::cos(degrees * kDegree);
    EXPECT_NEAR(-std::log(double(flat.at(0, degrees * kDegree)[band])) / depth, 1, 3e-3);
    const int level = 13;  // 10 km
    EXPECT_NEAR(-std::log(double(flat.at(level, degrees * kDegree)[band])) /
                    (depth * std::exp(-kLevels[std::size_t(level)] / h)),
                1, 3e-3);
  }
}

TEST(SunBeam, SetsWithItsDisc) {
  const Atmosphere a = make_atmosphere(0.1, 300, Rgb(0.2f));
  const SunBeam beam(a);
  const double radius = 0.265 * kDegree;
  const auto red = [&](double elevation) {
    return beam.of_disc((90 - elevation) * kDegree, radius)[kBands - 1];
  };
  EXPECT_NEAR(red(40) / beam.at(0, 50 * kDegree)[kBands - 1], 1, 1e-4);
  float before = red(0.5);
  for (double e = 0.45; e > -0.26; e -= 0.05) {
    EXPECT_LT(red(e), before) << e;
    before = red(e);
  }
  EXPECT_GT(red(-0.2), 0);
  EXPECT_EQ(red(-0.3), 0);
  EXPECT_EQ(beam.at(5, pi), Spectrum());
}

TEST(ScatteredLight, MomentsScatterAsMoleculesDo) {
  // Light from one direction and as much from its mirror image, y for -y.
  const auto on_sphere = [](double turns, double z) {
    const double side = std::sqrt(1 - z * z);
    return Vec3d(side * std::cos(turns), side * std::sin(turns), z);
  };
  for (int i = 0; i < 40; ++i) {
    const Vec3d from = on_sphere(0.7 * i, std::cos(0.31 * i)), mirrored(from.x, -from.y, from.z);
    const Vec3d to = on_sphere(1.9 * i + 1, std::cos(1.7 * i));
    const MomentFactors f = scattered_towards(to.x, to.z);
    const double sum = double(f.xx) * from.x * from.x + double(f.yy) * from.y * from.y +
                       double(f.zz) * from.z * from.z + double(f.xz) * from.x * from.z;
    const double exact = (double(phase_of_molecules(float(dot(to, from)))) +
                          double(phase_of_molecules(float(dot(to, mirrored))))) /
                         2;
    EXPECT_NEAR(sum, exact, 1e-6);
  }
}

TEST(ScatteredLight, ScattersOnceAsTheClosedFormOfASlabSays) {
  // Chandrasekhar: light that left a flat layer of depth t downwards after one scattering, for the
  // cosines m of the ray and s of the sun, is p s / (s - m) (exp(-t/s) - exp(-t/m)).
  Atmosphere a = pure_air();
  a.planet = 1e7;
  const double sun = 40 * kDegree, s = std::cos(sun);
  const ScatteredLight light(a, sun);
  for (const double angle : {10.0, 30.0, 60.0, 80.0, 87.0}) {
    const double m = std::cos(angle * kDegree), azimuth = 0.7;
    const SkyLightParts p = light.seen(angle * kDegree, {&azimuth, 1}).front();
    for (const int b : {0, 5, 15}) {
      const double t = molecules_depth(band_nm(b));
      const double exact = s / (s - m) * (std::exp(-t / s) - std::exp(-t / m));
      EXPECT_NEAR(double(p.molecules[b]) / exact, 1, 4e-3) << angle << ' ' << band_nm(b);
      EXPECT_EQ(p.aerosols[b], 0);
    }
  }
}

TEST(ScatteredLight, KeepsTheEnergy) {
  // Without absorption as much light goes up as comes down, over white ground, at every height;
  // over black ground the difference is the same at every height.
  for (const double aerosols : {0.0, 0.5}) {
    for (const float ground : {1.0f, 0.0f}) {
      Atmosphere a = make_atmosphere(aerosols, 0, Rgb(ground));
      a.planet = 1e6, a.aerosols_albedo = 1;
      const double sun = 50 * kDegree;
      const ScatteredLight light(a, sun);
      const auto net = [&](int level) {
        return light.net_flux(level) + light.beam().at(level, sun) * float(std::cos(sun));
      };
      for (int b = 0; b < kBands; ++b) {
        const double wanted = ground == 1 ? 0 : double(net(0)[b]);
        for (int level = 0; level <= kTop; ++level) {
          const double share = aerosols > 0 ? 0.015 : 0.005;  // of what the sun sends
          EXPECT_NEAR(double(net(level)[b]), wanted, share * std::cos(sun))
              << band_nm(b) << " nm at " << kLevels[std::size_t(level)] << " km, " << ground;
        }
      }
    }
  }
}

/// Light of one band by random paths from the observer to the sun, against majorants, with the
/// formulas of the atmosphere written out again.
class RandomPaths {
 public:
  RandomPaths(const Atmosphere& a, int band, double sun)
      : a_(a),
        molecules_(double(a.molecules[band])),
        aerosols_(double(a.aerosols[band])),
        ozone_(double(a.ozone[band])),
        ground_(double(a.ground[band])),
        sun_{std::sin(sun), 0, std::cos(sun)} {}

  /// `skipped` is how many scatterings count for nothing.
  double sample(double angle, double azimuth, Rng& rng, int skipped = 0) const {
    Vec3d p(0, 0, a_.planet + 1e-6);
    Vec3d d(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
            std::cos(angle));
    double weight = 1, sum = 0;
    for (int bounce = 0; bounce < 200; ++bounce) {
      const Event e = fly(p, d, rng);
      if (e == Event::left) break;
      if (e == Event::ground) {
        const Vec3d n = normalize(p);
        weight *= ground_;
        if (!(weight > 0)) break;
        p = n * (a_.planet + 1e-6);
        const double c = dot(n, sun_);
        if (c > 0 && bounce >= skipped) sum += weight / pi * c * passes(p, rng);
        d = cosine_direction(n, rng);
        continue;
      }
      const double h = length(p) - a_.planet;
      const double r = molecules_ * std::exp(-h / a_.molecules_height);
      const double m = aerosols_ * std::exp(-h / a_.aerosols_height);
      const double scattered = r + m * double(a_.aerosols_albedo);
      weight *= scattered / (r + m + ozone(h));
      const double to_sun = dot(d, sun_);
      const double phase =
          (r * rayleigh(to_sun) + m * double(a_.aerosols_albedo) * henyey_greenstein(to_sun)) /
          scattered;
      if (bounce >= skipped) sum += weight * phase * passes(p, rng);
      d = double(rng.uniform()) * scattered < r ? scatter_rayleigh(d, rng)
                                                : scatter_aerosols(d, rng);
    }
    return sum;
  }

 private:
  enum class Event { left, ground, collided };

  double ozone(double h) const {
    return ozone_ * std::max(0.0, h < 25 ? (h - 10) / 15 : (40 - h) / 15);
  }
  double rayleigh(double c) const { return 3 / (16 * pi) * (1 + c * c); }
  double henyey_greenstein(double c) const {
    const double g = double(a_.mean_cosine);
    return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * c, 1.5));
  }
  double extinction_at(double h) const {
    return molecules_ * std::exp(-h / a_.molecules_height) +
           aerosols_ * std::exp(-h / a_.aerosols_height) + ozone(h);
  }

  /// Majorants of layers of 2 km, then of one above 40 km.
  Event fly(Vec3d& p, Vec3d d, Rng& rng) const {
    for (;;) {
      const double h = std::max(length(p) - a_.planet, 0.0);
      const int layer = std::min(int(h / 2), 20);
      const double lo = 2 * layer, hi = layer == 20 ? 100 : lo + 2;
      const double majorant = molecules_ * std::exp(-lo / a_.molecules_height) +
                              aerosols_ * std::exp(-lo / a_.aerosols_height) +
                              (lo < 25 && hi > 25 ? ozone_ : std::max(ozone(lo), ozone(hi)));
      const double t = -std::log1p(-to_uniform_double(rng.block().lo)) / (majorant * 1.0001);
      const double end = leave(p, d, lo, hi);
      if (t < end) {
        p = p + d * t;
        const double now = extinction_at(length(p) - a_.planet);
        EXPECT_LE(now, majorant * 1.0001);
        if (double(rng.uniform()) * majorant * 1.0001 < now) return Event::collided;
        continue;
      }
      p = p + d * (end + 1e-7);
      const double now = length(p) - a_.planet;
      if (now >= 100) return Event::left;
      if (now <= 0) return Event::ground;
    }
  }
  /// Distance to the spheres around a layer.
  double leave(Vec3d p, Vec3d d, double lo, double hi) const {
    const double b = dot(p, d), r2 = dot(p, p);
    const double inner = a_.planet + lo, outer = a_.planet + hi;
    const double in = b * b - (r2 - inner * inner);
    if (b < 0 && in > 0) return std::max(-b - std::sqrt(in), 0.0);
    return std::max(-b + std::sqrt(std::max(b * b - (r2 - outer * outer), 0.0)), 0.0);
  }
  double passes(Vec3d p, Rng& rng) const { return fly(p, sun_, rng) == Event::left ? 1 : 0; }

  static Vec3d around(Vec3d axis, double c, double turns) {
    Vec3d s, t;
    orthonormal_basis(axis, s, t);
    const double sine = std::sqrt(std::max(0.0, 1 - c * c));
    return normalize(axis * c + s * (sine * std::cos(2 * pi * turns)) +
                     t * (sine * std::sin(2 * pi * turns)));
  }
  static Vec3d cosine_direction(Vec3d n, Rng& rng) {
    const auto [u, v] = rng.uniform2();
    return around(n, std::sqrt(1 - double(u)), double(v));
  }
  static Vec3d scatter_rayleigh(Vec3d d, Rng& rng) {
    for (;;) {
      const auto [u, v] = rng.uniform2();
      const double c = 2 * double(u) - 1;
      if (2 * double(rng.uniform()) < 1 + c * c) return around(d, c, double(v));
    }
  }
  Vec3d scatter_aerosols(Vec3d d, Rng& rng) const {
    const auto [u, v] = rng.uniform2();
    const double g = double(a_.mean_cosine), q = (1 - g * g) / (1 - g + 2 * g * double(u));
    return around(d, (1 + g * g - q * q) / (2 * g), double(v));
  }

  const Atmosphere& a_;
  double molecules_, aerosols_, ozone_, ground_;
  Vec3d sun_;
};

TEST(ScatteredLight, LeansTowardsTheSunByHigherOrdersToo) {
  const Atmosphere a = pure_air();
  constexpr double kSun = 80 * kDegree, kAngle = 60 * kDegree;
  constexpr int kBand = 1;
  const int samples = proof::samples(1'000'000, 2);
  const ScatteredLight light(a, kSun);
  const RandomPaths paths(a, kBand, kSun);
  for (const double azimuth : {0.0, pi}) {
    proof::Moments m;
    for (int i = 0; i < samples; ++i) {
      Rng rng(8, std::uint64_t(azimuth), std::uint64_t(i));
      m.add(paths.sample(kAngle, azimuth, rng, 1));
    }
    const double noise = std::sqrt(m.variance_of_mean()) / m.mean();
    EXPECT_LT(noise, 0.005);
    EXPECT_NEAR(double(light.seen(kAngle, {&azimuth, 1}).front().rest[kBand]) / m.mean(), 1,
                0.007 + 3 * noise)
        << azimuth;
  }
}

struct SkyCase {
  double turbidity, elevation;
  float ground;
  double share;  // systematic error that is allowed; half of it on average
};

class SkyByPaths : public testing::TestWithParam<SkyCase> {};

TEST_P(SkyByPaths, IsTheSame) {
  const SkyCase c = GetParam();
  const Atmosphere a = make_atmosphere(0.1 * (c.turbidity - 1), 300, Rgb(c.ground));
  const double sun = (90 - c.elevation) * kDegree;
  const ScatteredLight light(a, sun);
  const int samples = proof::samples(120'000);
  struct View {
    double angle, azimuth;
  };
  double mean_ratio = 0, variance = 0;
  for (const int band : {1, 8}) {
    for (const View v : {View{5, 20}, View{60, 60}, View{85, 150}}) {
      const Spectrum ours = radiance(a, light, sun, v.angle * kDegree, v.azimuth * kDegree);
      proof::Moments m;
      const RandomPaths paths(a, band, sun);
      for (int i = 0; i < samples; ++i) {
        Rng rng(7, std::uint64_t(band * 1000) + std::uint64_t(v.angle), std::uint64_t(i));
        m.add(paths.sample(v.angle * kDegree, v.azimuth * kDegree, rng));
      }
      const double noise = std::sqrt(m.variance_of_mean()) / m.mean();
      mean_ratio += double(ours[band]) / m.mean() / 6, variance += noise * noise / 36;
      // Some tens of comparisons in all: four standard errors are hardly ever exceeded.
      EXPECT_NEAR(double(ours[band]) / m.mean(), 1, c.share + 4 * noise)
          << band_nm(band) << " nm, " << v.angle << " degrees from the zenith, noise " << noise;
    }
  }
  EXPECT_NEAR(mean_ratio, 1, c.share / 2 + 4 * std::sqrt(variance));
}
INSTANTIATE_TEST_SUITE_P(Suns, SkyByPaths,
                         testing::Values(SkyCase{1, 50, 0.0f, 0.01}, SkyCase{1, 50, 0.8f, 0.01},
                                         SkyCase{2, 30, 0.2f, 0.01}, SkyCase{8, 40, 0.2f, 0.03},
                                         SkyCase{2, 5, 0.2f, 0.02}, SkyCase{2, 0.5, 0.2f, 0.04},
                                         SkyCase{1, -3, 0.2f, 0.05}));

}  // namespace clear_sky_test
}  // namespace pvol
