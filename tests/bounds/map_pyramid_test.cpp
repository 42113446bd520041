// Bounds of mapped fields: they hold, stay tight, and leave out what the map makes empty.
#include "pvol/bounds/map_pyramid.h"

#include <gtest/gtest.h>

#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace map_pyramid_test {

FieldMap cut(float threshold) { return {.ramp = {{{0, 0}, {threshold, 0}, {1, 1}}, false}}; }

/// Every leaf that the map leaves has the range of the map over the leaf's own, and no other is
/// there.
void expect_range_of_each(const Pyramid& pyramid, const FieldMap& map, const std::string& name) {
  const Pyramid mapped = map_pyramid(pyramid, map);
  std::size_t kept = 0;
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      const PyramidNode& n = pyramid.levels[level][i];
      if (level > 0 && !is_uniform(pyramid, level, i)) continue;
      const ValueRange r = range_over(map, {n.lo, n.hi});
      const auto at = mapped.empty() ? std::nullopt : find(mapped.levels[level], n.code);
      ASSERT_EQ(at.has_value(), r.hi > 0) << name;
      if (!at) continue;
      ++kept;
      EXPECT_EQ(mapped.levels[level][*at].lo, r.lo) << name;
      EXPECT_EQ(mapped.levels[level][*at].hi, r.hi) << name;
    }
  }
  if (kept == 0) {
    EXPECT_TRUE(mapped.empty()) << name;
    return;
  }
  ASSERT_FALSE(mapped.empty()) << name;
  EXPECT_EQ(mapped.levels.back().size(), 1u);
  EXPECT_EQ(mapped.scale, mapped.levels.back().front().hi);
  EXPECT_EQ(mapped.origin, pyramid.origin);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(mapped.support_lo[axis], pyramid.support_lo[axis]) << name;
    EXPECT_LE(mapped.support_hi[axis], pyramid.support_hi[axis]) << name;
    EXPECT_LT(mapped.support_lo[axis], mapped.support_hi[axis]) << name;
  }
}

TEST(MapPyramid, HasTheRangesOfTheMap) {
  for (const Field& f : fields()) {
    const Pyramid pyramid = build_pyramid(f.grid);
    for (const float threshold : {0.01f, 0.3f, 0.9f}) {
      expect_range_of_each(pyramid, cut(threshold), f.name);
    }
    expect_range_of_each(pyramid, {.scale = 3, .power = 2}, f.name);
    // A band: neither the thin nor the dense stays.
    expect_range_of_each(pyramid, {.ramp = {{{0, 0}, {0.2f, 0}, {0.3f, 1}, {0.4f, 0}}, true}},
                         f.name);
  }
}

TEST(MapPyramid, ShrinksTheSupport) {
  // A ramp along x from 0 to 1: what is above a half lies in the far part.
  const Field f = make_field("wedge", {0, 0, 0}, {64, 8, 8}, [](Vec3i p) { return p.x / 64.0; });
  const Pyramid whole = build_pyramid(f.grid), half = map_pyramid(whole, cut(0.5f));
  EXPECT_LE(whole.support_lo.x, 0);
  EXPECT_GE(half.support_lo.x, 24);
  EXPECT_EQ(half.support_hi.x, whole.support_hi.x);
}

TEST(MapPyramid, WithoutAMapIsTheSame) {
  const Pyramid p = build_pyramid(field("gaussian").grid);
  EXPECT_EQ(map_pyramid(p, {}), p);
}

TEST(MapPyramid, RefusesToFillAllSpaceAndToOverflow) {
  const Pyramid p = build_pyramid(field("gaussian").grid);
  EXPECT_TRUE(
      says(error_of([&] { (void)map_pyramid(p, {.offset = 0.5}); }), "bounds.map_makes_fill"));
  EXPECT_TRUE(
      says(error_of([&] { (void)map_pyramid(p, {.scale = 1e200}); }), "bounds.map_exceeds_range"));
}

}  // namespace map_pyramid_test
}  // namespace pvol::test
