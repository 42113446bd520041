// Maps of values: what they make of one, and of all values in a range.
#include "pvol/math/field_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pvol/math/rng.h"

namespace pvol::test {
namespace field_map_test {

/// A number around which maps are made: of either sign, sometimes 0.
double number(Rng& rng, double size) {
  const double u = double(rng.uniform());
  return u < 0.1 ? 0 : size * (2 * double(rng.uniform()) - 1);
}

Ramp random_ramp(Rng& rng) {
  Ramp ramp{.points = {}, .smooth = rng.uniform() < 0.5f};
  const int points = int(rng.uniform() * 6);
  double x = number(rng, 2);
  for (int i = 0; i < points; ++i) {
    ramp.points.push_back({float(x), float(number(rng, 3))});
    x += 1e-3 + double(rng.uniform());
  }
  return ramp;
}

FieldMap random_map(Rng& rng) {
  FieldMap map{.scale = number(rng, 3), .offset = number(rng, 1), .ramp = random_ramp(rng)};
  if (rng.uniform() < 0.3f) {
    const double least = number(rng, 1);
    map.clamp = {least, least + double(rng.uniform())};
  }
  if (rng.uniform() < 0.3f) map.power = 0.2 + 4 * double(rng.uniform());
  return map;
}

TEST(FieldMap, IsItsFormula) {
  FieldMap map{.scale = 2, .offset = -1, .clamp = {{0, 4}}, .power = 2};
  EXPECT_EQ(value_at(map, 0.25f), 0);    // clamped
  EXPECT_EQ(value_at(map, 1.5f), 4);     // (3 - 1)^2
  EXPECT_EQ(value_at(map, 100.0f), 16);  // 4^2
  map.ramp.points = {{0, 1}, {8, 5}, {16, 3}};
  EXPECT_EQ(value_at(map, 0.0f), 1);
  EXPECT_EQ(value_at(map, 1.5f), 3);
  EXPECT_FLOAT_EQ(value_at(map, 2.232051f), 4.0f);  // 12, half-way down
  EXPECT_EQ(value_at(map, 100.0f), 3);
  EXPECT_EQ(value_at(FieldMap{.scale = -1}, 2.0f), 0) << "no map is negative";
}

TEST(FieldMap, BoundsHoldAndAreReached) {
  Rng rng(101, 0, 0);
  for (int k = 0; k < 4000; ++k) {
    const FieldMap map = random_map(rng);
    float lo = float(number(rng, 2)), hi = float(number(rng, 2));
    if (hi < lo) std::swap(lo, hi);
    const ValueRange range = range_over(map, {lo, hi});
    float least = value_at(map, lo), most = least;
    constexpr int kSteps = 4000;
    for (int i = 0; i <= kSteps; ++i) {
      const float v = std::min(lo + (hi - lo) * (float(i) / kSteps), hi);
      const float y = value_at(map, v);
      ASSERT_GE(y, range.lo) << k;
      ASSERT_LE(y, range.hi) << k;
      least = std::min(least, y), most = std::max(most, y);
    }
    // Between steps the map may go on to an extreme, at most by its steepest slope.
    const float slack = 0.02f * (1 + range.hi);
    ASSERT_LE(range.hi, most + slack) << k;
    ASSERT_GE(range.lo, least - slack) << k;
  }
}

/// Whatever a ramp makes of the rounding of look-ups.
TEST(FieldMap, BoundsHoldBesideASteepRamp) {
  for (const double offset : {0.0, -0.3}) {
    const float top = 0.3f, above = std::nextafter(top, 1.0f);
    const FieldMap shift{.scale = 1, .offset = offset};
    FieldMap map = shift;
    map.ramp.points = {{value_at(shift, top), 0},
                       {value_at(shift, above), 1}};
    ASSERT_EQ(value_at(map, top), 0);
    ASSERT_EQ(value_at(map, above), 1);
    EXPECT_EQ(range_over(map, {0.1f, top}).hi, 1);
    EXPECT_EQ(range_over(map, {above, 0.5f}).lo, 0);
  }
}

TEST(FieldMap, OfOneValueHasOneValue) {
  Rng rng(102, 0, 0);
  for (int k = 0; k < 1000; ++k) {
    const FieldMap map = random_map(rng);
    const float v = float(number(rng, 2)), y = value_at(map, v);
    const ValueRange range = range_over(map, {v, v});
    EXPECT_NEAR(range.lo, y, 5e-5f * (1 + y));
    EXPECT_NEAR(range.hi, y, 5e-5f * (1 + y));
  }
}

TEST(Ramp, GoesThroughItsPointsWithoutOvershoot) {
  const std::vector<RampPoint> points{{0, 0}, {1, 0}, {2, 4}, {4, 5}, {5, 1}};
  for (const bool smooth : {false, true}) {
    const Ramp ramp{points, smooth};
    for (const RampPoint& p : points) EXPECT_EQ(value_at(ramp, p.x), p.y);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      float last = points[i].y;
      const float sign = points[i + 1].y < last ? -1.0f : 1.0f;
      for (int k = 1; k <= 100; ++k) {
        const float x = points[i].x + (points[i + 1].x - points[i].x) * (float(k) / 100);
        const float y = value_at(ramp, x);
        EXPECT_GE(sign * (y - last), -1e-6f) << "not monotonic at " << x;
        last = y;
      }
    }
  }
}

TEST(Ramp, SmoothOnesHaveNoKinks) {
  const Ramp ramp{{{0, 0}, {1, 1}, {2, 4}, {3, 4.5f}}, true};
  for (const float x : {1.0f, 2.0f}) {
    constexpr float kStep = 1e-3f;
    const float before = (value_at(ramp, x) - value_at(ramp, x - kStep)) / kStep;
    const float after = (value_at(ramp, x + kStep) - value_at(ramp, x)) / kStep;
    EXPECT_NEAR(before, after, 0.05f) << x;
  }
  // Half-way between points of equal slopes it is the mean, where lines have it, too.
  EXPECT_FLOAT_EQ(value_at(Ramp{{{0, 0}, {1, 1}, {2, 2}, {3, 3}}, true}, 1.5f), 1.5f);
}

}  // namespace field_map_test
}  // namespace pvol::test
