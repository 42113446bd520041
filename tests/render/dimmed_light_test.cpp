// Light that a wedge of density dims, in closed form: for every tracker and estimator of the
// transmittance, grey and by channel.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "support/estimators.h"
#include "support/oracle.h"
#include "support/pictures.h"
#include "support/surface_pixel.h"

namespace pvol::test {
namespace dimmed_light_test {

/// A cube whose density grows along every axis: many tentative collisions are null.
const Field& wedge() {
  static const Field f = make_field("wedge", {0, 0, 0}, {20, 20, 20},
                                    [](Vec3i p) { return (p.x + 2 * p.y + 3 * p.z) / 120.0; });
  return f;
}

/// Absorbs alone; its optical depth is about 3.
Body wedge_above_ground() {
  return component(0.3, Rgb(0.0f), 0, Rgb(0.0f), translation({0, 5, 0}));
}

/// A pixel, what it sees without the wedge, and the ray that this dims.
struct Dimmed {
  Pixel pixel;
  double open;
  Ray ray;
};

/// A sky behind the wedge.
Dimmed sky_through() {
  const Vec3d from{6, 11, 60}, to{11, 14, 0};
  Dimmed d{Pixel(wedge_above_ground(), from, to), 0.7, {from, normalize(to - from)}};
  d.pixel.scene.environment = ConstantSky{Rgb(0.7f)};
  return d;
}

/// The ground in the shadow of the wedge.
Dimmed sun_through() {
  const Vec3d to_sun = normalize(Vec3d(0.1, 1, 0.2)), place{9, 0, 9};
  Dimmed d{Pixel(wedge_above_ground(), {9, 2, 12}, place),
           0.5 / std::numbers::pi * 3 * to_sun.y,
           {place, to_sun}};
  d.pixel.scene.surfaces = {ground(0.5)};
  d.pixel.scene.lights = {Sun{to_sun, Rgb(3.0f), 0}};
  return d;
}

void check(Dimmed d, std::uint32_t samples, Rgb color, const std::string& name,
           proof::Family& family) {
  CloudScene& s = d.pixel.scene;
  s.options.samples = samples;
  s.options.guide = GuideUse::off;
  s.options.look_up = LookUp::trilinear;
  Volume v = make_volumes(wedge(), std::vector{s.medium}, s).front();
  v.medium.extinction_color = color;
  const Affine to_object = inverse(s.medium.object_to_world);
  const Ray ray{to_object.point(d.ray.o), d.ray.d};
  const double depth =
      RayOracle(wedge(), LookUp::trilinear, ray, s.medium.extinction).optical_depth();
  EXPECT_GT(depth, 2);
  Vec3d expected;
  for (int c = 0; c < 3; ++c) {
    expected[c] = d.open * std::exp(-double(color[c]) * depth);
  }
  const Average found = average(render({&v, 1}, s).film);
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(std::sqrt(found.variance[c]), 0.012 * expected[c]) << name << ": too few samples";
  }
  compare(found, {expected, Vec3d(0.0)}, name, family, 1e-4 * min_component(expected));
}

const std::vector<std::pair<std::string, Rgb>> kColors{{"grey", Rgb(1.0f)},
                                                       {"by channel", Rgb(1.0f, 0.6f, 0.2f)}};

TEST(DimmedLight, OfTheSkyIsSeenByEveryTracker) {
  proof::Family family;
  for (const auto& [color_name, color] : kColors) {
    for (const Tracker tracker : kTrackers) {
      if (tracker == Tracker::regular && is_chromatic({.extinction_color = color})) continue;
      for (const double scale : {1.0, 0.8}) {
        if (scale < 1 && !is_weighted(tracker)) continue;
        Dimmed d = sky_through();
        d.pixel.scene.options.tracker = tracker;
        d.pixel.scene.options.majorant_scale = scale;
        check(d, proof::samples(1'600'000u), color,
              label(tracker) + std::string(scale < 1 ? ", scaled, " : ", ") + color_name, family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(DimmedLight, OfTheSunIsFoundByEveryEstimator) {
  proof::Family family;
  for (const auto& [color_name, color] : kColors) {
    // Fewer samples where the noise is less; closed forms of grey have none.
    const bool by_channel = is_chromatic({.extinction_color = color});
    for (const auto& [estimator, parts] : {std::pair(Transmittance::analog, by_channel ? 16u : 8u),
                                           {Transmittance::ratio, by_channel ? 16u : 8u},
                                           {Transmittance::residual_ratio, 16u},
                                           {Transmittance::regular, by_channel ? 16u : 128u}}) {
      Dimmed d = sun_through();
      d.pixel.scene.options.transmittance = estimator;
      check(d, proof::samples(1'600'000u, parts), color,
            name(estimator) + std::string(", ") + color_name, family);
    }
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace dimmed_light_test
}  // namespace pvol::test
