// Lanes of the processor and of arrays against arithmetic on single numbers, and each other.
#include <gtest/gtest.h>

#include "math/float4_cases.h"
#include "pvol/math/float4.h"

namespace pvol {
namespace float4_test {

using test::LaneBits;
using test::LaneCase;

/// Equal to the bit; but which NaN comes out of arithmetic is the processor's and the compiler's
/// choice.
bool same(const LaneBits& a, const LaneBits& b, bool exact) {
  const auto is_nan = [](std::uint32_t bits) { return (bits & 0x7fffffffu) > 0x7f800000u; };
  for (std::size_t lane = 0; lane < a.size(); ++lane) {
    const bool both_nan = !exact && is_nan(a[lane]) && is_nan(b[lane]);
    if (a[lane] != b[lane] && !both_nan) return false;
  }
  return true;
}

void expect_scalar_arithmetic(const std::vector<LaneCase>& cases) {
  for (const LaneCase& c : cases) {
    EXPECT_TRUE(same(c.found, c.expected, c.exact))
        << c.what << std::hex << testing::PrintToString(c.found) << " and "
        << testing::PrintToString(c.expected);
  }
}

TEST(Float4Numbers, OfTheProcessorAreScalarArithmetic) {
  const auto cases = test::lane_cases<Float4, Int4>();
  EXPECT_GT(cases.size(), 30'000u);
  expect_scalar_arithmetic(cases);
}

TEST(Float4Numbers, OfArraysAreScalarArithmetic) {
  expect_scalar_arithmetic(test::plain_lane_cases());
}

TEST(Float4Numbers, OfArraysAreThoseOfTheProcessor) {
  const auto ours = test::lane_cases<Float4, Int4>(), plain = test::plain_lane_cases();
  ASSERT_EQ(ours.size(), plain.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ASSERT_EQ(ours[i].what, plain[i].what);
    EXPECT_TRUE(same(ours[i].found, plain[i].found, ours[i].exact)) << ours[i].what;
  }
}

TEST(Float4Numbers, ANaNAndASignedZeroComeFromTheSecondOperand) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Float4 a{nan, 1, 0.0f, -0.0f}, b{1, nan, -0.0f, 0.0f};
  for (const Float4 v : {min(a, b), max(a, b)}) {
    EXPECT_EQ(v[0], 1);
    EXPECT_TRUE(std::isnan(v[1]));
    EXPECT_TRUE(std::signbit(v[2]));
    EXPECT_FALSE(std::signbit(v[3]));
  }
}

TEST(Float4Numbers, FloorRoundsDown) {
  const Int4 v = floor_to_int({-0.25f, -3, 2147483520.0f, -2147483520.0f});
  EXPECT_EQ(test::bits_of(v), test::bits_of(Int4{-1, -3, 2147483520, -2147483520}));
  const Int4 w = floor_to_int({-0.0f, 0.99999994f, -1e-45f, 7.5f});
  EXPECT_EQ(test::bits_of(w), test::bits_of(Int4{0, 0, -1, 7}));
}

TEST(Float4Numbers, HoldVectors) {
  EXPECT_EQ(test::bits_of(Float4{}), (LaneBits{0, 0, 0, 0}));
  EXPECT_EQ(test::bits_of(Int4{}), (LaneBits{0, 0, 0, 0}));
  EXPECT_EQ(vec3(widen(Vec3f(1, 2, 3))), Vec3f(1, 2, 3));
  EXPECT_EQ(vec3(widen(Vec3i(-4, 5, -6))), Vec3i(-4, 5, -6));
  EXPECT_EQ(widen(Vec3f(1, 2, 3))[3], 0);
  EXPECT_EQ(widen(Vec3f(1, 2, 3), 9)[3], 9);
  EXPECT_EQ(widen(Vec3i(1, 2, 3))[3], 0);
  EXPECT_EQ(test::bits_of(splat(5)), test::bits_of(Int4{5, 5, 5, 5}));
  EXPECT_EQ(test::bits_of(splat(0.5f)), test::bits_of(Float4{0.5f, 0.5f, 0.5f, 0.5f}));
}

TEST(Float4Numbers, TheSpareOneDoesNotCount) {
  EXPECT_EQ(least({3, 2, 4, 1}), 2);
  EXPECT_EQ(least({3, 5, -4, -9}), -4);
  EXPECT_EQ(least({-0.5f, 5, 4, -9}), -0.5f);
  EXPECT_EQ(any_bits({1, 4, 16, 64}), 21);
}

static_assert(sizeof(Float4) == 16 && alignof(Float4) == 16 && sizeof(Int4) == 16);
static_assert(std::is_trivially_copyable_v<Float4> && std::is_trivially_copyable_v<Int4>);

}  // namespace float4_test
}  // namespace pvol
