// The irradiance of whole skies on planes in the open, against closed forms.
#include "render/light/open_sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/math/direction.h"
#include "pvol/render/lights.h"

namespace pvol::test {
namespace open_sky_test {

constexpr double kPi = std::numbers::pi;

double irradiance(const Environment& sky, Vec3d normal) {
  return double(detail::OpenSky(SkyLight(sky)).irradiance(normal).y);
}

TEST(OpenSky, OfAConstantSkyIsPiTimesItsRadianceOnEveryPlane) {
  for (int i = 0; i < 50; ++i) {
    EXPECT_NEAR(irradiance(ConstantSky{Rgb(0.8f)}, direction_on_spiral(i, 50)) / (0.8 * kPi), 1,
                2e-3);
  }
}

TEST(OpenSky, OfAGradientIsItsIntegral) {
  // Radiance falls in proportion to the cosine from the zenith to the horizon.
  const GradientSky sky{Rgb(0.9f), Rgb(0.3f), Rgb(5.0f), {0, 1, 0}};
  EXPECT_NEAR(irradiance(sky, {0, 1, 0}) / (kPi * (0.3 + (0.9 - 0.3) * 2 / 3)), 1, 2e-3);
}

TEST(OpenSky, OfAPictureIsThatOfItsPixels) {
  const ImageSky sky{2, 2, {Rgb(4.0f), Rgb(0.0f), Rgb(9.0f), Rgb(9.0f)}};
  EXPECT_NEAR(irradiance(sky, {0, 1, 0}) / (2 * kPi), 1, 2e-3);
  EXPECT_NEAR(irradiance(sky, {0, -1, 0}) / (9 * kPi), 1, 2e-3);
}

}  // namespace open_sky_test
}  // namespace pvol::test
