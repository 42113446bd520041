// Studies of made-up settings, whose figures are known.
#include "pvol/measure/study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/error.h"
#include "pvol/math/rng.h"

namespace pvol::measure {
namespace study_test {

/// Uniform noise of width 1 around a value.
Film noise(double value, std::uint32_t samples, std::uint64_t seed) {
  constexpr int kEdge = 32;
  Film f;
  f.width = f.crop_width = f.height = f.crop_height = kEdge;
  f.pixels.resize(kEdge * kEdge);
  for (std::size_t i = 0; i < f.pixels.size(); ++i) {
    Rng rng(seed, i, 0);
    PixelSums& p = f.pixels[i];
    p.samples = samples;
    for (std::uint32_t k = 0; k < samples; ++k) {
      const Vec3d v(value + double(rng.uniform()) - 0.5);
      p.sum += v, p.sum_squares += v * v;
    }
  }
  return f;
}

/// Three rounds of a setting with times and variances that go up and down alike for all.
Measured measured(double seconds, double variance, double value, std::uint64_t seed) {
  Measured m;
  for (const double busy : {1.0, 3.0, 1.5}) {
    m.round.push_back(int(m.seconds.size()) + 1);
    m.seconds.push_back(seconds * busy);
    m.variance.push_back(variance);
    m.set_up_seconds.push_back(0.5);
  }
  m.samples = 16;
  m.film = m.counted_film = noise(value, 16, seed);
  m.counted = 10;
  m.counts.path.lookups = 20, m.counts.shadow.lookups = 5;
  m.counts.shadow.segments = 30;
  m.set_up.octree_bytes = 1000;
  return m;
}

// The first round of the default was stopped: what is busy in the second is compared with itself.
TEST(Study, ComparesEqualRounds) {
  Measured base = measured(1e-3, 0.1, 2, 1), other = measured(5e-4, 0.1, 2, 2);
  for (std::vector<double>* v : {&base.seconds, &base.variance, &base.set_up_seconds}) {
    v->erase(v->begin());
  }
  base.round.erase(base.round.begin());
  const std::vector<Row> rows = make_rows({{"default", ""}, {"a", "--faster"}}, {base, other});
  EXPECT_DOUBLE_EQ(rows[1].time.value, 0.5);
  EXPECT_DOUBLE_EQ(rows[1].time.low, 0.5);
  EXPECT_DOUBLE_EQ(rows[1].time.high, 0.5);
  EXPECT_DOUBLE_EQ(rows[1].cost.value, 0.5);
}

Study small_study() {
  Measured none;
  none.left_out = "too slow";
  Study s;
  set_reference(s, noise(2, 256, 99));
  s.picture_pixels = 1000;
  s.rows = make_rows(
      {{"default", ""}, {"a", "--faster"}, {"b", "--wrong", true}, {"c", "--none"}},
      {measured(1e-3, 0.1, 2, 1), measured(5e-4, 0.1, 2, 2), measured(1e-4, 0.1, 1.9, 3), none});
  return s;
}

TEST(Study, ComparesEachSettingWithTheFirst) {
  const Study s = small_study();
  EXPECT_NEAR(s.reference_mean, 2, 0.01);
  EXPECT_EQ(s.reference_samples, 256u);
  EXPECT_EQ(s.rows[0].time.value, 1);
  EXPECT_NEAR(s.rows[1].time.value, 0.5, 1e-12);
  EXPECT_NEAR(s.rows[1].cost.value, 0.5, 1e-12);
  EXPECT_NEAR(s.rows[1].time.high, 0.5, 1e-12);  // the machine was as busy for both
  EXPECT_EQ(s.rows[1].work.lookups, 2.5);
  EXPECT_EQ(s.rows[1].work.segments, 3);
  EXPECT_NEAR(s.rows[1].sample_variance, 1.0 / 12, 0.005);
  EXPECT_NEAR(s.rows[1].lookup_cost(), 2.5 / 12, 0.02);
  EXPECT_FALSE(s.rows[3].good());
  EXPECT_EQ(coverage(s).rounds, 3);
  EXPECT_EQ(coverage(s).probability, 0.75);
}

TEST(Study, FindsBiasFrontAndAdvice) {
  Study s = small_study();
  s.goals = {{.seconds = 1}, {.error = 0.01}};
  judge(s);
  EXPECT_FALSE(s.rows[0].detected());
  EXPECT_FALSE(s.rows[1].detected());
  EXPECT_TRUE(s.rows[2].detected());
  EXPECT_EQ(s.rows[1].offset(), 0);
  EXPECT_NEAR(s.rows[2].offset(), 0.05, 0.01);
  EXPECT_NEAR(s.rows[1].rmse_of_one_sample, std::sqrt(1.0 / 12) / 2, 0.01);
  EXPECT_FALSE(s.rows[0].on_front);
  EXPECT_TRUE(s.rows[1].on_front);
  EXPECT_TRUE(s.rows[2].on_front);  // nothing is as fast
  ASSERT_TRUE(s.goals[0].advice && s.goals[1].advice);
  EXPECT_EQ(s.goals[1].advice->setting, 1u);
  EXPECT_LE(s.goals[1].advice->error, 0.01);
}

TEST(Study, NeedsLight) {
  Study s;
  Film black;
  black.crop_width = black.crop_height = 1;
  black.pixels.resize(1);
  EXPECT_THROW(set_reference(s, black), Error);
}

TEST(Study, LooksForCombinationsAmongSettings) {
  const Study s = small_study();
  const VariantResult r = result_of(s.rows[1]);
  EXPECT_TRUE(r.measured);
  EXPECT_NEAR(r.gain, 0.5, 1e-12);
  EXPECT_FALSE(result_of(s.rows[3]).measured);
  const std::vector<Variant> singles{{"a", "1"}, {"a", "2"}, {"b", "3"}, {"c", "4"}};
  const std::vector<std::vector<std::size_t>> all = combinations(
      singles, {{true, 0.9, 0.95}, {true, 0.5, 0.6}, {true, 0.7, 0.8}, {true, 0.6, 0.7}});
  const std::vector<std::vector<std::size_t>> expected{{1, 3}, {1, 2}, {3, 2}, {1, 3, 2}};
  EXPECT_EQ(all, expected);
}

TEST(Study, BuildingIsComparedInAllAndInItsSecondPart) {
  const BuildTimes base{{1, 2, 1}, {1, 2, 1}}, other{{1, 2, 1}, {3, 6, 3}};
  const BuildRatios r = compare_building(other, base);
  EXPECT_EQ(r.all.value, 2);
  EXPECT_EQ(r.tree.value, 3);
  EXPECT_EQ(compare_building(base, base).all.high, 1);
}

}  // namespace study_test
}  // namespace pvol::measure
