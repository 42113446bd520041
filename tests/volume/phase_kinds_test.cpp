// Rayleigh, Draine, droplets and tables: densities and samples against forms written down anew in
// double, and what every phase function has to hold.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <string>

#include "pvol/error.h"
#include "pvol/volume/phase.h"
#include "support/messages.h"
#include "support/statistics.h"

namespace pvol {
namespace phase_kinds_test {

using proof::Family;
using proof::Histogram;
using std::numbers::pi;

/// A density per steradian of 1 - cos to the peak.
using Density = std::function<double(double)>;

Density henyey_greenstein(double g) {
  return [g](double c) {
    const double d = (1 - g) * (1 - g) + 2 * g * c;
    return (1 - g) * (1 + g) / (4 * pi * d * std::sqrt(d));
  };
}
Density rayleigh() {
  return [](double c) { return 3 / (16 * pi) * (1 + (1 - c) * (1 - c)); };
}
Density draine(double g, double alpha) {
  return [=, hg = henyey_greenstein(g)](double c) {
    return hg(c) * (1 + alpha * (1 - c) * (1 - c)) / (1 + alpha * (1 + 2 * g * g) / 3);
  };
}
/// For at least 5 micrometres, in the words of the paper.
Density droplets(double d) {
  const double w = std::exp(-0.599085 / (d - 0.641583) - 0.665888);
  return [w, hg = henyey_greenstein(std::exp(-0.0990567 / (d - 1.67154))),
          wide = draine(std::exp(-2.20679 / (d + 3.91029) - 0.428934),
                        std::exp(3.62489 - 8.29288 / (d + 5.52825)))](double c) {
    return (1 - w) * hg(c) + w * wide(c);
  };
}
Density table(std::vector<PhaseTable::Point> points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double width =
        std::cos(points[i - 1].angle * pi / 180) - std::cos(points[i].angle * pi / 180);
    sum += 2 * pi * width * 0.5 * (points[i - 1].value + points[i].value);
  }
  return [points, sum](double c) {
    std::size_t i = 1;
    const auto at = [&](std::size_t k) {
      return 2 * std::pow(std::sin(points[k].angle * pi / 360), 2);
    };
    while (i + 1 < points.size() && c > at(i)) ++i;
    const double t = (c - at(i - 1)) / (at(i) - at(i - 1));
    return ((1 - t) * points[i - 1].value + t * points[i].value) / sum;
  };
}

const std::vector<PhaseTable::Point> kPeaked{{0, 4000}, {0.2, 1500}, {1, 90},   {5, 4},
                                             {40, 0.1}, {90, 0.02},  {139, .3}, {180, 0.2}};
const std::vector<PhaseTable::Point> kWithGaps{{0, 0},  {30, 0},  {60, 3},
                                               {90, 0}, {120, 0}, {180, 7}};

struct Kind {
  std::string name;
  PhaseFunction phase;
  Density exact;
  float axis = 1;               ///< -1 where the peak is backward
  std::vector<double> kinks{};  ///< 1 - cos of places where the density is not smooth
};

std::vector<double> kinks_of(const std::vector<PhaseTable::Point>& points) {
  std::vector<double> all;
  for (const auto& p : points) all.push_back(2 * std::pow(std::sin(p.angle * pi / 360), 2));
  return all;
}

std::vector<Kind> kinds() {
  std::vector<Kind> all{
      {"isotropic", HenyeyGreenstein(0), [](double) { return 0.25 / pi; }},
      {"rayleigh", Rayleigh{}, rayleigh()},
      {"table with a peak", PhaseTable(kPeaked), table(kPeaked), 1, kinks_of(kPeaked)},
      {"table with gaps", PhaseTable(kWithGaps), table(kWithGaps), 1, kinks_of(kWithGaps)}};
  for (const double g : {-0.9, -0.3, 0.0, 1e-6, 0.5, 0.9, 0.9999}) {
    for (const double alpha : {0.0, 1.0, 40.0, kLargestAlpha}) {
      all.push_back({"draine " + std::to_string(g) + " " + std::to_string(alpha), Draine(g, alpha),
                     draine(std::abs(g), alpha), g < 0 ? -1.0f : 1.0f});
    }
  }
  for (const double d : {5.0, 20.0, kLargestDroplet}) {
    all.push_back({"droplets of " + std::to_string(d), Droplets(d), droplets(d)});
  }
  return all;
}

Vec3f any_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return Vec3f(normalize(Vec3d{x, y, z}));
}

/// The direction at c from +z.
Vec3f at_angle(double c) { return Vec3f(Vec3d{std::sqrt(c * (2 - c)), 0, 1 - c}); }

/// 1 - cos of directions as they were rounded to float, and by how much that may be off.
double measured(Vec3f from, Vec3f to) {
  const Vec3d d = Vec3d(to) - Vec3d(from);
  return std::min(2.0, 0.5 * dot(d, d));
}
double rounding(double c) { return 4e-7 * std::sqrt(c * (2 - c)) + 1e-12; }

/// Ends of steps over all c that are short at either peak and meet the kinks.
std::vector<double> ends_of_steps(const Kind& kind) {
  std::vector<double> ends{0, 2};
  for (double c = 1; c > 1e-12; c *= 0.99) ends.push_back(c), ends.push_back(2 - c);
  ends.insert(ends.end(), kind.kinks.begin(), kind.kinks.end());
  std::sort(ends.begin(), ends.end());
  return ends;
}

/// The integral of f(c) over [a, b] by Gauss's rule of three points.
template <class F>
double gauss(double a, double b, F f) {
  const double m = 0.5 * (a + b), h = 0.5 * (b - a), x = std::sqrt(0.6) * h;
  return h * (5 * f(m - x) + 8 * f(m) + 5 * f(m + x)) / 9;
}

/// The share of scattering at each end, from that before it on.
std::vector<double> shares(const std::vector<double>& ends, const Density& p) {
  std::vector<double> all{0};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    all.push_back(all.back() + 2 * pi * gauss(ends[i - 1], ends[i], p));
  }
  return all;
}

TEST(PhaseKinds, DensityIsTheClosedForm) {
  for (const Kind& k : kinds()) {
    for (double c = 1e-10; c < 2; c *= 1.07) {
      const Vec3f to = at_angle(c) * k.axis;
      const double at = measured({0, 0, k.axis}, to), exact = k.exact(at);
      // Next to a zero what counts is the rounding of directions.
      const double near =
          std::max(k.exact(std::max(0.0, at * (1 - 1e-6))), k.exact(at * (1 + 1e-6)));
      EXPECT_NEAR(double(pdf_phase(k.phase, {0, 0, 1}, to)), exact, 1e-5 * near + 1e-12)
          << k.name << " " << c;
    }
  }
}

TEST(PhaseKinds, DensityIntegratesToOneAndItsMeanCosineIsStated) {
  for (const Kind& k : kinds()) {
    double sum = 0, below = 0;
    const std::vector<double> ends = ends_of_steps(k);
    for (std::size_t i = 1; i < ends.size(); ++i) {
      const auto p = [&](double c) {
        return double(pdf_phase(k.phase, {0, 0, 1}, at_angle(c) * k.axis));
      };
      sum += 2 * pi * gauss(ends[i - 1], ends[i], p);
      below += 2 * pi * gauss(ends[i - 1], ends[i], [&](double c) { return c * p(c); });
    }
    EXPECT_NEAR(sum, 1, 1e-5) << k.name;
    // All digits of 1 - cos where the peak is ahead.
    const double expected = 1 - double(k.axis) * mean_cosine(k.phase);
    EXPECT_NEAR(below / expected, 1, 2e-5) << k.name;
  }
}

TEST(PhaseKinds, AreTheSameWithTheirDirectionsExchangedOrBothReversed) {
  std::mt19937_64 random(1);
  for (const Kind& k : kinds()) {
    for (int i = 0; i < 200; ++i) {
      const Vec3f a = any_direction(random), b = any_direction(random);
      const float there = pdf_phase(k.phase, a, b);
      EXPECT_EQ(there, pdf_phase(k.phase, b, a)) << k.name;
      EXPECT_EQ(there, pdf_phase(k.phase, -a, -b)) << k.name;
      EXPECT_GT(there, 0) << k.name;
    }
  }
}

/// By u: the angle within which the share u lies. Of mixtures one lobe comes before the other.
TEST(PhaseKinds, ShareInvertsTheCumulativeDistribution) {
  for (const Kind& k : kinds()) {
    if (std::holds_alternative<Droplets>(k.phase)) continue;
    const std::vector<double> ends = ends_of_steps(k), all = shares(ends, k.exact);
    for (const float u : {0.0f, 1e-7f, 1e-3f, 0.1f, 0.3f, 0.4999f, 0.5f, 0.51f, 0.8f, 0.97f,
                          to_uniform(~std::uint64_t{0})}) {
      const PhaseSample s = sample_phase(k.phase, {0, 0, 1}, u, 0.3f);
      const double c = measured({0, 0, k.axis}, s.direction);
      const auto i =
          std::clamp(std::size_t(std::upper_bound(ends.begin(), ends.end(), c) - ends.begin()),
                     std::size_t{1}, ends.size() - 1);
      const double share = all[i - 1] + 2 * pi * gauss(ends[i - 1], std::min(c, ends[i]), k.exact);
      EXPECT_NEAR(share, double(u), 1e-6 + 2 * pi * k.exact(c) * rounding(c)) << k.name;
    }
  }
}

/// The share of the densest directions about the forward peak keeps its digits.
TEST(PhaseKinds, SharesOfPeaksKeepTheirDigits) {
  for (const double alpha : {0.0, 1.0, 250.0}) {
    for (const double g : {0.0, 0.9, 0.9999}) {
      for (double u = 1e-3; u > 1e-18; u *= 0.1) {
        const double c = double(one_minus_cos_of_share(Draine(g, alpha), float(u)));
        const auto p = draine(g, alpha);
        double share = 0, before = 0;
        for (int i = 1; i <= 1000; ++i) {
          share += 2 * pi * gauss(before, c * i / 1000, p);
          before = c * i / 1000;
        }
        EXPECT_NEAR(share / u, 1, 1e-6) << g << " " << alpha << " " << u;
      }
    }
  }
  for (double u = 1e-4; u > 1e-18; u *= 0.1) {
    const double c = double(one_minus_cos_of_share(Rayleigh{}, float(u)));
    EXPECT_NEAR(3.0 / 8 * c * (2 - c + c * c / 3) / u, 1, 1e-6) << u;
  }
}

/// By chi-square over strata of equal share of the exact density, about any direction.
TEST(PhaseKinds, SamplesHaveTheDensityThatTheyState) {
  const int kDraws = proof::samples<int>(200'000);
  std::mt19937_64 random(proof::seeded(8));
  Family family;
  std::uint64_t number = 0;
  for (const Kind& k : kinds()) {
    Rng rng(proof::seeded(31), number++, 0);
    Histogram by_share(32), azimuths(16);
    const std::vector<double> ends = ends_of_steps(k), all = shares(ends, k.exact);
    for (int i = 0; i < kDraws; ++i) {
      const Vec3f from = any_direction(random);
      const auto [u, azimuth] = rng.uniform2();
      const PhaseSample s = sample_phase(k.phase, from, u, azimuth);
      const double c = measured(from * k.axis, s.direction);
      const auto j =
          std::clamp(std::size_t(std::upper_bound(ends.begin(), ends.end(), c) - ends.begin()),
                     std::size_t{1}, ends.size() - 1);
      const double exact = k.exact(c), change = rounding(c);
      const double slack = std::max(std::abs(k.exact(std::max(0.0, c - change)) - exact),
                                    std::abs(k.exact(std::min(2.0, c + change)) - exact));
      ASSERT_NEAR(double(s.pdf), exact, 1e-5 * exact + slack + 1e-9) << k.name << " " << c;
      by_share.add(std::clamp(
          all[j - 1] + 2 * pi * gauss(ends[j - 1], std::min(c, ends[j]), k.exact), 0.0, 1.0));
      const Vec3d n(from), axis = std::abs(n.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
      const Vec3d a = normalize(cross(n, axis)), b = cross(n, a);
      azimuths.add(0.5 +
                   std::atan2(dot(b, Vec3d(s.direction)), dot(a, Vec3d(s.direction))) / (2 * pi));
    }
    family.add(k.name + ", angle", by_share.uniform_p_value());
    family.add(k.name + ", azimuth", azimuths.uniform_p_value());
  }
  EXPECT_TRUE(family.passes());
}

TEST(Draine, IsHenyeyGreensteinWithoutAlphaAndRayleighWithItAlone) {
  for (double c = 1e-9; c < 2; c *= 1.3) {
    for (const double g : {-0.7, 0.0, 0.4, 0.95}) {
      const Vec3f to = at_angle(c), z(0, 0, 1);
      EXPECT_EQ(pdf_phase(Draine(g, 0), z, to), pdf_phase(HenyeyGreenstein(g), z, to));
    }
    EXPECT_NEAR(pdf_of_angle(Draine(0, 1), float(c)) / pdf_of_angle(Rayleigh{}, float(c)), 1, 1e-6);
  }
  for (int i = 0; i <= 1000; ++i) {
    const float u = float(i) / 1000;
    const float hg = one_minus_cos_of_share(HenyeyGreenstein(0.8), u);
    EXPECT_NEAR(one_minus_cos_of_share(Draine(0.8, 0), u), hg, 3e-6f * hg);
    EXPECT_NEAR(one_minus_cos_of_share(Draine(0, 1), u), one_minus_cos_of_share(Rayleigh{}, u),
                3e-7);
  }
  EXPECT_EQ(mean_cosine(Draine(0.8, 0)), 0.8);
  EXPECT_EQ(mean_cosine(Draine(0, 1)), 0);
}

TEST(Rayleigh, HasTwiceAsMuchAheadAsAside) {
  const Vec3f z(0, 0, 1);
  EXPECT_NEAR(pdf_phase(Rayleigh{}, z, z), 3 / (8 * pi), 1e-7);
  EXPECT_NEAR(pdf_phase(Rayleigh{}, z, -z), 3 / (8 * pi), 1e-7);
  EXPECT_NEAR(pdf_phase(Rayleigh{}, z, Vec3f(1, 0, 0)), 3 / (16 * pi), 1e-7);
}

/// Below all ranges of the fit lies Rayleigh's limit; its ranges meet, as nearly as they were
/// fitted.
TEST(Droplets, TendToRayleighAndTheirRangesMeet) {
  const Droplets tiny(1e-4);
  const Vec3f z(0, 0, 1);
  for (double c = 0.01; c < 2; c += 0.05) {
    EXPECT_NEAR(pdf_phase(tiny, z, at_angle(c)) / pdf_phase(Rayleigh{}, z, at_angle(c)), 1, 0.01);
  }
  for (const double end : {0.1, 1.5, 5.0}) {
    const Droplets below(end * (1 - 1e-9)), above(end * (1 + 1e-9));
    EXPECT_NEAR(mean_cosine(below), mean_cosine(above), 0.03) << end;
  }
  for (double d = 1e-3; d <= kLargestDroplet; d *= 1.01) {
    const Droplets p(d);
    EXPECT_TRUE(p.wide_share >= 0 && p.wide_share <= 1) << d;
    EXPECT_TRUE(std::abs(p.peak.mean_cosine) <= kLargestMeanCosine) << d;
    EXPECT_TRUE(std::abs(p.wide.lobe.mean_cosine) < 1 && p.wide.alpha >= 0) << d;
  }
}

/// Figures worked out apart, in every range.
TEST(Droplets, HaveTheFitOfTheirRange) {
  struct Row {
    double diameter, peak_g, wide_g, alpha, wide_share;
  };
  for (const Row& r :
       {Row{0.05, 0.0345, 0.02566118, 250, 0.2521807}, Row{0.1, 0.138, 0.09176806, 250, 0.2372907},
        Row{0.7, 0.843808, 0.6781032, 250, 0.3787337},
        Row{1.2, 0.8572465, 0.3713289, 250, 0.1963063},
        Row{2.5, 0.9349676, 0.3914669, 13.00892, 0.3799337},
        Row{4.5, 0.9649481, 0.4942684, 17.30184, 0.4318246},
        Row{20, 0.99461, 0.5937906, 27.11369, 0.4981595}}) {
    const Droplets p(r.diameter);
    EXPECT_NEAR(p.peak.mean_cosine / r.peak_g, 1, 1e-6) << r.diameter;
    EXPECT_NEAR(p.wide.lobe.mean_cosine / r.wide_g, 1, 1e-6) << r.diameter;
    EXPECT_NEAR(p.wide.alpha / r.alpha, 1, 1e-6) << r.diameter;
    EXPECT_NEAR(p.wide_share / r.wide_share, 1, 1e-6) << r.diameter;
  }
}

/// Of clouds: by Mie's theory their droplets have mean cosines of 0.84 to 0.88.
TEST(Droplets, OfCloudsScatterForwardAsMieSays) {
  for (const double d : {10.0, 20.0, 30.0}) EXPECT_NEAR(mean_cosine(Droplets(d)), 0.86, 0.03) << d;
}

TEST(PhaseTable, IsTheSameInAnyUnitAndComparesByValue) {
  std::vector<PhaseTable::Point> larger = kPeaked;
  for (auto& p : larger) p.value *= 1e300;
  const PhaseTable a(kPeaked), b(larger), c(kPeaked);
  const Vec3f x(1, 0, 0), y(0, 1, 0);
  EXPECT_NEAR(pdf_phase(a, x, y) / pdf_phase(b, x, y), 1, 1e-6);
  EXPECT_EQ(a, c);
  EXPECT_NE(a, b);
  EXPECT_NEAR(pdf_phase(PhaseTable(), x, y), 0.25 / pi, 1e-8);
  EXPECT_NEAR(mean_cosine(PhaseTable()), 0, 1e-15);
}

TEST(PhaseTable, OfAKnownFunctionTendsToIt) {
  std::vector<PhaseTable::Point> points;
  for (int i = 0; i <= 1800; ++i) {
    const double c = 2 * std::pow(std::sin(i * pi / 3600), 2);
    points.push_back({i * 0.1, draine(0.6, 3)(c)});
  }
  points.back().angle = 180;
  const PhaseTable p(points);
  EXPECT_NEAR(mean_cosine(p), mean_cosine(Draine(0.6, 3)), 1e-5);
  for (const float u : {0.01f, 0.4f, 0.9f}) {
    const Vec3f z(0, 0, 1);
    EXPECT_NEAR(sample_phase(p, z, u, 0).direction.z,
                sample_phase(Draine(0.6, 3), z, u, 0).direction.z, 2e-5);
  }
}

TEST(PhaseTable, RefusesWhatIsNoTable) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const std::pair<std::vector<PhaseTable::Point>, std::string> cases[] = {
      {{}, "phase.expected_least_two"},
      {{{0, 1}}, "phase.expected_least_two"},
      {{{0, 1}, {90, 1}}, "phase.expected_angles_degrees"},
      {{{1, 1}, {180, 1}}, "phase.expected_angles_degrees"},
      {{{0, 1}, {90, 1}, {90, 2}, {180, 1}}, "phase.expected_ascending_angles"},
      {{{0, 1}, {nan, 1}, {180, 1}}, "phase.expected_ascending_angles"},
      {{{0, 1}, {180, -1}}, "phase.expected_values_finite"},
      {{{0, nan}, {180, 1}}, "phase.expected_values_finite"},
      {{{0, inf}, {180, 1}}, "phase.expected_values_finite"},
      {{{0, 0}, {180, 0}}, "phase.expected_values_not"},
      {{{0, 1}, {1e-3, 0}, {180, 0}}, "phase.expected_peak_wider"},
      {{{0, 1}, {1e-200, 0}, {180, 0}}, "phase.expected_peak_wider"},
  };
  for (const auto& [points, key] : cases) {
    try {
      (void)PhaseTable(points);
      ADD_FAILURE() << key;
    } catch (const Error& e) {
      EXPECT_TRUE(says(e.what(), key));
    }
  }
}

}  // namespace phase_kinds_test
}  // namespace pvol
