// Single scattering of a fire's light against its integral: the fire as many point lights.
#include <gtest/gtest.h>

#include <map>

#include "pvol/volume/emitter.h"
#include "support/bodies.h"
#include "support/estimators.h"

namespace pvol::test {
namespace fire_light_test {

/// One sample of 1: a tent of 2^3 cells around its place.
const Field& spark() {
  static const Field f = make_field("spark", {0, 0, 0}, {1, 1, 1}, [](Vec3i) { return 1.0; });
  return f;
}

double tent(double x) { return 1 - std::abs(x); }

/// Point lights that shine together as the spark does.
std::vector<Light> as_points(const Fire& fire, const Affine& place) {
  constexpr int kAlong = 6;
  const double volume = std::abs(determinant(place)) * std::pow(2.0 / kAlong, 3);
  std::vector<Light> all;
  const auto at = [](int i) { return (2 * i + 1.0) / kAlong - 1; };
  for (int i = 0; i < kAlong * kAlong * kAlong; ++i) {
    const Vec3d p{at(i % kAlong), at(i / kAlong % kAlong), at(i / (kAlong * kAlong))};
    const double share = fire.intensity * volume * tent(p.x) * tent(p.y) * tent(p.z);
    all.emplace_back(PointLight{place.point(p), fire.color * float(share)});
  }
  return all;
}

TEST(FireLight, SingleScatteringIsItsIntegral) {
  // Within the fire light comes from nearby, too: rare bright samples make skewed sums.
  struct Case {
    const char* name;
    Affine place;
    int samples = 150'000;
  };
  const Case cases[] = {
      {"beside", translation({20, 15, 9}) * scaling(Vec3d(2))},
      {"far", translation({-200, 90, 10}) * scaling(Vec3d(5))},
      {"stretched, within", translation({9, 4, 5}) * scaling(Vec3d(1, 0.5, 2)), 600'000},
  };
  const Affine aside{{Vec3d{0.8, 0.1, 0}, Vec3d{0, 0.7, 0.1}, Vec3d{0.1, 0, 0.9}}, {5, 3, -2}};
  const std::vector<Body> one{component(0.15, Rgb(1.0f, 0.5f, 0.25f), 0.4)};
  const std::vector<Body> two{one.front(), component(0.2, Rgb(0.9f), -0.3, Rgb(0.0f), aside)};
  const Fire fire{.intensity = 30, .color = Rgb(1.0f, 2.0f, 0.5f)};
  const Pyramid pyramid = build_pyramid(spark().grid);
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 300;
  std::map<std::pair<const Case*, std::size_t>, Vec3d> references;
  for (const Tracker tracker : kTrackers) {
    for (const Case& c : cases) {
      for (const std::vector<Body>& bodies : {one, two}) {
        if (bodies.size() > 1 && is_weighted(tracker)) continue;
        OneRay r(bodies, {6, 25, 30}, {6.5, 6, 5});
        r.scene.options.tracker = tracker;
        r.scene.options.samples = proof::samples(c.samples);
        r.scene.options.seed = ++seed;
        std::vector<Volume> volumes = make_volumes(cube(), r.bodies, r.scene);
        volumes.back().fire = std::make_shared<const Emitter>(
            make_emitter(fire, {spark().grid, pyramid}, nullptr, c.place));
        const Film film = render(volumes, r.scene).film;
        // All trackers are to find the same.
        const auto [expected, is_new] = references.try_emplace({&c, bodies.size()});
        if (is_new) {
          r.scene.lights = as_points(fire, c.place);
          expected->second = radiance(r);
        }
        all.add(
            compare(film, expected->second, std::string(c.name) + ", " + label(tracker), family));
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

}  // namespace fire_light_test
}  // namespace pvol::test
