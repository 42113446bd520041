// Henyey-Greenstein: density, samples and frames against the closed form in double.
#include "pvol/volume/phase.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>

#include "support/statistics.h"

namespace pvol {
namespace phase_test {

using proof::Family;
using proof::Histogram;
using proof::Moments;
using std::numbers::pi;

constexpr std::array kMeanCosines{-0.9999, -0.9, -0.5, -1e-4, 0.0, 1e-8, 1e-4, 0.5, 0.85, 0.9999};
const int kSamples = proof::samples(600'000);

std::string name(const char* what, double g) { return what + (" at g = " + std::to_string(g)); }

/// A unit vector, evenly distributed over the sphere.
Vec3f any_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return Vec3f(normalize(Vec3d{x, y, z}));
}

/// The density per steradian at c = 1 - cos of the angle to the peak, g = |mean cosine|.
double exact_pdf(double g, double c) {
  const double d = (1 - g) * (1 - g) + 2 * g * c;
  return (1 - g) * (1 + g) / (4 * pi * d * std::sqrt(d));
}

/// The share of scattering within c. The integral of 2 pi exact_pdf, (1 - g^2) / (2 g) times
/// 1 / (1 - g) - 1 / D with D^2 = (1 - g)^2 + 2 g c, with the difference multiplied out so that it
/// holds at g = 0.
double exact_cdf(double g, double c) {
  const double d = std::sqrt((1 - g) * (1 - g) + 2 * g * c);
  return (1 + g) * c / (d * (d + 1 - g));
}

/// 1 - cos of the angle between `to` and the peak when light comes along `from`, in double.
double from_peak(double g, Vec3f from, Vec3f to) {
  const Vec3d d = Vec3d(to) - Vec3d(from) * (g < 0 ? -1.0 : 1.0);
  return 0.5 * dot(d, d);
}

/// A direction at c from +z or, about the backward peak of a negative g, from -z.
Vec3f at_angle(double g, double c) {
  const double sine = std::sqrt(c * (2 - c));
  return Vec3f(Vec3d{sine, 0, (1 - c) * (g < 0 ? -1 : 1)});
}

/// The integral over the sphere of f(c) pdf_phase, by the midpoint rule in log(c + s): steps are
/// even where the density is flat (c << s) and in proportion to c in its tail.
template <class F>
double integrate_phase(double g, F f) {
  const HenyeyGreenstein hg(g);
  const double size = 1 - std::abs(g), s = size * size + 1e-12;
  constexpr int kSteps = 100'000;
  const double from = std::log(s), step = (std::log(2 + s) - from) / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double shifted = std::exp(from + (i + 0.5) * step), c = std::min(shifted - s, 2.0);
    sum += f(c) * double(pdf_phase(hg, {0, 0, 1}, at_angle(g, c))) * shifted;
  }
  return 2 * pi * sum * step;
}

TEST(HenyeyGreenstein, DensityIsTheClosedForm) {
  for (const double g : kMeanCosines) {
    const HenyeyGreenstein hg(g);
    for (double c = 1e-12; c < 2; c *= 1.3) {
      // Measured from the direction as rounded to float.
      const Vec3f to = at_angle(g, c);
      const double exact = exact_pdf(std::abs(g), from_peak(g, {0, 0, 1}, to));
      EXPECT_NEAR(double(pdf_phase(hg, {0, 0, 1}, to)) / exact, 1, 2e-6) << g << " " << c;
    }
  }
}

TEST(HenyeyGreenstein, DensityIntegratesToOneAndItsMeanCosineIsG) {
  for (const double g : kMeanCosines) {
    const double size = 1 - std::abs(g);
    EXPECT_NEAR(integrate_phase(g, [](double) { return 1.0; }), 1, 5e-6) << g;
    // The mean of 1 - |cos| to the peak is 1 - |g|: of that all digits are tested.
    EXPECT_NEAR(integrate_phase(g, [](double c) { return c; }) / size, 1, 5e-6) << g;
  }
}

TEST(HenyeyGreenstein, DensityIsTheSameWithItsDirectionsExchangedOrBothReversed) {
  std::mt19937_64 random(1);
  for (const double g : kMeanCosines) {
    const HenyeyGreenstein hg(g);
    for (int i = 0; i < 1000; ++i) {
      const Vec3f a = any_direction(random), b = any_direction(random);
      const float there = pdf_phase(hg, a, b);
      EXPECT_EQ(there, pdf_phase(hg, b, a));
      EXPECT_EQ(there, pdf_phase(hg, -a, -b));
      EXPECT_EQ(there, pdf_phase(HenyeyGreenstein(-g), a, -b));
      EXPECT_GT(there, 0);
    }
  }
}

TEST(HenyeyGreenstein, IsIsotropicAtZeroAndContinuousThere) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3f a = any_direction(random), b = any_direction(random);
    for (const double g : {0.0, -0.0, 1e-8, -1e-8, 1e-30}) {
      EXPECT_NEAR(pdf_phase(HenyeyGreenstein(g), a, b), 1 / (4 * pi), 1e-7);
      EXPECT_NEAR(one_minus_cos_of_share(HenyeyGreenstein(g), 0.25f), 0.5, 1e-6);
    }
  }
}

TEST(HenyeyGreenstein, ShareInvertsTheCumulativeDistributionUpToBothEnds) {
  const float last = to_uniform(~std::uint64_t{0});
  for (const double g : kMeanCosines) {
    const HenyeyGreenstein hg(g);
    EXPECT_EQ(one_minus_cos_of_share(hg, 0), 0);
    EXPECT_NEAR(one_minus_cos_of_share(hg, 1), 2, 1e-6);
    EXPECT_LE(one_minus_cos_of_share(hg, 1), 2);
    EXPECT_GT(one_minus_cos_of_share(hg, last), 1.99);
    EXPECT_LE(one_minus_cos_of_share(hg, last), 2);
    float previous = 0;
    for (int i = 1; i < 1000; ++i) {
      const float u = float(i) / 1000, c = one_minus_cos_of_share(hg, u);
      EXPECT_GT(c, previous);
      EXPECT_NEAR(exact_cdf(std::abs(g), double(c)), double(u), 1e-6) << g;
      previous = c;
    }
    for (double u = 1e-3; u > 1e-18; u *= 0.1) {
      const double c = double(one_minus_cos_of_share(hg, float(u)));
      EXPECT_NEAR(exact_cdf(std::abs(g), c) / u, 1, 1e-6) << g << " " << u;
    }
  }
}

/// Equal cells of the unit square.
class Cells {
 public:
  void add(double a, double b) {
    const auto cell = [](double x) { return std::min(std::size_t(x * 8), std::size_t{7}); };
    ++counts_[cell(a) * 8 + cell(b)];
  }
  [[nodiscard]] double p_value() const { return proof::equal_counts_p_value(counts_); }

 private:
  std::array<std::uint64_t, 64> counts_{};
};

TEST(HenyeyGreenstein, SamplesHaveTheDensityAboutEveryDirection) {
  std::mt19937_64 random(proof::seeded(3));
  Family family;
  for (const double g : kMeanCosines) {
    const HenyeyGreenstein hg(g);
    Rng rng(proof::seeded(21), std::uint64_t(g * 1e4 + 1e4), 0);
    Histogram shares(16), azimuths(16);
    Cells joint;
    Moments from_peak_mean;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3f from = any_direction(random), to = sample_phase(hg, from, rng);
      const double c = from_peak(g, from, to);
      // A frame that knows nothing of the one in the code: from the axis farthest from `from`.
      const Vec3d n(from), axis = std::abs(n.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
      const Vec3d s = normalize(cross(n, axis)), t = cross(n, s);
      const double turns = 0.5 + std::atan2(dot(t, Vec3d(to)), dot(s, Vec3d(to))) / (2 * pi);
      const double share = std::min(1.0, exact_cdf(std::abs(g), c));
      shares.add(share);
      azimuths.add(turns);
      joint.add(share, turns);
      from_peak_mean.add(c);
    }
    family.add(name("distribution of the angle", g), shares.uniform_p_value());
    family.add(name("distribution of azimuth", g), azimuths.uniform_p_value());
    family.add(name("independence of the two", g), joint.p_value());
    family.add(name("mean cosine", g),
               proof::mean_p_value(from_peak_mean, 1 - std::abs(g), 1e-7 * (1 - std::abs(g))));
  }
  EXPECT_TRUE(family.passes());
}

/// On a commit one of two, by as many samples as are to find it there.
TEST(HenyeyGreenstein, AnErrorOfOnePerCentInGWouldBeFound) {
  const double wrong = proof::runs_all() ? 1.01 : 1.02;
  for (const double g : {0.5, 0.85}) {
    Rng rng(22, 0, 0);
    Histogram shares(16);
    Moments cosine;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3f from{0, 0, 1}, to = sample_phase(HenyeyGreenstein(wrong * g), from, rng);
      shares.add(std::min(1.0, exact_cdf(g, from_peak(g, from, to))));
      cosine.add(double(to.z));
    }
    EXPECT_LT(shares.uniform_p_value(), proof::sidak_level(proof::kFalseAlarmRate, 40)) << g;
    EXPECT_LT(proof::mean_p_value(cosine, g), proof::sidak_level(proof::kFalseAlarmRate, 40)) << g;
  }
}

TEST(HenyeyGreenstein, DirectionsKeepUnitLengthOverAMillionScatterings) {
  for (const double g : kMeanCosines) {
    const HenyeyGreenstein hg(g);
    Rng rng(23, 0, 0);
    Vec3f d{0, 0, 1};
    double worst = 0;
    for (int i = 0; i < 1'000'000; ++i) {
      d = sample_phase(hg, d, rng);
      worst = std::max(worst, std::abs(dot(Vec3d(d), Vec3d(d)) - 1));
    }
    EXPECT_LT(worst, 1e-6) << g;
    EXPECT_TRUE(is_finite(d)) << g << ": what was not a number once has stayed so";
  }
}

/// Directions where a frame may fail: axes with either zero, next to the poles, and some others.
std::vector<Vec3f> awkward_axes() {
  std::vector<Vec3f> axes;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      for (const float zero : {0.0f, -0.0f}) {
        Vec3f v(zero);
        v[axis] = sign;
        axes.push_back(v);
      }
    }
  }
  for (const double tilt : {1e-20, 1e-10, 1e-7, 1e-4, 1e-3}) {
    axes.push_back(Vec3f(normalize(Vec3d{tilt, 0, -1})));
    axes.push_back(Vec3f(normalize(Vec3d{-tilt, tilt, 1})));
    axes.push_back(Vec3f(normalize(Vec3d{1, tilt, -tilt})));
  }
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) axes.push_back(any_direction(random));
  return axes;
}

TEST(Turn, ReachesTheWholeSphereFromAnyAxis) {
  const float last = to_uniform(~std::uint64_t{0});
  for (const Vec3f axis : awkward_axes()) {
    for (const float u : {0.0f, 0.25f, 0.4f, 0.999f, last}) {
      EXPECT_LT(length(turn(axis, 0, u) - axis), 3e-7f);
      EXPECT_LT(length(turn(axis, 2, u) + axis), 3e-7f);
      for (const float c : {1e-30f, 1e-14f, 1e-8f, 1e-4f, 0.5f, 1.0f, 1.5f, 1.999999f}) {
        const Vec3f d = turn(axis, c, u);
        ASSERT_TRUE(is_finite(d));
        EXPECT_NEAR(dot(Vec3d(d), Vec3d(d)), 1, 5e-7);
        // An angle a is off by the rounding of directions, its 1 - cos = a^2 / 2 by a times that.
        const double a = std::sqrt(2 * double(c));
        EXPECT_NEAR(double(one_minus_cos(axis, d)), double(c), 3e-7 * a + 1e-13) << c << " " << u;
      }
    }
  }
}

TEST(Turn, OneMinusCosOfSmallAnglesKeepsItsDigits) {
  for (const double angle : {1e-6, 1e-4, 1e-2, 1.0, 3.0}) {
    const Vec3f a{0, 0, 1}, b(Vec3d{std::sin(angle), 0, std::cos(angle)});
    const double half = std::sin(angle / 2);
    EXPECT_NEAR(double(one_minus_cos(a, b)) / (2 * half * half), 1, 1e-6) << angle;
  }
}

const TwoLobes kTwoLobes[] = {{HenyeyGreenstein(0.9), HenyeyGreenstein(-0.4), 0.7},
                              {HenyeyGreenstein(0), HenyeyGreenstein(0.6), 0.2},
                              {HenyeyGreenstein(0.5), HenyeyGreenstein(-0.9), 0},
                              {HenyeyGreenstein(0.5), HenyeyGreenstein(-0.9), 1}};

TEST(TwoLobes, DensityIntegratesToOneAndItsMeanCosineIsStated) {
  for (const TwoLobes& p : kTwoLobes) {
    constexpr int kSteps = 200'000;
    double sum = 0, cosines = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double c = -1 + 2 * (i + 0.5) / kSteps;
      const Vec3f to(Vec3d(std::sqrt(1 - c * c), 0, c));
      const double part = double(pdf_phase(p, {0, 0, 1}, to)) * 4 * pi / kSteps;
      sum += part, cosines += c * part;
    }
    EXPECT_NEAR(sum, 1, 1e-4);
    EXPECT_NEAR(cosines, mean_cosine(p), 1e-4);
  }
}

TEST(TwoLobes, IsTheSameWithItsDirectionsExchangedOrBothReversed) {
  std::mt19937_64 random(7);
  for (const TwoLobes& p : kTwoLobes) {
    const Vec3f a = any_direction(random), b = any_direction(random);
    EXPECT_EQ(pdf_phase(p, a, b), pdf_phase(p, b, a));
    EXPECT_EQ(pdf_phase(p, a, b), pdf_phase(p, -a, -b));
  }
}

/// By chi-square over cosines, against the density; an error of 1 % in the share would be found.
TEST(TwoLobes, SamplesHaveTheDensityThatTheyState) {
  constexpr int kDraws = 400'000, kBins = 40;
  std::mt19937_64 random(8);
  Rng rng(3, 0, 0);
  for (const TwoLobes& p : kTwoLobes) {
    const auto chi_square = [&](const TwoLobes& sampled) {
      std::array<double, kBins> found{}, expected{};
      for (int i = 0; i < kDraws; ++i) {
        const Vec3f from = any_direction(random);
        const auto [u, azimuth] = rng.uniform2();
        const PhaseSample s = sample_phase(sampled, from, u, azimuth);
        EXPECT_EQ(s.pdf, pdf_phase(sampled, from, s.direction));
        const double c = double(dot(from, s.direction));
        ++found[std::size_t(std::clamp(int((c + 1) / 2 * kBins), 0, kBins - 1))];
      }
      constexpr int kSteps = 400;
      for (int i = 0; i < kBins * kSteps; ++i) {
        const double c = -1 + 2 * (i + 0.5) / (kBins * kSteps);
        const Vec3f to(Vec3d(std::sqrt(1 - c * c), 0, c));
        expected[std::size_t(i / kSteps)] +=
            kDraws * double(pdf_phase(p, {0, 0, 1}, to)) * 4 * pi / (kBins * kSteps);
      }
      double sum = 0;
      for (int i = 0; i < kBins; ++i) {
        const double e = expected[std::size_t(i)], d = found[std::size_t(i)] - e;
        sum += d * d / e;
      }
      return sum;
    };
    EXPECT_LT(chi_square(p), 85) << "39 degrees of freedom: beyond by chance once in 30 000";
    TwoLobes off = p;
    off.share += off.share > 0.5 ? -0.02 : 0.02;
    EXPECT_GT(chi_square(off), 85);
  }
}

}  // namespace phase_test
}  // namespace pvol
