// What each of many lights brings to a place, in tables or one by one.
#include "render/path/many_lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace pvol {
namespace many_lights_test {

using detail::ManyLights;

double irradiance_at(const LightSource& light, Vec3d place) {
  const auto of = [&](const auto& l) { return l.irradiance_on({place, place}); };
  return double(luminance(std::visit(of, light)));
}

TEST(ManyLights, AreWeighedByWhatTheyBring) {
  const std::vector<Light> sun{Sun{{1, 2, 3}, Rgb(3.0f), 1}};
  const std::vector<Light> points{PointLight{{1, 2, 3}, Rgb(5.0f, 2.0f, 1.0f)},
                                  PointLight{{-4, 0, 2}, Rgb(0.3f), {}, 0.5},
                                  PointLight{{1e6, 2, 0}, Rgb(1e9f)}};
  const std::vector<Light> others{SpotLight{.position = {0, 5, 0}, .direction = {0, -1, 0}},
                                  AreaLight{.position = {3, 0, 0}, .direction = {-1, 0, 0}}};
  const auto join = [](std::vector<const std::vector<Light>*> parts) {
    std::vector<Light> all;
    for (const auto* const part : parts) all.insert(all.end(), part->begin(), part->end());
    return all;
  };
  // In the order of scenes, and in others, with points first, last, apart and missing.
  for (const std::vector<Light>& lights :
       {join({&sun, &points, &others}), join({&points, &others}), join({&others, &points}),
        join({&points, &sun, &points}), join({&others, &sun}), join({&points})}) {
    const std::vector<LightSource> sources = make_light_sources(lights);
    const ManyLights many(sources);
    for (const Vec3d place : {Vec3d(0.0), Vec3d(0.5, -2, 7), Vec3d(1e5, 0, -1e5)}) {
      std::vector<double> weights(sources.size(), -1);
      many.weigh(place, weights);
      for (std::size_t i = 0; i < sources.size(); ++i) {
        const double expected = irradiance_at(sources[i], place);
        EXPECT_NEAR(weights[i], expected, 1e-6 * expected) << i;
      }
    }
  }
}

TEST(ManyLights, AreFiniteWhereTheyAre) {
  const std::vector<Light> lights{PointLight{{1, 2, 3}, Rgb(5.0f)},
                                  PointLight{{1, 2, 3}, Rgb(0.0f)}};
  std::vector<double> weights(2);
  ManyLights(make_light_sources(lights)).weigh({1, 2, 3}, weights);
  EXPECT_GT(weights[0], 1e20);
  EXPECT_TRUE(std::isfinite(weights[0]));
  EXPECT_EQ(weights[1], 0);
}

}  // namespace many_lights_test
}  // namespace pvol
