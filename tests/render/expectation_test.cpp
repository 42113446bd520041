// What whole images converge to: closed forms, and the same for all trackers, estimators and
// placements.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "pvol/render/render.h"
#include "support/small_cloud.h"
#include "support/statistics.h"

namespace pvol {
namespace expectation_test {

using std::numbers::pi;
using test::cloud;
using test::cloud_scene;
using test::CloudScene;
using test::cube_of_leaves;
using test::run;

constexpr Tracker kTrackers[] = {Tracker::delta_global, Tracker::delta, Tracker::decomposition};
constexpr Transmittance kEstimators[] = {Transmittance::ratio, Transmittance::analog};

/// Mean of a channel over the image, and its standard error squared.
struct Estimate {
  double mean = 0, variance = 0;
};

Estimate image_mean(const Film& film, int channel) {
  Estimate e;
  for (const PixelSums& p : film.pixels) {
    e.mean += mean(p)[channel];
    e.variance += variance_of_mean(p)[channel];
  }
  const double n = double(film.pixels.size());
  return {e.mean / n, e.variance / (n * n)};
}

/// The same of green over the 4 x 4 pixels from (x, y): enough samples for a normal distribution.
Estimate block_mean(const Film& film, int x, int y) {
  Estimate e;
  for (int k = 0; k < 16; ++k) {
    const PixelSums& p = film.at(x + k % 4, y + k / 4);
    e.mean += mean(p).y / 16;
    e.variance += variance_of_mean(p).y / 256;
  }
  return e;
}

double p_value(const Estimate& a, const Estimate& b) {
  return proof::normal_p_value((a.mean - b.mean) / std::sqrt(a.variance + b.variance));
}

double p_value(const Estimate& a, double expected) { return p_value(a, Estimate{expected, 0}); }

/// Every path in a cloud of albedo 1 ends in the sky with its throughput untouched.
TEST(Render, WhiteFurnaceIsExactInEveryPixel) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.environment = ConstantSky{Rgb(0.5f, 0.25f, 2.0f)};
  s.medium.albedo = Rgb(1.0f);
  s.options.samples = 8;
  for (const Tracker tracker : kTrackers) {
    for (const LookUp look_up : {LookUp::nearest, LookUp::trilinear}) {
      for (const double g : {-0.9999, 0.0, 0.9999}) {
        s.options.tracker = tracker;
        s.options.look_up = look_up;
        s.medium.g = g;
        for (const PixelSums& p : run(cloud(), s).film.pixels) {
          EXPECT_EQ(mean(p), Vec3d(0.5, 0.25, 2.0));
        }
      }
    }
  }
}

/// Two suns that fill a hemisphere each are a constant sky: next-event estimation and the balance
/// heuristic against a closed form, for forward, isotropic and backward phase functions.
TEST(Render, WhiteFurnaceOfTwoHemisphericalSuns) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.albedo = Rgb(1.0f);
  const double angle = 179.9;
  const double sine = std::sin(angle / 2 * pi / 180);
  const float irradiance = float(0.7 * pi * sine * sine);  // radiance 0.7
  s.lights = {Sun{{1, 2, 3}, Rgb(irradiance), angle}, Sun{{-1, -2, -3}, Rgb(irradiance), angle}};
  proof::Family family;
  for (const Transmittance estimator : kEstimators) {
    for (const double g : {-0.8, 0.0, 0.95}) {
      s.options.transmittance = estimator;
      s.medium.g = g;
      // The ring between the two discs is 0.1 degrees wide: 0.09 % of the sphere.
      const double expected = 0.7 * (1 - std::cos(angle / 2 * pi / 180));
      family.add("g = " + std::to_string(g),
                 p_value(image_mean(run(cloud(), s).film, 0), expected));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A constant picture as sky is sampled by next-event estimation, too.
TEST(Render, WhiteFurnaceOfAPicture) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.environment = ImageSky{8, 4, std::vector<Rgb>(32, Rgb(0.8f)), Rgb(1.0f), 30};
  proof::Family family;
  for (const double g : {-0.5, 0.0, 0.9}) {
    s.medium.g = g;
    family.add("g = " + std::to_string(g),
               p_value(image_mean(run(cloud(), s).film, 1), double(0.8f)));
  }
  EXPECT_TRUE(family.passes());
}

/// A camera far away that sees the middle of the cube's front face, along -z.
CloudScene cube_scene(double extinction) {
  CloudScene s;
  s.camera.position = {7.5, 7.5, 4000};
  s.camera.target = {7.5, 7.5, 0};
  s.camera.fov = 0.02;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.extinction = extinction;
  s.medium.g = 0;
  s.options.width = s.options.height = 4;
  s.options.samples = 4000;
  s.options.look_up = LookUp::nearest;
  return s;
}

TEST(Render, AbsorptionFollowsBeerAndLambert) {
  proof::Family family;
  for (const double extinction : {1e-12, 0.001, 0.02, 0.3}) {
    CloudScene s = cube_scene(extinction);
    s.medium.albedo = Rgb(0.0f);
    s.environment = ConstantSky{Rgb(2.0f)};
    for (const Tracker tracker : kTrackers) {
      s.options.tracker = tracker;
      const Film film = run(cube_of_leaves(), s).film;
      const double transmittance = std::exp(-16 * extinction);
      const Estimate e = image_mean(film, 0);
      if (e.variance == 0) {  // no path collided
        EXPECT_NEAR(e.mean, 2 * transmittance, 1e-9);
      } else {
        family.add("extinction " + std::to_string(extinction), p_value(e, 2 * transmittance));
      }
      double alpha = 0;
      for (const PixelSums& p : film.pixels) alpha += p.alpha / p.samples / 16;
      EXPECT_NEAR(alpha, 1 - e.mean / 2, 1e-12);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// L = albedo E / (4 pi) exp(-mu h) (1 - exp(-mu D)): light from above passes h = 8 of the cube to
/// reach the view ray, which is D = 16 long.
TEST(Render, SingleScatteringHasItsClosedForm) {
  proof::Family family;
  for (const double extinction : {0.01, 0.1, 0.4}) {
    CloudScene s = cube_scene(extinction);
    s.medium.albedo = Rgb(0.8f);
    s.lights = {Sun{{0, 1, 0}, Rgb(5.0f), 0}};
    s.options.max_bounces = 1;
    const double expected =
        double(0.8f) * 5 / (4 * pi) * std::exp(-8 * extinction) * (1 - std::exp(-16 * extinction));
    for (const Transmittance estimator : kEstimators) {
      s.options.transmittance = estimator;
      family.add("extinction " + std::to_string(extinction),
                 p_value(image_mean(run(cube_of_leaves(), s).film, 2), expected));
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(Render, TrackersAndEstimatorsAgree) {
  CloudScene s = cloud_scene();
  s.options.samples = proof::samples(256);
  s.lights.emplace_back(Sun{{-1, 0.2, 0.1}, Rgb(2.0f, 1.0f, 0.5f), 25});
  std::vector<Film> films;
  for (const Tracker tracker : kTrackers) {
    for (const Transmittance estimator : kEstimators) {
      for (const std::optional<int> depth : {std::optional<int>(), std::optional<int>(1)}) {
        s.options.tracker = tracker;
        s.options.transmittance = estimator;
        s.options.depth = depth;
        ++s.options.seed;
        films.push_back(run(cloud(), s).film);
      }
    }
  }
  proof::Family family;
  for (std::size_t i = 1; i < films.size(); ++i) {
    family.add(std::to_string(i), p_value(image_mean(films[0], 0), image_mean(films[i], 0)));
    for (int block = 0; block < 9; ++block) {
      const int x = 4 * (block % 3), y = 4 * (block / 3);
      family.add("image " + std::to_string(i) + " block " + std::to_string(block),
                 p_value(block_mean(films[0], x, y), block_mean(films[i], x, y)));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Instances scaled, moved or mirrored with their camera and lights look the same; the optical
/// depth scales with the size unless the extinction is divided by it.
TEST(Render, PlacementInTheWorldChangesNothing) {
  const CloudScene s = cloud_scene();
  const Estimate reference = image_mean(run(cloud(), s).film, 1);
  proof::Family family;
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double mirror : {1.0, -1.0}) {
      Affine a = scaling(Vec3d(mirror * scale, scale, scale));
      a.t = Vec3d(7, -3, 11) * scale;
      CloudScene placed = s;
      placed.medium.object_to_world = a;
      placed.medium.extinction = s.medium.extinction / scale;
      placed.camera.position = a.point(s.camera.position);
      placed.camera.target = a.point(s.camera.target);
      std::get<Sun>(placed.lights[0]).direction = a.vector(std::get<Sun>(s.lights[0]).direction);
      placed.options.seed = 7;
      family.add("scale " + std::to_string(scale * mirror),
                 p_value(reference, image_mean(run(cloud(), placed).film, 1)));
    }
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace expectation_test
}  // namespace pvol
