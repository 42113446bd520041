// How far filtered pictures are off, by halves whose errors are known.
#include "render/denoise/filter_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace pvol::detail {
namespace filter_error_test {

constexpr int kEdge = 256;
constexpr float kLight = 3;  // of the picture, everywhere

/// A half of a picture of one value, with noise of this deviation.
Plane noisy(double deviation, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal(0, 1);
  Plane plane(kEdge, kEdge, 0);
  for (int y = 0; y < kEdge; ++y) {
    for (int x = 0; x < kEdge; ++x) plane.row(y)[x] = kLight + float(deviation) * normal(random);
  }
  return plane;
}

Plane even(float value) {
  Plane plane(kEdge, kEdge, 0);
  for (int y = 0; y < kEdge; ++y) std::fill_n(plane.row(y), kEdge, value);
  return plane;
}

/// Halves with noise of this deviation that count on one `times` as large.
Halves halves_of(double deviation, double times) {
  Halves halves;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto assumed = float(deviation * times);
    halves.colour[i] = {{noisy(deviation, i + 1)}, {even(assumed * assumed)}};
  }
  halves.filtered = even(1);
  halves.any = true;
  return halves;
}

/// Samples that cover a pixel evenly are less noisy than their variance tells: the estimate does
/// not rest on it.
TEST(FilterError, IsRightWhateverVariancesTheHalvesHave) {
  constexpr double kNoise = 0.5, kBias = 0.1, kLeft = 0.05;
  for (const double times : {1.0, 1.5, 0.5}) {
    const Halves halves = halves_of(kNoise, times);
    // Filtered halves of one bias and some noise of their own.
    std::array<Planes, 2> filtered{Planes{noisy(kLeft, 11)}, Planes{noisy(kLeft, 12)}};
    for (Planes& half : filtered) {
      for (int y = 0; y < kEdge; ++y) {
        for (int x = 0; x < kEdge; ++x) half[0].row(y)[x] += float(kBias);
      }
    }
    const Errors errors = find_errors(halves, filtered, 0);
    const double expected = kBias * kBias + kLeft * kLeft / 2;
    const double deviation = kNoise * kNoise / kEdge;  // of the mean of so many pixels
    EXPECT_NEAR(errors.mean_mse, expected, 4 * deviation) << times;
    EXPECT_NEAR(errors.deviation, deviation * times * times, 1e-3 * deviation) << times;
  }
}

TEST(FilterError, VariesAsItSays) {
  constexpr double kNoise = 0.5;
  const std::array<Planes, 2> exact{Planes{even(kLight + 0.2f)}, Planes{even(kLight + 0.2f)}};
  double sum = 0, squares = 0, deviation = 0;
  constexpr int kTimes = 60;
  for (int i = 0; i < kTimes; ++i) {
    Halves halves = halves_of(kNoise, 1);
    halves.colour[0].values[0] = noisy(kNoise, std::uint64_t(100 + 2 * i));
    halves.colour[1].values[0] = noisy(kNoise, std::uint64_t(101 + 2 * i));
    const Errors errors = find_errors(halves, exact, 0);
    sum += errors.mean_mse / kTimes, squares += errors.mean_mse * errors.mean_mse / kTimes;
    deviation = errors.deviation;
  }
  const double found = std::sqrt(squares - sum * sum);
  EXPECT_NEAR(sum, 0.04, 4 * deviation / std::sqrt(double(kTimes)));
  // The errors common to both halves bring some noise besides.
  EXPECT_GT(found, 0.7 * deviation);
  EXPECT_LT(found, 1.6 * deviation);
}

}  // namespace filter_error_test
}  // namespace pvol::detail
