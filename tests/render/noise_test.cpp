// Noise, which no mean tells: rays that are to be independent are, and samples go where light comes
// from.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "pvol/math/direction.h"
#include "pvol/render/sky_picture.h"
#include "support/effort.h"
#include "support/lit_scenes.h"
#include "support/pictures.h"
#include "support/simd_kernels.h"

namespace pvol::test {
namespace noise_test {

/// The variance of a sample's luminance, over the pixels of a picture.
double noise_of(const CloudScene& scene, KernelKind kernel = KernelKind::automatic) {
  CloudScene s = scene;
  const Volume v = volume_of(s);
  s.options.kernel = kernel;
  const Film film = render(std::span<const Volume>(&v, 1), s).film;
  double sum = 0;
  for (const PixelSums& p : film.pixels) {
    const Vec3d variance = variance_of_mean(p);
    sum += (variance.x + variance.y + variance.z) * p.samples;
  }
  return sum / double(3 * film.pixels.size());
}

CloudScene long_run() {
  CloudScene s = sunny();
  s.options.samples = 1000;
  return s;
}

/// Both are the same estimator with other numbers. Where several shadow rays go to one light, and
/// where paths are split, they are worth several.
TEST(Noise, OfLanesIsThatOfFlightsOneByOne) {
  if (simd_kernels().empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  CloudScene forward = long_run(), isotropic = long_run(), thick = long_run(), lit = long_run();
  isotropic.medium.g = 0;
  thick.medium.extinction = 3;
  lit.lights = {PointLight{{60, 30, 40}, Rgb(6e3f)}};
  lit.environment = ConstantSky{Rgb(0.0f)};
  for (const auto& [name, scene] :
       {std::pair("forward", &forward), std::pair("isotropic", &isotropic),
        std::pair("thick", &thick), std::pair("lamp", &lit)}) {
    const bool by_night = scene == &isotropic || scene == &thick;
    if (by_night && !proof::runs_all()) continue;
    CloudScene s = *scene;
    s.options.transmittance = Transmittance::analog;
    const double lanes = noise_of(s, simd_kernels().back());
    s.options.seed = 2;
    const double scalar = noise_of(s, KernelKind::scalar);
    EXPECT_NEAR(lanes / scalar, 1, 0.08) << name;
  }
}

/// Guiding knows where the light of each kind of lamp comes from.
TEST(Noise, FallsByGuidingUnderEachLamp) {
  const Light lamps[] = {
      AreaLight{{60, 45, 50}, {-1, -0.7, -0.8}, {20, 20}, {0, 1, 0}, Rgb(30.0f), ""},
      PointLight{{60, 45, 50}, Rgb(9e3f), "", 10},
      SpotLight{{60, 45, 50}, {-1, -0.7, -0.8}, Rgb(9e3f), 90, 0.2, ""},
  };
  for (const Light& lamp : lamps) {
    CloudScene s = long_run();
    s.environment = ConstantSky{Rgb(0.0f)};
    s.lights = {lamp};
    const double guided = noise_of(s);
    s.options.guide = GuideUse::off;
    EXPECT_LT(guided / noise_of(s), 0.5) << lamp.index();
  }
}

/// No direction of a smooth picture is much rarer than its light: not beside a bright pixel either.
TEST(Noise, OfASmoothSkyIsBounded) {
  constexpr int kWidth = 16, kHeight = 8, kBrightX = 5, kBrightY = 2;
  ImageSky image{kWidth, kHeight, std::vector<Rgb>(kWidth * kHeight, Rgb(0.1f))};
  image.pixels.edit()[kBrightY * kWidth + kBrightX] = Rgb(100.0f);
  const SkyPicture sky(image, SkyPixels::smooth);
  const auto weight = [&](Vec3f d) { return luminance(sky.radiance(d)) / sky.pdf(d); };
  const float most =
      weight(sky.direction_at((kBrightX + 0.5) / kWidth, (kBrightY + 0.5) / kHeight));
  for (int y = 0; y < 20 * kHeight; ++y) {
    for (int x = 0; x < 20 * kWidth; ++x) {
      const Vec3f d = sky.direction_at((x + 0.5) / (20 * kWidth), (y + 0.5) / (20 * kHeight));
      ASSERT_LE(weight(d), 1.001f * most) << x << ", " << y;
    }
  }
}

}  // namespace noise_test
}  // namespace pvol::test
