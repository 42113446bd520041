// Single scattering of a delta sun in a homogeneous cube has a closed form; pictures must show it.
// A slip in the counting of bounces, in the sun's irradiance or in the way to the cube's faces
// changes it (pbrt issue 69 was one).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/math/box.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/effort.h"
#include "support/estimators.h"
#include "support/fields.h"
#include "support/statistics.h"

namespace pvol {
namespace single_scattering_test {

using test::CloudScene;

using std::numbers::pi;

/// With the nearest interpolation, density 1 in [-0.5, 12.5]^3: the faces lie amid leaves.
const test::Field& cube() {
  static const test::Field f =
      test::make_field("cube", {0, 0, 0}, {13, 13, 13}, [](Vec3i) { return 1.0; });
  return f;
}
constexpr double kLow = -0.5, kHigh = 12.5;

/// int_a^b exp(-(c + k s)) ds.
double integrate_exponential(double c, double k, double a, double b) {
  const double at_a = std::exp(-(c + k * a)), exponent = k * (b - a);
  return exponent == 0 ? at_a * (b - a) : at_a * -std::expm1(-exponent) / k;
}

/// A linear function of the distance s along the view ray.
struct Line {
  double offset, slope;
};

/// int_a^b exp(-mu (s - a + least of lines(s))) ds, piece by piece between the lines' crossings.
double integrate_attenuation(double mu, const std::vector<Line>& lines, double a, double b) {
  std::vector<double> ends{a, b};
  for (const Line& p : lines) {
    for (const Line& q : lines) {
      const double s = (q.offset - p.offset) / (p.slope - q.slope);  // not finite if parallel
      if (s > a && s < b) ends.push_back(s);
    }
  }
  std::sort(ends.begin(), ends.end());
  double sum = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i - 1] + ends[i]);
    const Line nearest =
        *std::min_element(lines.begin(), lines.end(), [middle](const Line& p, const Line& q) {
          return p.offset + p.slope * middle < q.offset + q.slope * middle;
        });
    sum += integrate_exponential(mu * (nearest.offset - a), mu * (1 + nearest.slope), ends[i - 1],
                                 ends[i]);
  }
  return sum;
}

double henyey_greenstein(double g, double cosine) {
  return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// Single scattering along a view ray, for albedo 1 and irradiance 1, by a phase function of the
/// cosine.
template <class Phase>
double radiance_by(const Phase& phase, const Ray& view, Vec3d to_sun, double mu) {
  const auto inside = intersect({Vec3d(kLow), Vec3d(kHigh)}, view, 0, 1e9);
  if (!inside) return 0;
  std::vector<Line> lines;  // distance to each face towards the sun
  for (int axis = 0; axis < 3; ++axis) {
    if (to_sun[axis] == 0) continue;
    const double face = to_sun[axis] > 0 ? kHigh : kLow;
    lines.push_back({(face - view.o[axis]) / to_sun[axis], -view.d[axis] / to_sun[axis]});
  }
  const double cosine = dot(view.d, to_sun);  // light goes along -to_sun, then along -view.d
  return mu * phase(cosine) * integrate_attenuation(mu, lines, inside->t0, inside->t1);
}
double radiance(const Ray& view, Vec3d to_sun, double mu, double g) {
  return radiance_by([g](double cosine) { return henyey_greenstein(g, cosine); }, view, to_sun, mu);
}

TEST(SingleScattering, ClosedFormIsItsIntegral) {
  const Vec3d to_sun = normalize(Vec3d(0.5, 0.7, -0.3));
  const Ray view{{20, 9, 15}, normalize(Vec3d(-1, -0.4, -0.8))};
  const Box box{Vec3d(kLow), Vec3d(kHigh)};
  const auto span = intersect(box, view, 0, 1e9);
  ASSERT_TRUE(span);
  constexpr int kSteps = 100'000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double s = span->t0 + (span->t1 - span->t0) * (i + 0.5) / kSteps;
    const double out = intersect(box, {view.at(s), to_sun}, 0, 1e9)->t1;
    sum += std::exp(-0.2 * (s - span->t0 + out));
  }
  const double expected = 0.2 / (4 * pi) * sum * (span->t1 - span->t0) / kSteps;
  EXPECT_NEAR(radiance(view, to_sun, 0.2, 0) / expected, 1, 1e-7);
}

/// Where the camera stands and what it looks at.
struct View {
  const char* name;
  Vec3d position, target;
};
constexpr View kViews[] = {
    {"outside", {40, 25, 30}, {6, 6, 6}},
    {"before a face", {6, 6.2, 14}, {6.5, 6, 0}},
    {"inside", {3, 4, 9}, {8, 7, 2}},
    {"far, on the dark side", {-6000, -7000, 4000}, {6, 6, 6}},
};

/// A pixel of an image so large that the view ray hardly varies within it.
struct Pixel {
  double x, y;  ///< of the image, from its upper left corner
};
constexpr Pixel kPixels[] = {{0.5, 0.5}, {0.4, 0.56}, {0.61, 0.47}};
constexpr int kSize = 100'000;

CloudScene scene_of(const View& view, Pixel pixel) {
  CloudScene s;
  s.camera.position = view.position;
  s.camera.target = view.target;
  // The whole cube, or a good part of it where one is closer.
  s.camera.fov = std::min(60.0, 180 / pi * 14 / length(view.target - view.position));
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = kSize;
  s.options.crop_x = int(pixel.x * kSize);
  s.options.crop_y = int(pixel.y * kSize);
  s.options.crop_width = s.options.crop_height = 1;
  s.options.look_up = LookUp::nearest;
  s.options.max_bounces = 1;
  s.options.threads = 1;
  return s;
}

/// The ray through the middle of the pixel.
Ray view_ray(const CloudScene& s) {
  const Vec3d forward = normalize(s.camera.target - s.camera.position);
  const Vec3d right = normalize(cross(forward, s.camera.up)), up = cross(right, forward);
  const double scale = 2 * std::tan(s.camera.fov * pi / 360);
  const double x = (s.options.crop_x + 0.5) / kSize - 0.5,
               y = (s.options.crop_y + 0.5) / kSize - 0.5;
  return {s.camera.position, normalize(forward + right * (scale * x) - up * (scale * y))};
}

/// The pixel's mean against the closed form, by channel; returns the first one's excess in standard
/// deviations.
double compare(const CloudScene& s, const std::string& name, proof::Family& family) {
  const Volume volume = make_volume(cube().grid, build_pyramid(cube().grid), s);
  const PixelSums pixel = render(volume, s).film.at(0, 0);
  const double one = radiance(view_ray(s), normalize(std::get<Sun>(s.lights[0]).direction),
                              s.medium.extinction, s.medium.g);
  const Vec3d expected =
      Vec3d(s.medium.albedo) * Vec3d(std::get<Sun>(s.lights[0]).irradiance) * one;
  EXPECT_GT(one, 0) << name;
  double first = 0;
  for (int c = 0; c < 3; ++c) {
    const double deviation = std::sqrt(variance_of_mean(pixel)[c]);
    // Float directions and the pixel's extent.
    const double excess = mean(pixel)[c] - expected[c], rounding = 1e-5 * expected[c];
    family.add(name + ", channel " + std::to_string(c),
               proof::normal_p_value(std::max(0.0, std::abs(excess) - rounding) / deviation));
    if (c == 0) first = excess / deviation;
  }
  return first;
}

TEST(SingleScattering, PicturesOfACubeHaveItsClosedForm) {
  // The second is so dark that the path tracer's roulette decides.
  const Rgb albedos[] = {Rgb(1.0f, 0.5f, 0.25f), Rgb(0.05f, 0.02f, 0.04f)};
  proof::Family family;
  std::map<std::string, proof::Moments> z;  // of each tracker and each estimator
  std::uint64_t number = 0;
  for (const Tracker tracker : test::kTrackers) {
    for (const Transmittance transmittance : test::kTransmittances) {
      for (const View& view : kViews) {
        for (const Pixel& pixel : kPixels) {
          // Phase functions, thicknesses and albedos take turns.
          constexpr double kMeanCosines[] = {0, 0.8, -0.6, 0.3, -0.3};
          constexpr double kExtinctions[] = {0.2, 0.1, 0.3};
          CloudScene s = scene_of(view, pixel);
          s.options.tracker = tracker;
          s.options.transmittance = transmittance;
          s.options.seed = ++number;
          s.medium.g = kMeanCosines[number % 5];
          s.medium.extinction = kExtinctions[number / 5 % 3];
          // The dark side and the densest cube are dark by themselves: with both, one sample in ten
          // thousand would bring light, of which no mean and deviation can be told.
          const bool dark_side = &view == std::end(kViews) - 1 || number / 5 % 3 == 2;
          const bool dark = number % 7 == 0 && !dark_side;
          s.medium.albedo = albedos[dark];
          const int all = test::is_slow(tracker, transmittance) ? 10'000 : 30'000;
          s.options.samples = std::uint32_t(dark ? all : proof::samples(all));
          s.lights = {Sun{{0.5, 0.7, -0.3}, Rgb(2.0f, 3.0f, 1.5f), 0}};
          const std::string of_tracker = std::string("tracker ") + test::label(tracker);
          const std::string of_estimator = std::string("estimator ") + test::label(transmittance);
          const double deviation =
              compare(s,
                      of_tracker + ", " + of_estimator + ", " + view.name + ", g " +
                          std::to_string(s.medium.g) + ", extinction " +
                          std::to_string(s.medium.extinction),
                      family);
          z[of_tracker].add(deviation);
          z[of_estimator].add(deviation);
        }
      }
    }
  }
  for (const auto& [name, moments] : z) {
    family.add(name + ", all together",
               proof::normal_p_value(moments.mean() * std::sqrt(double(moments.count()))));
  }
  EXPECT_TRUE(family.passes());
}

double draine(double g, double alpha, double cosine) {
  return henyey_greenstein(g, cosine) * (1 + alpha * cosine * cosine) /
         (1 + alpha * (1 + 2 * g * g) / 3);
}

/// Of 20 micrometres: the values of the fit, in digits.
double droplets_of_20(double cosine) {
  constexpr double kPeak = 0.99461005, kWide = 0.59379058, kAlpha = 27.1136937;
  constexpr double kShare = 0.49815948;
  return (1 - kShare) * henyey_greenstein(kPeak, cosine) + kShare * draine(kWide, kAlpha, cosine);
}

/// Points at cosines 1, 1/2, 0 and -1; its integral over cosines is 1 + 1 / 4 + 3 / 2.
double tabulated(double cosine) {
  const double value = cosine > 0.5 ? 4 * cosine - 1 : cosine > 0 ? 2 * cosine : -3 * cosine;
  return value / (2 * pi * (1 + 0.25 + 1.5));
}

/// What next-event estimation makes of each; the kernel is any.
TEST(SingleScattering, OfEveryPhaseFunctionHasItsClosedForm) {
  struct Kind {
    const char* name;
    PhaseFunction phase;
    double (*exact)(double cosine);
    int parts = 4;  ///< a narrow peak, which shadow rays seldom meet, takes more samples
  };
  const Kind kinds[] = {
      {"two lobes", TwoLobes{HenyeyGreenstein(0.7), HenyeyGreenstein(-0.4), 0.6},
       [](double c) { return 0.6 * henyey_greenstein(0.7, c) + 0.4 * henyey_greenstein(-0.4, c); }},
      {"rayleigh", Rayleigh{}, [](double c) { return 3 / (16 * pi) * (1 + c * c); }},
      {"draine", Draine(-0.4, 5), [](double c) { return draine(-0.4, 5, c); }, 2},
      {"droplets", Droplets(20), droplets_of_20, 1},
      {"table", PhaseTable({{0, 3}, {60, 1}, {90, 0}, {180, 3}}), tabulated}};
  proof::Family family;
  std::uint64_t number = 0;
  for (const Kind& k : kinds) {
    proof::Moments z;
    for (const View& view : {kViews[0], kViews[2]}) {
      for (const Vec3d to_sun : {Vec3d(0.5, 0.7, -0.3), Vec3d(-0.6, -0.3, 0.5)}) {
        CloudScene s = scene_of(view, kPixels[number % 3]);
        s.options.samples = proof::samples(300'000, k.parts);
        s.options.seed = ++number;
        s.medium.extinction = 0.2;
        s.medium.others = {{1, Rgb(0.9f), k.phase, Rgb(0.0f)}};
        s.lights = {Sun{to_sun, Rgb(2.0f), 0}};
        const Volume volume = make_volume(cube().grid, build_pyramid(cube().grid), s);
        const PixelSums pixel = render(volume, s).film.at(0, 0);
        const double expected =
            double(0.9f) * 2 * radiance_by(k.exact, view_ray(s), normalize(to_sun), 0.2);
        const double error = std::sqrt(variance_of_mean(pixel).x);
        const double off = std::max(0.0, std::abs(mean(pixel).x - expected) - 1e-4 * expected);
        family.add(std::string(k.name) + ", " + view.name, proof::normal_p_value(off / error));
        z.add((mean(pixel).x - expected) / error);
        EXPECT_LT(error, 0.015 * expected) << k.name;
      }
    }
    family.add(std::string(k.name) + ", all together",
               proof::normal_p_value(z.mean() * std::sqrt(double(z.count()))));
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace single_scattering_test
}  // namespace pvol
