// Pictures of skies, and what samples of them must be like.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "pvol/render/sky_light.h"
#include "support/statistics.h"

namespace pvol::test {

/// A picture and the integrals that the tests compare with.
struct TestSky {
  static constexpr double kPi = std::numbers::pi;
  std::string name;
  ImageSky sky;

  [[nodiscard]] Rgb pixel(int x, int y) const {
    return sky.pixels[std::size_t(y) * std::size_t(sky.width) + std::size_t(x)] * sky.scale;
  }
  /// The direction at (x, y) in pixels, by the convention of ImageSky.
  [[nodiscard]] Vec3f direction(double x, double y) const {
    const double azimuth = 2 * kPi * x / sky.width + sky.rotation * kPi / 180;
    const double theta = kPi * y / sky.height;
    return Vec3f(upright(Vec3d{std::sin(theta) * std::cos(azimuth), std::cos(theta),
                               std::sin(theta) * std::sin(azimuth)}));
  }
  /// Turned by the shortest way from +y to up: half turns about +y and about the middle of both.
  [[nodiscard]] Vec3d upright(Vec3d v) const {
    if (sky.up == Vec3d(0, 1, 0)) return v;
    const Vec3d y(0, 1, 0), middle = normalize(y + normalize(sky.up));
    const auto half_turn = [](Vec3d about, Vec3d u) { return about * (2 * dot(about, u)) - u; };
    return half_turn(middle, half_turn(y, v));
  }
  [[nodiscard]] double solid_angle(int y) const {
    // cos a - cos b, without its cancellation.
    return 2 * kPi / sky.width * 2 * std::sin(kPi * (y + 0.5) / sky.height) *
           std::sin(kPi * 0.5 / sky.height);
  }
  template <class F>
  void for_each_pixel(F f) const {
    for (int y = 0; y < sky.height; ++y) {
      for (int x = 0; x < sky.width; ++x) f(x, y);
    }
  }
};

inline TestSky make_picture(std::string name, int width, int height) {
  TestSky p{std::move(name), {width, height, {}, Rgb(1.0f), 0}};
  p.sky.pixels.edit().assign(std::size_t(width) * std::size_t(height), Rgb(0.0f));
  return p;
}

inline void set(TestSky& p, int x, int y, Rgb c) {
  p.sky.pixels.edit()[std::size_t(y) * std::size_t(p.sky.width) + std::size_t(x)] = c;
}

inline TestSky noise_picture(int width, int height, unsigned seed) {
  TestSky p =
      make_picture("noise " + std::to_string(width) + "x" + std::to_string(height), width, height);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.1f, 2);
  for (Rgb& c : p.sky.pixels.edit()) c = {uniform(random), uniform(random), uniform(random)};
  return p;
}

inline std::vector<TestSky> pictures() {
  std::vector<TestSky> all{noise_picture(16, 8, 1), noise_picture(1, 5, 2), noise_picture(5, 1, 3),
                           noise_picture(1, 1, 4)};
  all[0].sky.rotation = 77.7;
  all[0].sky.scale = {2, 0.25f, 1};
  all[1].sky.rotation = -1234.5;
  all.push_back(noise_picture(16, 8, 7));
  all.back().name += ", z up";
  all.back().sky.up = {0, 0, 3};
  all.push_back(noise_picture(16, 8, 8));
  all.back().name += ", aslant";
  all.back().sky.up = {0.5, -0.8, 0.2};
  all.back().sky.rotation = 30;
  TestSky hot = noise_picture(32, 16, 5);
  hot.name = "one hot pixel";
  set(hot, 20, 5, {4e5f, 3e5f, 1e5f});
  TestSky poles = make_picture("poles only", 12, 9);
  for (int x = 0; x < 12; ++x) set(poles, x, 0, Rgb(1.0f + float(x)));
  for (int x = 0; x < 12; ++x) set(poles, x, 8, Rgb(3.0f));
  TestSky blue = make_picture("one blue pixel", 6, 4);
  set(blue, 5, 3, {0, 0, 1e-20f});
  TestSky holes = noise_picture(16, 8, 6);
  holes.name = "black pixels";
  for (int i = 0; i < 16; ++i) set(holes, i, i / 2, Rgb(0.0f));
  for (int x = 0; x < 16; ++x) set(holes, x, 3, Rgb(0.0f));
  TestSky decades = noise_picture(32, 16, 9);
  decades.name = "thirty decades";
  for (int i = 0; i < 32 * 16; ++i)
    set(decades, i % 32, i / 32, Rgb(std::pow(10.0f, float(-i % 31))));
  for (TestSky& p : std::vector{hot, poles, blue, holes, decades}) all.push_back(std::move(p));
  return all;
}

/// How far the density of a sample may be off, relatively, and the length of its direction.
struct SampleErrors {
  float pdf;
  double length;
};

/// That samples of draw() fall into the pixels at the density that they have, and estimate the
/// light.
template <class Draw>
void add_samples(const TestSky& p, Draw draw, SampleErrors errors, proof::Family& family) {
  constexpr int kSamples = 200'000;
  const SkyLight sky(p.sky);
  std::vector<std::uint64_t> observed(p.sky.pixels.size());
  std::vector<double> expected;
  Vec3d light;
  p.for_each_pixel([&](int x, int y) {
    const Vec3f middle = p.direction(x + 0.5, y + 0.5);
    expected.push_back(kSamples * double(sky.pdf(middle)) * p.solid_angle(y));
    light += Vec3d(p.pixel(x, y)) * p.solid_angle(y);
  });
  proof::Moments estimate[3];
  int misplaced = 0;
  for (int i = 0; i < kSamples; ++i) {
    const LightSample l = draw();
    ASSERT_GT(l.pdf, 0);
    ASSERT_NEAR(length(Vec3d(l.direction)), 1, errors.length);
    // Rounding the direction to float may put it across a border, rarely.
    const float pdf = sky.pdf(l.direction);
    misplaced +=
        std::abs(l.pdf - pdf) > errors.pdf * pdf || l.radiance != sky.radiance(l.direction);
    const auto along = [&](Vec3d axis) { return dot(Vec3d(l.direction), p.upright(axis)); };
    const double theta = std::acos(std::clamp(along({0, 1, 0}), -1.0, 1.0)) / TestSky::kPi;
    double turns =
        std::atan2(along({0, 0, 1}), along({1, 0, 0})) / (2 * TestSky::kPi) - p.sky.rotation / 360;
    turns -= std::floor(turns);
    const int x = std::min(int(turns * p.sky.width), p.sky.width - 1);
    const int y = std::min(int(theta * p.sky.height), p.sky.height - 1);
    const std::size_t pixel = std::size_t(y) * std::size_t(p.sky.width) + std::size_t(x);
    if (expected[pixel] > 0) ++observed[pixel];
    for (int c = 0; c < 3; ++c) estimate[c].add(double(l.radiance[c]) / double(l.pdf));
  }
  EXPECT_LE(misplaced, kSamples / 50'000) << p.name;
  double counted = 0, sum = 0;
  for (const std::uint64_t n : observed) counted += double(n);
  EXPECT_GE(counted, kSamples * (1 - 2e-5)) << p.name << ": samples in black pixels";
  for (const double n : expected) sum += n;
  for (double& n : expected) n *= counted / sum;
  if (p.sky.pixels.size() > 1 && p.name != "one blue pixel") {
    family.add("pixels of " + p.name, proof::counts_p_value(observed, expected));
  }
  for (int c = 0; c < 3; ++c) {
    family.add("light of " + p.name,
               proof::mean_p_value(estimate[c], light[c], 3e-7 * std::abs(light[c])));
  }
}

}  // namespace pvol::test
