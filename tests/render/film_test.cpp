// Films of the same picture are added field by field.
#include "pvol/render/film.h"

#include <gtest/gtest.h>

#include "pvol/error.h"
#include "pvol/math/rng.h"

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
    p.group = ++next;
    p.samples = std::uint32_t(++next);
    p.group_samples = std::uint32_t(++next);
    for (std::uint64_t& n : f.counts.emplace_back()) n = std::uint64_t(++next);
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
    EXPECT_EQ(s.group, p.group + q.group);
    EXPECT_EQ(s.samples, p.samples + q.samples);
    EXPECT_EQ(s.group_samples, p.group_samples + q.group_samples);
    for (std::size_t k = 0; k < kPixelCounts.size(); ++k) {
      EXPECT_EQ(sum.counts[i][k], a.counts[i][k] + b.counts[i][k]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(sum.layers[k].sums[i], a.layers[k].sums[i] + b.layers[k].sums[i]);
    }
  }
}

/// A picture of 3840 x 2160 fits into 1.5 GB.
TEST(Film, PixelsWithExactSumsTake176Bytes) {
  EXPECT_LE(sizeof(PixelSums) + sizeof(PixelRemainders), 176u);
  Film f = numbered(1);
  EXPECT_TRUE(f.remainders.empty());
  keep_exact_sums(f);
  EXPECT_EQ(f.remainders.pixels.size(), f.pixels.size());
}

/// A film of two pixels and a layer with weights, whose sums have so many terms.
Film many_samples(std::uint32_t n, std::uint64_t seed, ExactSums& all) {
  Film f;
  f.width = f.crop_width = 2, f.height = f.crop_height = 1;
  f.pixels.resize(2);
  f.layers = {{"half_1", std::vector<Vec3d>(2), "RGB", std::vector<double>(2)}};
  keep_exact_sums(f);
  Rng rng(seed, 0, 0);
  ExactSums sums;
  load_sums(f, 1, sums);
  for (std::uint32_t i = 0; i < n; ++i) {
    // Terms that fill all digits, on the same side.
    const Vec3d v = Vec3d(0.3, 0x1.ffffffffffp30, 0x1p-33 / 3) * double(1 + rng.uniform() / 7);
    for (ExactSums* s : {&sums, &all}) {
      add(s->light, v), add(s->squares, v * v), add(s->alpha, v.x);
      add(s->group, v.y);
      add(s->layers[0].sum, -v), add(s->layers[0].weight, v.z);
    }
  }
  f.pixels[1].samples = n, f.pixels[1].group_samples = n / 2;
  make_room(n, f);
  store_sums(sums, 1, f);
  return f;
}

TEST(Film, SumsOfManySamplesAreExact) {
  ExactSums all;
  all.layers.resize(1);
  Film sum = many_samples(30'000, 1, all);
  EXPECT_TRUE(sum.remainders.whole.empty());
  for (const std::uint64_t seed : {2, 3}) {
    add_samples(sum, many_samples(30'000, seed, all));
    EXPECT_EQ(sum.remainders.whole.empty(), seed == 2);
    ExactSums found;
    load_sums(sum, 1, found);
    EXPECT_EQ(found, all);
    EXPECT_EQ(sum.pixels[1].sum, value(all.light));
    EXPECT_EQ(sum.pixels[1].group, value(all.group));
    EXPECT_EQ(sum.layers[0].weights[1], value(all.layers[0].weight));
  }
  ExactSums found;
  load_sums(crop_of(sum, 1, 0, 1, 1), 0, found);
  EXPECT_EQ(found, all);
  Film other = many_samples(100'000, 4, all);
  EXPECT_FALSE(other.remainders.whole.empty());
  add_part(other, sum);
  load_sums(other, 1, found);
  EXPECT_EQ(found, all);
  EXPECT_EQ(other.pixels[1].samples, 190'000u);
  EXPECT_EQ(other.pixels[1].group_samples, 95'000u);
}

TEST(Film, OthersAreNotAdded) {
  Film f = numbered(1), wider = f, larger = f, plain = f, renamed = f, aces = f;
  aces.color_space = ColorSpace::acescg;
  wider.crop_width = 2;
  larger.pixels.emplace_back();
  plain.layers.clear();
  renamed.layers.front().name = "other";
  EXPECT_NO_THROW(add_samples(f, f));
  for (const Film& other : {wider, larger, plain, renamed, aces}) {
    EXPECT_THROW(add_samples(f, other), Error);
  }
}

}  // namespace film_test
}  // namespace pvol::test
