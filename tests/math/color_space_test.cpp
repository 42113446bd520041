// Spaces of linear colours: conversions against published matrices, and what cannot be converted.
#include "pvol/math/color_space.h"

#include <gtest/gtest.h>

namespace pvol {
namespace color_space_test {

void expect_rows(const Affine& a, const double (&rows)[3][3], double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(a.m[i][j], rows[i][j], tolerance) << i << ", " << j;
  }
}

TEST(ColorSpaces, ConversionsAreThePublishedOnes) {
  // OpenColorIO-Config-ACES, "Linear Rec.709 (sRGB)" to "ACEScg", which adapts by Bradford.
  expect_rows(conversion(ColorSpace::rec709, ColorSpace::acescg),
              {{0.613097, 0.339523, 0.047379},
               {0.070194, 0.916354, 0.013452},
               {0.020616, 0.109570, 0.869815}},
              2e-6);
  // ITU-R BT.2087-0, table 2.
  expect_rows(conversion(ColorSpace::rec709, ColorSpace::rec2020),
              {{0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}}, 6e-5);
  // S-2014-004, ACEScg: AP1 to AP0.
  expect_rows(conversion(ColorSpace::acescg, ColorSpace::aces),
              {{0.6954522414, 0.1406786965, 0.1638690622},
               {0.0447945634, 0.8596711185, 0.0955343182},
               {-0.0055258826, 0.0040252103, 1.0015006723}},
              1e-9);
  // CSS Color Module Level 4, sample code: display-p3 to XYZ to srgb-linear.
  expect_rows(conversion(ColorSpace::p3, ColorSpace::rec709),
              {{1.2249401762805598, -0.2249401762805598, 0},
               {-0.0420569547096881, 1.0420569547096881, 0},
               {-0.0196375545903344, -0.0786360455506319, 1.0982736001409663}},
              1e-9);
}

TEST(ColorSpaces, ConversionsThereAndBackAreNone) {
  for (const auto& a : names(ColorSpace{})) {
    EXPECT_EQ(find_space(primaries_of(a.value)), a.value) << a.name;
    for (const auto& b : names(ColorSpace{})) {
      const Affine there = conversion(a.value, b.value), back = conversion(b.value, a.value);
      expect_rows(back * there, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1e-12);
      const Vec3d white = there.vector(Vec3d(1.0));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-12) << a.name << " " << b.name;
    }
    EXPECT_EQ(conversion(a.value, a.value), Affine{}) << a.name;
  }
}

TEST(ColorSpaces, LuminanceIsTheSecondRowOfTheWayToXyz) {
  const Vec3d w = luminance_weights(ColorSpace::acescg);  // S-2014-004
  EXPECT_NEAR(w.x, 0.2722287168, 1e-9);
  EXPECT_NEAR(w.y, 0.6740817658, 1e-9);
  EXPECT_NEAR(w.z, 0.0536895174, 1e-9);
  for (const auto& s : names(ColorSpace{})) {
    const Vec3d weights = luminance_weights(s.value);
    EXPECT_NEAR(weights.x + weights.y + weights.z, 1, 1e-12) << s.name;
  }
}

TEST(ColorSpaces, ColoursOutsideTheGamutKeepTheirLuminance) {
  const Vec3d green = conversion(ColorSpace::acescg, ColorSpace::rec709).vector({0, 1, 0});
  ASSERT_LT(green.x, 0);
  const Vec3d weights = luminance_weights(ColorSpace::rec709);
  const Vec3d inside = into_gamut(green, weights);
  EXPECT_GE(min_component(inside), 0);
  EXPECT_NEAR(dot(inside, weights), dot(green, weights), 1e-12);
  const Vec3d cut = into_gamut({1, 0.5, -0.2}, weights);
  EXPECT_EQ(cut.z, 0);
  EXPECT_NEAR(dot(cut, weights), 0.2126 + 0.5 * 0.7152 - 0.2 * 0.0722, 1e-12);
  EXPECT_EQ(into_gamut({0.25, 0.5, 1}, weights), Vec3d(0.25, 0.5, 1));
  EXPECT_EQ(into_gamut({-1, 0, 0.1}, weights), Vec3d(0.0));
}

TEST(ColorSpaces, PrimariesThatSpanNoColoursHaveNoConversion) {
  const Primaries good = primaries_of(ColorSpace::rec709);
  Primaries line = good, dark = good, outside = good, below = good;
  outside.white = {0.7, 0.3}, below.white = {0.3, -0.1};
  line.blue = {(line.red.x + line.green.x) / 2, (line.red.y + line.green.y) / 2};
  dark.white = {0.3, 0};
  for (const Primaries& bad : {line, dark, outside, below, Primaries{}}) {
    EXPECT_FALSE(conversion(bad, good));
    EXPECT_FALSE(conversion(good, bad));
    EXPECT_FALSE(find_space(bad));
  }
}

}  // namespace color_space_test
}  // namespace pvol
