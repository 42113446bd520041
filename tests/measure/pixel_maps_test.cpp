#include "pvol/measure/pixel_maps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pvol::measure {
namespace pixel_maps_test {

TEST(PixelMaps, QuantilesAreThoseOfFiniteValues) {
  const double nan = std::nan("");
  EXPECT_EQ(quantile({5, 1, nan, 3, 2, 4}, 0.5), 3);
  EXPECT_EQ(quantile({5, 1, nan}, 1), 5);
  EXPECT_EQ(quantile({nan}, 0.5), 0);
}

/// Rows of grey pixels, each with samples of value - spread and value + spread.
Film grey(int width, const std::vector<double>& values, double spread) {
  Film f;
  f.width = f.crop_width = width;
  f.height = f.crop_height = int(values.size()) / width;
  for (const double v : values) {
    PixelSums p;
    p.samples = 2;
    p.sum = Vec3d(2 * v);
    p.sum_squares = Vec3d((v - spread) * (v - spread) + (v + spread) * (v + spread));
    f.pixels.push_back(p);
  }
  return f;
}

TEST(PixelMaps, DifferencesAreSignedAndInTheirOwnDeviations) {
  const Film a = grey(2, {1, 2}, 0.3), b = grey(2, {0.5, 4}, 0.4);
  const Differences d = differences(a, b);
  const double deviation = std::hypot(0.3, 0.4);  // of either mean its spread: n = 2
  EXPECT_NEAR(d.values[0], 0.5, 1e-12);
  EXPECT_NEAR(d.values[1], -2, 1e-12);
  EXPECT_NEAR(d.sigmas[0], 0.5 / deviation, 1e-12);
  EXPECT_NEAR(d.sigmas[1], -2 / deviation, 1e-12);
  EXPECT_EQ(differences(grey(1, {1}, 0), grey(1, {2}, 0)).sigmas[0], 0);
}

TEST(PixelMaps, BlocksHoldTheMeanOfTheirPixels) {
  const Film a = grey(3, {1, 2, 3, 4, 5, 6}, 0), b = grey(3, {0, 0, 0, 0, 0, 0}, 0);
  const std::vector<double> blocks = block_differences(a, b, 2);
  for (const std::size_t i : {0u, 1u, 3u, 4u}) EXPECT_NEAR(blocks[i], 3, 1e-12);
  for (const std::size_t i : {2u, 5u}) EXPECT_NEAR(blocks[i], 4.5, 1e-12);  // the column left over
}

TEST(PixelMaps, TheDifferenceFilmHasItsMeanAndVariance) {
  const Film a = grey(1, {3}, 0.3), b = grey(1, {1}, 0.4);
  const PixelSums p = difference_film(a, b).pixels[0];
  EXPECT_EQ(p.samples, 4u);
  EXPECT_NEAR(mean(p).x, 2, 1e-12);
  EXPECT_NEAR(variance_of_mean(p).x, 0.09 + 0.16, 1e-12);
}

TEST(PixelMaps, LookupsAreCountedForSamplesAndCollisions) {
  Film f = grey(3, {1, 1, 1}, 0);
  f.counts.resize(3);
  f.counts[0][std::size_t(PixelCounter::lookups)] = 6;
  f.counts[0][std::size_t(PixelCounter::collisions)] = 4;
  f.pixels[1].samples = 0;
  EXPECT_EQ(lookups_per_sample(f), (std::vector<double>{3, 0, 0}));
  EXPECT_EQ(lookups_per_collision(f), (std::vector<double>{1.5, 0, 0}));
}

TEST(PixelMaps, RangesAreAboveZero) {
  EXPECT_EQ(range_of({-3, 1, 2}, 1), 3);
  EXPECT_EQ(range_of({0, 0, 0, 5}, 0.5), 5);
  EXPECT_EQ(range_of({0, 0}, 1), 1);
}

TEST(PixelMaps, ExposuresBringPicturesToTheSameBrightness) {
  EXPECT_NEAR(0.7 * std::exp2(exposure_for_mean(grey(1, {0.7}, 0))), 0.35, 1e-12);
  EXPECT_EQ(exposure_for_mean(grey(1, {0}, 0)), 0);
  const Film dim = grey(1, {0.1}, 0), bright = grey(1, {8}, 0);
  EXPECT_NEAR(exposure_below_white(dim, bright, 1), -3, 1e-12);
}

TEST(PixelMaps, HistogramsOfDeviationsAddUp) {
  const SigmaHistogram h = sigma_histogram({0, -100, -1, 0.1, 0.2, 100});
  EXPECT_EQ(h.pixels, 5);  // one has no variance
  double shares = 0, law = 0;
  for (std::size_t i = 0; i < h.shares.size(); ++i) {
    shares += h.shares[i];
    law += h.expected(h.lower_edge(i) + h.width / 2);
  }
  EXPECT_NEAR(shares, 1, 1e-12);
  EXPECT_NEAR(law, 1, 1e-6);
  EXPECT_NEAR(h.shares.front(), 0.2, 1e-12);  // what lies beyond
  EXPECT_NEAR(h.shares[h.shares.size() / 2], 0.4, 1e-12);
}

}  // namespace pixel_maps_test
}  // namespace pvol::measure
