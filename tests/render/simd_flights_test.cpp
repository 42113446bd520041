// Flights of the lane kernels against closed forms: how many of a camera ray's
// flights collide, and how many shadow rays arrive.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "pvol/embed.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/lit_scenes.h"
#include "support/pictures.h"
#include "support/statistics.h"

namespace pvol::test {
namespace simd_flights_test {

/// Pixels that see all but a point: every sample is nearly the same ray.
CloudScene one_ray(Vec3d from, Vec3d to) {
  CloudScene s;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.camera.position = from;
  s.camera.target = to;
  const Vec3d d = normalize(to - from);
  s.camera.up = std::abs(d.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  s.camera.fov = 1e-4;
  s.options.width = s.options.height = 32;
  s.options.samples = proof::samples(512);
  s.options.max_bounces = 0;
  s.options.guide = GuideUse::off;
  return s;
}

/// In fields of every kind, along rays across and askew: the share of flights
/// that collide is 1 - exp(-tau).
TEST(SimdFlights, CollideAsOftenAsTheOpticalDepthSays) {
  proof::Family family;
  for (const Field& f : fields()) {
    for (const LookUp look_up : {LookUp::trilinear, LookUp::nearest}) {
      const Volume whole = make_test_volume(f, 1, std::nullopt);
      const Box box = whole.density.world_box;
      const Vec3d middle = box.centre(), size = box.extent();
      for (const Vec3d& way : {Vec3d{1, 0.013, -0.02}, Vec3d{0.4, -0.7, 0.6}}) {
        const Vec3d to = middle + size * Vec3d{0.03, -0.02, 0.05};
        CloudScene s = one_ray(to - normalize(way) * (2 * length(size)), to);
        s.options.look_up = look_up;
        const Ray ray{s.camera.position, normalize(to - s.camera.position)};
        const double far = 4 * length(size);
        s.medium.extinction = 1;
        const double depth =
            -std::log(exact_transmittance(make_volume(f.grid, build_pyramid(f.grid), s), ray, far));
        if (!(depth > 0.05)) continue;    // the ray hardly meets the field
        s.medium.extinction = 1 / depth;  // of 1 - 1/e
        const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
        const double expected = 1 - exact_transmittance(v, ray, far);
        double n = 0, collided = 0;
        for (const PixelSums& p : render(v, s).film.pixels) n += p.samples, collided += p.alpha;
        const double spread = std::sqrt(expected * (1 - expected) / n);
        family.add(f.name + ", " + name(look_up),
                   proof::normal_p_value((collided / n - expected) / spread));
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Light that scattered once: where the first flights end, how many shadow rays
/// arrive, and what they weigh, against flights one by one in closed form
/// (regular tracking and transmittance); in thin voxels and in those of a thousand free paths.
TEST(SimdFlights, BringTheLightOfOneScattering) {
  proof::Family family;
  proof::Moments deviations;
  for (const char* name : {"constant", "gaussian", "contrast", "tiles_8"}) {
    const Field& f = field(name);
    for (const auto& [extinction, g] : {std::pair{0.15, 0.0}, {0.15, 0.8}, {1000.0, 0.8}}) {
      if (extinction > 1 && std::string(name) != "gaussian") continue;
      CloudScene s;
      s.environment = ConstantSky{Rgb(0.0f)};
      s.lights = {Sun{{0.3, 0.8, 0.4}, Rgb(2.0f), 0}};
      s.medium = component(extinction, Rgb(1.0f), g);
      s.options.width = s.options.height = 32;
      s.options.samples = proof::samples(600);
      s.options.max_bounces = 1;
      s.options.guide = GuideUse::off;
      s.options.tracker = Tracker::regular;
      s.options.transmittance = Transmittance::regular;
      const Volume exact = make_volumes(f, std::vector{s.medium}, s).front();
      s.camera = frame(exact.density.world_box, 1);
      const Average a = average(render(exact, s).film);
      s.options.tracker = Tracker::decomposition;
      s.options.transmittance = Transmittance::automatic;
      s.options.samples = proof::samples(2000);
      s.options.seed = 2;
      const Volume v = make_volumes(f, std::vector{s.medium}, s).front();
      const Average b = average(render(v, s).film);
      deviations.add(compare(
          b, a, name + (", extinction " + std::to_string(extinction)) + ", g " + std::to_string(g),
          family));
    }
  }
  add_all_together(deviations, family);
  EXPECT_TRUE(family.passes());
}

/// What guiding does to weights, in each of its steps, at a noise that shows 1
/// %.
TEST(SimdFlights, GuidedOnesBringWhatPlainOnesDo) {
  proof::Family family;
  std::size_t turn = 0;
  for (Case& c : cases()) {
    constexpr const char* kSome[] = {"forward", "isotropic", "two components", "sun disc"};
    if (std::ranges::find(kSome, c.name) == std::end(kSome)) continue;
    c.scene.environment = ConstantSky{Rgb(0.0f)};
    c.scene.options.threads = 0;
    ++turn;
    for (const double extinction : {0.4, 4.0}) {
      if (!proof::has_turn(turn + (extinction > 1))) continue;
      CloudScene s = c.scene;
      s.medium.extinction = extinction;
      const Volume v = volume_of(s);
      s.options.guide = GuideUse::on;
      s.options.samples = proof::samples(1500);
      const Average guided = average(render(v, s).film);
      s.options.guide = GuideUse::off;
      s.options.samples = proof::samples(8000);
      s.options.seed = 2;
      compare(guided, average(render(v, s).film), c.name + ", " + std::to_string(extinction),
              family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Two suns of half a sky each are a white furnace, and each by itself is one
/// light that guided paths look for: their two pictures add up to 1, whatever
/// weights do on the way.
TEST(SimdFlights, GuidedOnesInTwoHalvesOfAFurnaceAddUp) {
  proof::Family family;
  for (const double extinction : {0.4, 2.0}) {
    for (const double g : {0.0, 0.8}) {
      Average sum;
      for (const double side : {1.0, -1.0}) {
        CloudScene s = sunny();
        s.environment = ConstantSky{Rgb(0.0f)};
        s.lights = {Sun{Vec3d{0.6, 0.8, 0.35} * side, Rgb(float(std::numbers::pi)), 179.99}};
        s.medium = component(extinction, Rgb(1.0f), g);
        s.options.samples = proof::samples(8000, 64);
        s.options.threads = 0;
        s.options.seed = side > 0 ? 1 : 2;
        sum = sum + average(render(volume_of(s), s).film);
      }
      constexpr double kGap = 2e-4;  // of the sky that neither covers
      compare(sum, {Vec3d(1.0), Vec3d(0.0)}, "extinction " + std::to_string(extinction), family,
              kGap);
    }
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace simd_flights_test
}  // namespace pvol::test
