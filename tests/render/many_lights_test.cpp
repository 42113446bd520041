// Drawing some of many lights: the weights of groups, the tree, and pictures by what is drawn.
#include "render/light/many_lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/light/lamp.h"
#include "render/light/met_lights.h"
#include "support/surface_pixel.h"

namespace pvol {
namespace many_lights_test {

using detail::AlongFlight;
using detail::AtPlace;
using detail::LightCut;
using detail::LightGroups;
using detail::LightKernel;
using detail::ManyLights;
using detail::OnPlane;

Vec3d random_place(Rng& rng, double reach) {
  const auto [x, y, z, w] = rng.uniform4();
  return (Vec3d(double(x), double(y), double(z)) - Vec3d(0.5)) * (2 * reach);
}

/// What a light of power 1 that shines evenly brings, in doubles.
double brought(const AtPlace& at, Vec3d light) {
  const Vec3d way = light - at.place;
  return 1 / dot(way, way);
}
double brought(const OnPlane& at, Vec3d light) {
  const Vec3d way = light - at.place;
  return std::max(0.02, dot(normalize(way), at.normal)) / dot(way, way);
}
double brought(const AlongFlight& at, Vec3d light) {
  const double t = std::clamp(dot(light - at.from, at.direction), 0.0, at.length);
  const double apart = length(light - at.from - at.direction * t);
  return 1 / (apart * apart + apart * at.length / std::numbers::pi);
}

LightGroups random_groups(std::size_t count, Rng& rng) {
  LightGroups g;
  for (std::size_t n = 0; n < count; ++n) {
    g.add_group();
    for (std::size_t k = 0; k + n < LightGroups::kGroup; ++k) {  // each with one more missing
      const std::size_t i = n * LightGroups::kGroup + k;
      const Vec3d place = random_place(rng, 5);
      for (int axis = 0; axis < 3; ++axis) g.place[std::size_t(axis)][i] = place[axis];
      g.power[i] = rng.uniform() + 0.1f;
      g.radius[i] = k % 3 == 0 ? rng.uniform() * 3 : 0;
    }
  }
  return g;
}

template <class Where>
void expect_weights(const LightGroups& g, const Where& at) {
  constexpr std::size_t kGroup = LightGroups::kGroup;
  const std::vector<LightKernel> kernels = detail::light_kernels();
  for (std::size_t n = 0; n < g.count_groups(); ++n) {
    float expected[kGroup];
    const std::uint32_t near = kernels.back().weigh(g, n, at, expected);
    for (std::size_t k = 0; k < kGroup; ++k) {
      const std::size_t i = n * kGroup + k;
      const Vec3d place(g.place[0][i], g.place[1][i], g.place[2][i]);
      const double exact = double(g.power[i]) * (g.power[i] > 0 ? brought(at, place) : 1);
      EXPECT_NEAR(double(expected[k]), exact, 1e-5 * exact);
    }
    for (const LightKernel& kernel : kernels) {
      float weights[kGroup];
      EXPECT_EQ(kernel.weigh(g, n, at, weights), near);
      for (std::size_t k = 0; k < kGroup; ++k) EXPECT_EQ(weights[k], expected[k]);
    }
  }
}

TEST(LightWeights, AreWhatLightsBringToTheSameBitsInEveryKernel) {
  Rng rng(1, 0, 0);
  const LightGroups g = random_groups(LightGroups::kGroup, rng);
  for (int n = 0; n < 50; ++n) {
    const Vec3d place = random_place(rng, 6), direction = normalize(random_place(rng, 1));
    expect_weights(g, AtPlace{place});
    expect_weights(g, OnPlane{place, direction});
    expect_weights(g, AlongFlight{place, direction, 0.1 + n});
  }
}

TEST(LightWeights, AreMultipliedByFactorsOfTheirNumbers) {
  constexpr std::size_t kGroup = LightGroups::kGroup;
  std::vector<float> factors;
  std::vector<std::uint32_t> numbers;
  for (std::size_t k = 0; k < 100; ++k) factors.push_back(0.5f + float(k));
  for (std::size_t k = 0; k < kGroup; ++k) numbers.push_back(std::uint32_t(37 * k % 100));
  for (const LightKernel& kernel : detail::light_kernels()) {
    float weights[kGroup];
    for (std::size_t k = 0; k < kGroup; ++k) weights[k] = float(k % 5);
    kernel.multiply(factors.data(), numbers.data(), weights);
    for (std::size_t k = 0; k < kGroup; ++k) {
      EXPECT_EQ(weights[k], float(k % 5) * factors[numbers[k]]);
    }
  }
}

TEST(LightWeights, TellWhatIsNear) {
  LightGroups g;
  g.add_group();
  g.power[0] = g.power[1] = g.power[2] = 1;
  g.radius[0] = g.radius[1] = 1;
  g.place[0][1] = 5;
  float weights[LightGroups::kGroup];
  for (const LightKernel& kernel : detail::light_kernels()) {
    EXPECT_EQ(kernel.weigh(g, 0, AtPlace{{0.5, 0, 0}}, weights), 1u) << "a point has no inside";
    EXPECT_EQ(kernel.weigh(g, 0, AtPlace{{5, 1.9, 0}}, weights), 2u);
    EXPECT_EQ(kernel.weigh(g, 0, AtPlace{{5, 2.1, 0}}, weights), 0u);
    EXPECT_EQ(kernel.weigh(g, 0, AlongFlight{{-1, 1, 0}, {1, 0, 0}, 8}, weights), 3u);
    EXPECT_EQ(kernel.weigh(g, 0, AlongFlight{{2.1, 0, 0}, {1, 0, 0}, 0.5}, weights), 0u);
  }
}

TEST(LightWeights, AreAboveZeroAndFiniteAtTheEnds) {
  LightGroups g;
  g.add_group();
  g.power[0] = 1, g.power[1] = 1e-20f;
  float weights[LightGroups::kGroup];
  for (const LightKernel& kernel : detail::light_kernels()) {
    for (const double far : {0.0, 1e-30, 1.0, 1e15, 1e30}) {
      kernel.weigh(g, 0, AtPlace{Vec3d(far)}, weights);
      for (int k = 0; k < 2; ++k) EXPECT_TRUE(weights[k] > 0 && weights[k] < 1e35f) << far;
      kernel.weigh(g, 0, OnPlane{Vec3d(far), {0, 1, 0}}, weights);
      for (int k = 0; k < 2; ++k) EXPECT_TRUE(weights[k] > 0 && weights[k] < 1e35f) << far;
      kernel.weigh(g, 0, AlongFlight{Vec3d(far), {0, 1, 0}, 1e3}, weights);
      for (int k = 0; k < 2; ++k) EXPECT_TRUE(weights[k] > 0 && weights[k] < 1e35f) << far;
      EXPECT_EQ(weights[2], 0);
    }
  }
}

/// Points and balls in heaps of several sizes, some of them at one place.
std::vector<Light> heaps(int count, Rng& rng) {
  std::vector<Light> lights;
  Vec3d heap(0.0);
  for (int k = 0; k < count; ++k) {
    if (k % 9 == 0) heap = random_place(rng, 10);
    const Vec3d place = k % 5 == 0 ? heap : heap + random_place(rng, k % 2 == 0 ? 0.1 : 2);
    lights.push_back(PointLight{place, Rgb(0.1f + rng.uniform()), {}, k % 4 == 0 ? 0.05 : 0});
  }
  return lights;
}

std::vector<Light> of_all_kinds(Rng& rng) {
  std::vector<Light> lights{Sun{{1, 2, 3}, Rgb(0.3f), 1}};
  for (const Light& light : heaps(300, rng)) lights.push_back(light);
  lights.push_back(PointLight{{1, 1, 1}, Rgb(0.0f)});
  for (int k = 0; k < 120; ++k) {
    lights.push_back(SpotLight{.position = random_place(rng, 8),
                               .direction = random_place(rng, 1),
                               .intensity = Rgb(3.0f),
                               .angle = 120});
    lights.push_back(AreaLight{
        .position = random_place(rng, 8), .direction = random_place(rng, 1), .size = {0.3, 0.2}});
  }
  return lights;
}

double brings(const LightSource& light, const AtPlace& at) {
  return double(luminance(std::visit(
      [&](const auto& l) {
        return l.irradiance_on({at.place, at.place});
      },
      light)));
}
double brings(const LightSource& light, const OnPlane& at) {
  return double(
      luminance(std::visit([&](const auto& l) { return l.on_plane(at.place, at.normal); }, light)));
}
double brings(const LightSource& light, const AlongFlight& at) {
  const detail::Lamp lamp = detail::lamp_of(light);
  return lamp.power * brought(at, lamp.position);
}

/// The sum of what lights bring, each counted by another factor, by those that are drawn.
template <class Where>
void expect_sum(std::span<const Light> of, const Where& at, proof::Family& family) {
  const ManyLights many(of);
  const std::vector<LightSource> lights = make_light_sources(of);
  LightCut cut;
  Rng rng(3, 0, 0);
  std::vector<double> parts;
  double expected = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    parts.push_back(brings(lights[i], at) * (0.2 + double(i * 7 % 10)));
    expected += parts.back();
  }
  std::vector<float> importances;
  for (std::size_t i = 0; i < lights.size(); ++i) importances.push_back(i % 2 == 1 ? 7.0f : 1.0f);
  proof::Moments sums;
  for (int n = 0; n < proof::samples(100'000); ++n) {
    double sum = 0;
    many.draw(at, 4, importances.data(), cut, rng,
              [&](std::size_t i, float times) { sum += parts[i] * double(times); });
    sums.add(sum);
  }
  const double error = std::sqrt(sums.variance_of_mean());
  EXPECT_LT(error, 0.01 * expected);
  family.add("sum", proof::normal_p_value((sums.mean() - expected) / error));
}

TEST(ManyLights, AddUpToWhatAllBring) {
  Rng rng(2, 0, 0);
  const std::vector<Light> lights = of_all_kinds(rng);
  proof::Family family;
  for (const Vec3d place : {Vec3d(0.3), Vec3d(9, -4, 2), Vec3d(100, 0, 30)}) {
    expect_sum(lights, AtPlace{place}, family);
    expect_sum(lights, AlongFlight{place, normalize(Vec3d(-3, -2, -1)), 12}, family);
    expect_sum(lights, OnPlane{place - Vec3d(0, 5, 0), {0, 1, 0}}, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Lamps in a grid that shine down, nearly.
std::vector<Light> shining_down(bool spots) {
  std::vector<Light> lights;
  for (int k = 0; k < 400; ++k) {
    const Vec3d place(k % 20 - 9.5, 0, k / 20 - 9.5);
    const Vec3d down(0.08 * std::sin(k), -1, 0.08 * std::cos(3 * k));
    if (spots) {
      lights.push_back(SpotLight{.position = place, .direction = down, .angle = 40});
    } else {
      lights.push_back(AreaLight{.position = place, .direction = down, .size = {0.2, 0.1}});
    }
  }
  return lights;
}

TEST(ManyLights, ThatDoNotShineEvenlyAddUpWithinTheirCones) {
  proof::Family family;
  for (const bool spots : {true, false}) {
    const std::vector<Light> lights = shining_down(spots);
    for (const Vec3d place : {Vec3d(0.2, -30, 0.1), Vec3d(14, -20, 3), Vec3d(2.2, -3, 1.6)}) {
      expect_sum(lights, AtPlace{place}, family);
      expect_sum(lights, OnPlane{place, {0, 1, 0}}, family);
    }
    // Beyond all cones none is drawn, from afar or from near.
    const ManyLights many(lights);
    LightCut cut;
    Rng rng(8, 0, 0);
    for (const Vec3d dark : {Vec3d(0, 40, 0), Vec3d(0.3, 2, 0.2), Vec3d(90, 20, 0)}) {
      many.draw(AtPlace{dark}, 4, nullptr, cut, rng, [](std::size_t, float) { ADD_FAILURE(); });
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Near the middle of a rectangle, which fills half of the view, points are not forgotten.
TEST(ManyLights, BesideALargeRectangleAreNotForgotten) {
  Rng rng(9, 0, 0);
  std::vector<Light> lights = heaps(100, rng);
  lights.push_back(AreaLight{.position = {0, 0, 0}, .direction = {0, 1, 0}, .size = {2, 2}});
  const std::vector<LightSource> sources = make_light_sources(lights);
  const ManyLights many(lights);
  LightCut cut;
  const AtPlace at{{0.1, 0.05, 0}};
  proof::Moments sums;
  double all = 0;
  for (const LightSource& light : sources) all += brings(light, at);
  for (int k = 0; k < 20'000; ++k) {
    double sum = 0;
    many.draw(at, 4, nullptr, cut, rng,
              [&](std::size_t i, float times) { sum += brings(sources[i], at) * double(times); });
    sums.add(sum);
  }
  EXPECT_NEAR(sums.mean(), all, 0.02 * all);
  EXPECT_LT(std::sqrt(sums.variance()), 0.3 * all);
}

/// What the lights bring all together is known from one draw of four where nothing is in the way.
TEST(ManyLights, BringAboutTheSameWhicheverAreDrawn) {
  Rng rng(4, 0, 0);
  const std::vector<Light> heap = heaps(1000, rng);
  const std::vector<LightSource> lights = make_light_sources(heap);
  const ManyLights many(heap);
  LightCut cut;
  for (int n = 0; n < 20; ++n) {
    const AtPlace at{random_place(rng, 12)};
    proof::Moments sums;
    for (int k = 0; k < 200; ++k) {
      double sum = 0;
      many.draw(at, 4, nullptr, cut, rng, [&](std::size_t i, float times) {
        const auto bring = [&](const auto& l) { return l.irradiance_on({at.place, at.place}); };
        sum += double(luminance(std::visit(bring, lights[i])) * times);
      });
      sums.add(sum);
    }
    EXPECT_LT(std::sqrt(sums.variance()), 0.1 * sums.mean());
  }
}

TEST(ManyLights, AreLookedIntoWhereTheyAreNear) {
  std::vector<Light> lights;
  for (int k = 0; k < 10'000; ++k) {
    lights.push_back(PointLight{{double(k % 100), 0, double(k / 100)}, Rgb(1.0f)});
  }
  const ManyLights many(lights);
  LightCut cut;
  Rng rng(5, 0, 0);
  const auto groups = [&](const auto& at) {
    many.draw(at, 2, nullptr, cut, rng, [](std::size_t, float) {});
    return cut.groups.size();
  };
  EXPECT_LT(groups(AtPlace{{50, 1, 50}}), 40u);
  EXPECT_LT(groups(OnPlane{{50, -1, 50}, {0, 1, 0}}), 40u);
  EXPECT_EQ(groups(AtPlace{{50, 500, 50}}), 1u) << "from afar all are one group";
  EXPECT_LT(groups(AlongFlight{{0, 1, 0}, normalize(Vec3d(1, 0, 1)), 140}), 200u);
}

TEST(ManyLights, OfNoPowerAreNeverDrawn) {
  const std::vector<Light> lights{PointLight{{1, 2, 3}, Rgb(0.0f)}, PointLight{{1, 2, 3}},
                                  SpotLight{.intensity = Rgb(0.0f)}};
  const ManyLights many(lights);
  LightCut cut;
  Rng rng(6, 0, 0);
  int asked = 0;
  many.draw(AtPlace{{1, 2, 3}}, 4, nullptr, cut, rng, [&](std::size_t i, float times) {
    EXPECT_EQ(i, 1u);
    EXPECT_EQ(times, 0.25f);
    ++asked;
  });
  EXPECT_EQ(asked, 4);
  const std::vector<Light> black{PointLight{{}, Rgb(0.0f)}};
  const ManyLights dark(black);
  dark.draw(AtPlace{}, 4, nullptr, cut, rng, [](std::size_t, float) { ADD_FAILURE(); });
}

TEST(MetLights, AreAllVisitedThatARayMeets) {
  Rng rng(7, 0, 0);
  const std::vector<LightSource> lights = make_light_sources(of_all_kinds(rng));
  const detail::MetLights met(lights);
  ASSERT_TRUE(met.any());
  const std::vector<Light> points{Sun{}, PointLight{}, SpotLight{}};
  EXPECT_FALSE(detail::MetLights(make_light_sources(points)).any());
  int hits = 0, visits = 0;
  for (int n = 0; n < 20'000; ++n) {
    const Ray ray{random_place(rng, 12), normalize(random_place(rng, 1))};
    std::vector<std::size_t> visited;
    met.visit(ray, 10, [&](std::size_t i) { visited.push_back(i); });
    visits += int(visited.size());
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const auto meet = [&](const auto& l) { return l.met(ray, 10); };
      if (!(std::visit(meet, lights[i]).radiance.x > 0)) continue;
      EXPECT_TRUE(std::ranges::count(visited, i) == 1) << i;
      ++hits;
    }
  }
  EXPECT_GT(hits, 20);
  EXPECT_LT(visits, 20'000 * 10);
}

/// Ground below a cube that absorbs, with lamps of all colours above it.
struct BelowACube {
  test::Body body = test::component(0.15, Rgb(0.0f), 0, Rgb(0.0f), translation({-6, 2, -6}));
  test::Pixel pixel{body, {9, 0.4, 0}, {0, 0, 0}};
  Vec3d expected{0.0};

  explicit BelowACube(int lamps) {
    pixel.scene.surfaces = {test::ground(0.6)};
    for (int k = 0; k < lamps; ++k) {
      const double angle = 2.4 * k, apart = 1.5 + 12.0 * k / lamps;
      const Vec3d place(apart * std::cos(angle), 16 + k % 3, apart * std::sin(angle));
      const Rgb intensity{float(60 + k % 7 * 20), float(40 + k % 5 * 30), float(200 - k % 4 * 40)};
      pixel.scene.lights.push_back(PointLight{place, intensity});
      const double depth = test::optical_depth({&body, 1}, {{0, 0, 0}, normalize(place)}, 1e9);
      const double cosine = place.y / length(place);
      expected = expected + Vec3d(intensity) * (0.6 / std::numbers::pi * cosine * std::exp(-depth) /
                                                dot(place, place));
    }
  }
};

TEST(ManyLights, OnGroundBelowAVolumeBringWhatPasses) {
  proof::Family family;
  for (const int lamps : {1, 2, 3, 12, 16, 17, 40, 300}) {
    BelowACube b(lamps);
    b.pixel.scene.options.samples = proof::samples(300'000);
    const PixelSums p = b.pixel.sums();
    for (int channel = 0; channel < 3; ++channel) {
      const double expected = b.expected[channel], off = mean(p)[channel] - expected;
      const double error = std::sqrt(variance_of_mean(p)[channel]);
      EXPECT_LT(error, 0.01 * expected) << "too few samples to tell";
      family.add(std::to_string(lamps), proof::normal_p_value(off / error));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Spots that shine past a cube but for one of its faces: what falls on it is told as nothing.
TEST(ManyLights, OfUnknownWorthArriveThroughVolumes) {
  const test::Body body = test::component(0.1, Rgb(0.0f), 0, Rgb(0.0f), translation({-6, 2, -6}));
  test::Pixel p(body, {9, 0.4, 0}, {6, 0, 0});
  p.scene.surfaces = {test::ground(0.6)};
  double expected = 0;
  for (const double shift : {0.0, 0.1, -0.1}) {
    const Vec3d place(6.8, 20, shift), way = place - Vec3d(6, 0, 0);
    p.scene.lights.push_back(SpotLight{.position = place,
                                       .direction = {0, -1, 0},
                                       .intensity = Rgb(100.0f),
                                       .angle = 10,
                                       .blend = 0});
    const double depth = test::optical_depth({&body, 1}, {{6, 0, 0}, normalize(way)}, 1e9);
    ASSERT_GT(depth, 0.5);
    expected +=
        100 * 0.6 / std::numbers::pi * way.y / length(way) * std::exp(-depth) / dot(way, way);
  }
  proof::Family family;
  test::expect_mean(p.sums(), expected, "spots", family);
  EXPECT_TRUE(family.passes());
}

}  // namespace many_lights_test
}  // namespace pvol
