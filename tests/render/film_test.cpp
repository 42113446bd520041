// Films of the same picture are added field by field.
#include "pvol/render/film.h"

#include <gtest/gtest.h>

#include "pvol/error.h"

namespace pvol::test {
namespace film_test {

/// 3 x 2 pixels with a layer, in which every number is another one.
Film numbered(double first) {
  Film f;
  f.width = f.crop_width = 3;
  f.height = f.crop_height = 2;
  f.layers = {{"sun_1", {}}, {"sky", {}}};
  double next = first;
  const auto vector = [&] {
    next += 3;
    return Vec3d(next, next + 1, next + 2);
  };
  for (int i = 0; i < 6; ++i) {
    PixelSums& p = f.pixels.emplace_back();
    p.sum = vector();
    p.sum_squares = vector();
    p.alpha = ++next;
    p.samples = std::uint32_t(++next);
    for (std::uint64_t& n : p.counts) n = std::uint64_t(++next);
    for (Layer& layer : f.layers) layer.sums.push_back(vector());
  }
  return f;
}

TEST(Film, AddsEveryField) {
  const Film a = numbered(1), b = numbered(1000);
  Film sum = a;
  add_samples(sum, b);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const PixelSums &p = a.pixels[i], &q = b.pixels[i], &s = sum.pixels[i];
    EXPECT_EQ(s.sum, p.sum + q.sum);
    EXPECT_EQ(s.sum_squares, p.sum_squares + q.sum_squares);
    EXPECT_EQ(s.alpha, p.alpha + q.alpha);
    EXPECT_EQ(s.samples, p.samples + q.samples);
    for (std::size_t k = 0; k < s.counts.size(); ++k) {
      EXPECT_EQ(s.counts[k], p.counts[k] + q.counts[k]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(sum.layers[k].sums[i], a.layers[k].sums[i] + b.layers[k].sums[i]);
    }
  }
}

TEST(Film, OthersAreNotAdded) {
  Film f = numbered(1), wider = f, larger = f, plain = f, aces = f;
  aces.color_space = ColorSpace::acescg;
  wider.crop_width = 2;
  larger.pixels.emplace_back();
  plain.layers.clear();
  EXPECT_NO_THROW(add_samples(f, f));
  for (const Film& other : {wider, larger, plain, aces}) EXPECT_THROW(add_samples(f, other), Error);
}

}  // namespace film_test
}  // namespace pvol::test
