#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "pvol/bounds/pyramid.h"
#include "support/messages.h"
#include "support/random_pyramid.h"

namespace pvol {
namespace pyramid_code_test {

constexpr float kTiny = std::numeric_limits<float>::denorm_min();
constexpr float kHuge = std::numeric_limits<float>::max();
constexpr float kSmallestNormal = std::numeric_limits<float>::min();
const float kScales[] = {kTiny, 3 * kTiny, 12345 * kTiny, kSmallestNormal, 1e-30f, 0.3f,
                         1,     5.71f,     1e9f,          3e38f,           kHuge};

TEST(Morton, CodesRoundTripAndInterleaveXLowest) {
  EXPECT_EQ(morton_encode({1, 0, 0}), 1u);
  EXPECT_EQ(morton_encode({0, 1, 0}), 2u);
  EXPECT_EQ(morton_encode({0, 0, 1}), 4u);
  EXPECT_EQ(morton_encode(Vec3<std::uint32_t>((1u << 21) - 1)), (std::uint64_t(1) << 63) - 1);
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    const auto draw = [&] { return std::uint32_t(random() >> 11); };
    const Vec3<std::uint32_t> v(draw(), draw(), draw());
    std::uint64_t expected = 0;
    for (int bit = 0; bit < 21; ++bit) {
      for (int axis = 0; axis < 3; ++axis) {
        expected |= std::uint64_t(v[axis] >> bit & 1) << (3 * bit + axis);
      }
    }
    ASSERT_EQ(morton_encode(v), expected);
    ASSERT_EQ(morton_decode(expected), v);
  }
}

TEST(BoundCode, DecodedValuesRiseFromZeroToTheScale) {
  for (const float scale : kScales) {
    EXPECT_EQ(decode(0, scale), 0);
    EXPECT_EQ(decode(kTopCode, scale), scale);
    for (std::uint16_t c = 1; c <= kTopCode; ++c) {
      ASSERT_GE(decode(c, scale), decode(std::uint16_t(c - 1), scale)) << c << " of " << scale;
    }
  }
}

TEST(BoundCode, StepsDoubleEvery2048CodesAboveTheSubnormals) {
  EXPECT_EQ(decode(1, 1), std::exp2(-41.0f));
  EXPECT_EQ(decode(1 << 11, 1), std::exp2(-30.0f));
  for (std::uint16_t c = 1 << 11; c + 2048 <= kTopCode; ++c) {
    ASSERT_EQ(decode(std::uint16_t(c + 2048), 1), 2 * decode(c, 1));
  }
}

TEST(BoundCode, RoundsOutwardToTheNextCode) {
  const auto check = [](float v, float scale) {
    const std::uint16_t down = encode_down(v, scale), up = encode_up(v, scale);
    ASSERT_LE(down, kTopCode);
    ASSERT_LE(up, kTopCode);
    ASSERT_LE(decode(down, scale), v) << v << " of " << scale;
    ASSERT_GE(decode(up, scale), v) << v << " of " << scale;
    // No code fits better on either side.
    if (down < kTopCode) {
      ASSERT_GT(decode(std::uint16_t(down + 1), scale), v);
    }
    if (up > 0) {
      ASSERT_LT(decode(std::uint16_t(up - 1), scale), v);
    }
    if (v > 0) {
      ASSERT_GT(decode(up, scale), 0);
    }
    if (scale >= 0x1p-96f && double(v) >= double(scale) * 0x1p-30) {
      const double factor = 1 + 0x1p-11 + 0x1p-23;
      ASSERT_LE(double(decode(up, scale)), double(v) * factor);
      ASSERT_GE(double(decode(down, scale)) * factor, double(v));
    }
  };
  std::mt19937 random(2);
  for (const float scale : kScales) {
    for (std::uint32_t c = 0; c <= kTopCode; ++c) {
      const float v = decode(std::uint16_t(c), scale);
      ASSERT_EQ(decode(encode_down(v, scale), scale), v);
      ASSERT_EQ(decode(encode_up(v, scale), scale), v);
      check(v, scale);
      if (v > 0) check(std::nextafter(v, 0.0f), scale);
      if (v < scale) check(std::nextafter(v, kHuge), scale);
    }
    for (int i = 0; i < 100000; ++i) {
      const double range = std::log2(double(scale)) + 150;
      const double e = std::uniform_real_distribution<double>(0, range)(random) - 150;
      check(std::min(scale, float(std::exp2(e))), scale);
    }
  }
}

TEST(Pyramid, FindsPresentCodesOnly) {
  const Pyramid p = test::random_pyramid({.levels = 5, .leaves = 200}, 3);
  std::set<std::uint64_t> codes;
  for (std::size_t i = 0; i < p.levels[0].size(); ++i) {
    EXPECT_EQ(find(p.levels[0], p.levels[0][i].code), i);
    codes.insert(p.levels[0][i].code);
  }
  for (std::uint64_t c = 0; c < 4096; ++c) {
    EXPECT_EQ(find(p.levels[0], c).has_value(), codes.contains(c));
  }
  EXPECT_FALSE(find({}, 0));
}

TEST(Pyramid, CompletedParentsHoldTheExtremesOfTheirEightChildren) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Pyramid p = test::random_pyramid({.levels = 4, .leaves = 300, .uniform = 10}, seed);
    for (std::size_t level = 1; level < p.levels.size(); ++level) {
      for (const PyramidNode& n : p.levels[level]) {
        float lo = std::numeric_limits<float>::infinity(), hi = 0;
        int children = 0;
        for (std::uint64_t c = 8 * n.code; c < 8 * n.code + 8; ++c) {
          const auto at = find(p.levels[level - 1], c);
          children += at ? 1 : 0;
          lo = std::min(lo, at ? p.levels[level - 1][*at].lo : 0);
          hi = std::max(hi, at ? p.levels[level - 1][*at].hi : 0);
        }
        if (children == 0) continue;  // uniform
        EXPECT_EQ(n.lo, lo);
        EXPECT_EQ(n.hi, hi);
      }
      for (const PyramidNode& c : p.levels[level - 1]) {
        EXPECT_TRUE(find(p.levels[level], c.code >> 3));
      }
    }
    Pyramid again = p;
    complete_levels(again);
    EXPECT_EQ(again, p);
  }
}

TEST(Pyramid, ValidPyramidsOfAnyDepthPass) {
  EXPECT_EQ(validate(Pyramid{}), std::nullopt);
  for (const float scale : kScales) {
    for (std::size_t levels = 1; levels <= 22; ++levels) {
      const test::PyramidSpec spec{
          .levels = levels, .scale = scale, .origin = Vec3l(-8, -8388608, 80)};
      const auto wrong = validate(test::random_pyramid(spec, levels));
      EXPECT_EQ(wrong, std::nullopt) << *wrong << ", levels " << levels << ", scale " << scale;
    }
  }
}

TEST(Pyramid, EveryBrokenInvariantIsNamed) {
  struct Case {
    const char* key;  // of the message
    std::function<void(Pyramid&)> damage;
  };
  const float above = 0.25f + 0x1p-20f;  // no value of the code
  const Case cases[] = {
      {"bounds.levels_most_possible", [](Pyramid& p) { p.levels.resize(23); }},
      {"bounds.pyramid_without_levels", [](Pyramid& p) { p.levels.clear(); }},
      {"bounds.scale_expected_positive", [](Pyramid& p) { p.scale = 0; }},
      {"bounds.scale_expected_positive",
       [](Pyramid& p) { p.scale = std::numeric_limits<float>::infinity(); }},
      {"bounds.scale_expected_positive",
       [](Pyramid& p) { p.scale = std::numeric_limits<float>::quiet_NaN(); }},
      {"bounds.origin_no_multiple", [](Pyramid& p) { p.origin.y = 4; }},
      {"bounds.origin_minus_no_multiple",
       [](Pyramid& p) { p.origin.z = -(std::int64_t(1) << 40); }},
      {"bounds.support_not_inside", [](Pyramid& p) { p.support_lo.x = p.origin.x - 1; }},
      {"bounds.support_not_inside", [](Pyramid& p) { p.support_hi.x = p.support_lo.x; }},
      {"bounds.support_not_inside", [](Pyramid& p) { p.support_hi.z += std::int64_t(1) << 24; }},
      {"bounds.support_not_end", [](Pyramid& p) { p.support_lo.x += 8; }},
      {"bounds.support_not_end", [](Pyramid& p) { p.support_hi.y -= 8; }},
      {"bounds.outside_root", [](Pyramid& p) { p.levels[1].back().code = 64; }},
      {"bounds.out_order", [](Pyramid& p) { std::swap(p.levels[0][0], p.levels[0][1]); }},
      {"bounds.out_order", [](Pyramid& p) { p.levels[0][1].code = p.levels[0][0].code; }},
      {"bounds.bounds_not_order", [](Pyramid& p) { p.levels[0][0].lo = -p.levels[0][0].hi; }},
      {"bounds.bounds_not_order", [](Pyramid& p) { p.levels[0][0].hi = 0; }},
      {"bounds.bounds_not_order", [](Pyramid& p) { p.levels[0][0].hi = 2 * p.scale; }},
      {"bounds.bounds_not_order", [](Pyramid& p) { p.levels[0][0].hi = std::nanf(""); }},
      {"bounds.not_value_bit",
       [above](Pyramid& p) {
         p.levels[0][0] = {p.levels[0][0].code, above, above};
       }},
      {"bounds.bounds_not_children", [](Pyramid& p) { p.levels.back()[0].lo = p.scale; }},
      {"bounds.missing_children_exist", [](Pyramid& p) { p.levels[2].clear(); }},
      {"bounds.missing_children_exist", [](Pyramid& p) { p.levels[1].pop_back(); }},
      {"bounds.root_majorant_not_scale",
       [](Pyramid& p) {
         for (auto& level : p.levels) {
           for (PyramidNode& n : level) {
             n.hi = std::min(n.hi, p.scale / 2);
             n.lo = std::min(n.lo, p.scale / 2);
           }
         }
       }},
      {"bounds.no_children_bounds",
       [](Pyramid& p) {
         const std::uint64_t orphaned = p.levels[1][0].code;
         std::erase_if(p.levels[0], [&](const auto& n) { return n.code >> 3 == orphaned; });
       }},
  };
  const Pyramid good = test::random_pyramid({.levels = 4, .leaves = 400, .uniform = 0}, 1);
  ASSERT_EQ(validate(good), std::nullopt);
  for (const Case& c : cases) {
    Pyramid bad = good;
    c.damage(bad);
    const auto wrong = validate(bad);
    ASSERT_TRUE(wrong) << c.key;
    EXPECT_TRUE(says(*wrong, c.key));
  }
}

TEST(Pyramid, BrokenInvariantsAreNamedWithTheirValues) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(8);
  p.levels = {{{0, 0.75f, 0.5f}}};
  EXPECT_TRUE(says(validate(p).value_or(""), "bounds.values_not_in_order"));
}

TEST(Pyramid, UniformCubesMayTakeTwoAdjacentCodes) {
  Pyramid p;
  p.scale = 1;
  p.support_hi = Vec3l(16);
  p.levels = {{}, {{0, decode(kTopCode - 1, 1), 1}}};
  EXPECT_EQ(validate(p), std::nullopt);
  p.levels[1][0].lo = decode(kTopCode - 2, 1);
  EXPECT_TRUE(validate(p));
}

}  // namespace pyramid_code_test
}  // namespace pvol
