// What films keep beside colour: that parts add up to the picture, and first collisions against
// closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "pvol/error.h"
#include "pvol/render/light_group.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol {
namespace aov_test {

using test::cloud;
using test::cloud_scene;
using test::CloudScene;
using test::cube_of_leaves;
using test::layer;
using test::run;
using test::same_bytes;

AovSet all_but(std::initializer_list<Aov> left_out) {
  AovSet set;
  for (const AovRow& r : kAovs) {
    if (std::find(left_out.begin(), left_out.end(), r.aov) == left_out.end()) set.add(r.aov);
  }
  return set;
}

/// Sun, sky and emission, in media of any colour or of one.
CloudScene bright_scene(bool grey, GuideUse guide) {
  CloudScene s = cloud_scene();
  if (grey) s.medium.albedo = Rgb(0.95f);
  s.medium.emission = Rgb(0.2f, 0.1f, 0.05f);
  s.environment = ConstantSky{Rgb(0.3f, 0.4f, 0.5f)};
  s.options.guide = guide;
  s.options.samples = 30;
  return s;
}

/// The part of the layers' sum that the picture does not have, at worst.
double worst_difference(const Film& film, const std::vector<std::string>& names) {
  double worst = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    Vec3d sum;
    for (const std::string& name : names) sum += value(layer(film, name), film, i);
    const Vec3d whole = mean(film.pixels[i]);
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(sum[c] - whole[c]) / (1 + std::abs(whole[c])));
    }
  }
  return worst;
}

TEST(Aov, PartsAddUpToThePicture) {
  for (const bool grey : {true, false}) {
    for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
      CloudScene s = bright_scene(grey, guide);
      s.options.aovs = all_but({});
      const Film film = run(cloud(), s).film;
      EXPECT_LT(worst_difference(film, {"unscattered", "single", "multiple"}), 1e-6);
      EXPECT_LT(worst_difference(film, {"sun_1", "sky", "emission"}), 1e-5);
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        const Layer &a = layer(film, "half_1"), &b = layer(film, "half_2");
        EXPECT_EQ(a.weights[i], 15);
        EXPECT_EQ(b.weights[i], 15);
        EXPECT_LT(length(a.sums[i] + b.sums[i] - film.pixels[i].sum), 1e-9);
        EXPECT_NE(a.sums[i], Vec3d{}) << "the sky at least";
      }
    }
  }
}

/// But that samples of two halves have places of their own in the pixel (halves_test.cpp).
TEST(Aov, LeaveThePictureAsItIs) {
  for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
    CloudScene s = bright_scene(false, guide);
    EXPECT_TRUE(run(cloud(), s).film.layers.empty());
    s.options.aovs.add(Aov::halves);
    const Film plain = run(cloud(), s).film;
    // Guided paths leave out what is constant, unless orders of scattering are asked for.
    s.options.aovs = guide == GuideUse::on ? all_but({Aov::scattering}) : all_but({});
    const Film with = run(cloud(), s).film;
    EXPECT_TRUE(same_bytes(plain, with));
    s.options.threads = 7;
    const Film other = run(cloud(), s).film;
    ASSERT_EQ(other.layers.size(), with.layers.size());
    for (std::size_t k = 0; k < with.layers.size(); ++k) {
      EXPECT_EQ(other.layers[k].sums, with.layers[k].sums) << with.layers[k].name;
      EXPECT_EQ(other.layers[k].weights, with.layers[k].weights) << with.layers[k].name;
    }
  }
}

/// What scattered once at most is the picture of paths that scatter once at most, and what did not
/// scatter is that of paths that may not.
TEST(Aov, OrdersAreThoseOfLimitedPaths) {
  proof::Family family;
  for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
    CloudScene s = bright_scene(true, guide);
    s.options.samples = proof::samples(4000);
    s.options.aovs = all_but({});
    const Film film = run(cloud(), s).film;
    s.options.aovs = {};
    s.options.guide = GuideUse::off;
    s.options.seed = 2;
    for (const std::uint32_t bounces : {0u, 1u}) {
      s.options.max_bounces = bounces;
      const Film limited = run(cloud(), s).film;
      test::Average part = test::average(limited), order;
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        order.mean += value(layer(film, "unscattered"), film, i) / double(film.pixels.size());
        if (bounces == 0) continue;
        order.mean += value(layer(film, "single"), film, i) / double(film.pixels.size());
      }
      order.variance = 2.0 * part.variance;  // guided paths have about as much
      EXPECT_LT(std::sqrt(part.variance.y), 0.002 * part.mean.y);
      compare(order, part, std::string(name(guide)) + ", " + std::to_string(bounces), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A homogeneous cube of density 1 from -0.5 to 15.5, seen along z from far above.
CloudScene slab_scene(double extinction) {
  CloudScene s;
  s.camera.position = {7.5, 7.5, 2000};
  s.camera.target = {7.5, 7.5, 0};
  s.camera.up = {0, 1, 0};
  s.camera.fov = 0.05;
  s.medium.extinction = extinction;
  s.medium.albedo = Rgb(0.7f, 0.8f, 0.9f);
  s.options.look_up = LookUp::nearest;
  s.options.width = s.options.height = 8;
  s.options.samples = 2000;
  s.options.max_bounces = 0;
  s.options.aovs = all_but({});
  return s;
}

TEST(Aov, FirstCollisionsLieWhereFlightsEnd) {
  proof::Family family;
  for (const double extinction : {0.02, 0.3}) {
    CloudScene s = slab_scene(extinction);
    const Film film = run(cube_of_leaves(), s).film;
    const double depth = 16 * extinction, hit = -std::expm1(-depth);
    // Of an exponential that ends within the cube.
    const double mean_way = 1 / extinction - 16 * std::exp(-depth) / hit;
    const double square =
        2 / (extinction * extinction) - std::exp(-depth) / hit * (16 * 16 + 2 * 16 / extinction);
    double hits = 0, sum = 0, nearest = kNothingMet;
    Vec3d place;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const Layer &d = layer(film, "depth"), &p = layer(film, "position");
      hits += d.weights[i], sum += d.sums[i].x, place += p.sums[i];
      nearest = std::min(nearest, value(layer(film, "nearest"), film, i).x);
      EXPECT_LE(value(layer(film, "nearest"), film, i).x, value(d, film, i).x);
      const Vec3d albedo = value(layer(film, "albedo"), film, i);
      EXPECT_LT(length(albedo - Vec3d(0.7, 0.8, 0.9)), 1e-6);
    }
    constexpr double kFace = 2000 - 15.5;
    const double deviation = std::sqrt((square - mean_way * mean_way) / hits);
    family.add("depth", proof::normal_p_value((sum / hits - kFace - mean_way) / deviation));
    EXPECT_LT(deviation, 0.005 * mean_way) << "1 % would show";
    EXPECT_GE(nearest, kFace - 1e-4);
    EXPECT_LT(nearest, kFace + 16);
    EXPECT_NEAR(place.z / hits, 2000 - sum / hits, 1e-6 * 2000);
    EXPECT_NEAR(place.x / hits, 7.5, 0.02);
  }
  EXPECT_TRUE(family.passes());
}

/// Of a ball whose density falls towards its rim, seen from everywhere: away from the middle.
TEST(Aov, NormalsPointToWhereThereIsLess) {
  const test::Field ball = test::make_field("ball", {-12, -12, -12}, {24, 24, 24}, [](Vec3i p) {
    return std::max(0.0, 1 - length(Vec3d(p)) / 11);
  });
  CloudScene s = cloud_scene();
  s.medium.extinction = 5;
  s.options.max_bounces = 0;
  s.options.aovs = all_but({});
  s.medium.object_to_world = translation(Vec3d{3, -2, 1}) * scaling(Vec3d{1, 1, 1.0});
  s.camera.target = {3, -2, 1};
  const Film film = run(ball, s).film;
  int seen = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    if (film.pixels[i].alpha < 0.9 * film.pixels[i].samples) continue;
    const Vec3d outward = value(layer(film, "position"), film, i) - Vec3d{3, -2, 1};
    const Vec3d normal = value(layer(film, "normal"), film, i);
    EXPECT_GT(dot(normalize(outward), normalize(normal)), 0.98);
    EXPECT_LE(length(normal), 1 + 1e-9);
    ++seen;
  }
  EXPECT_GT(seen, 20);
}

TEST(Aov, WhereNothingIsMetDepthsAreFar) {
  CloudScene s = slab_scene(0.3);
  s.camera.target = {7.5, 7.5, 4000};
  const Film film = run(cube_of_leaves(), s).film;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    EXPECT_EQ(value(layer(film, "depth"), film, i).x, kNothingMet);
    EXPECT_EQ(value(layer(film, "nearest"), film, i).x, kNothingMet);
    EXPECT_EQ(value(layer(film, "normal"), film, i), Vec3d{});
  }
}

TEST(Aov, LightsOfAGroupShareALayer) {
  CloudScene s = bright_scene(true, GuideUse::off);
  s.lights.emplace_back(Sun{{-1, 0.5, 0}, Rgb(1.0f), 0});
  s.lights.emplace_back(PointLight{{5, 8, 40}, Rgb(500.0f)});
  s.options.aovs = {Aov::lights};
  const Film apart = run(cloud(), s).film;
  std::get<Sun>(s.lights[0]).group = std::get<PointLight>(s.lights[2]).group = "key_light";
  std::get<Sun>(s.lights[1]).group = "sky";
  const Film grouped = run(cloud(), s).film;
  EXPECT_TRUE(same_bytes(apart, grouped));
  ASSERT_EQ(grouped.layers.size(), 3u);
  for (std::size_t i = 0; i < apart.pixels.size(); ++i) {
    const auto is_sum = [&](const char* group, const char* a, const char* b) {
      const Vec3d sum = value(layer(apart, a), apart, i) + value(layer(apart, b), apart, i);
      EXPECT_LT(length(value(layer(grouped, group), grouped, i) - sum), 1e-9 * (1 + length(sum)));
    };
    is_sum("key_light", "sun_1", "point_1");
    is_sum("sky", "sun_2", "sky");
  }
  for (const char* wrong : {"depth", "R", "sun.1", "a b", "single"}) {
    std::get<Sun>(s.lights[0]).group = wrong;
    EXPECT_THROW((void)run(cloud(), s), Error) << wrong;
  }
}

/// Films of several runs add up as one of all samples would.
TEST(Aov, OfFilmsAddUp) {
  CloudScene s = bright_scene(true, GuideUse::off);
  s.options.aovs = all_but({});
  s.options.samples = 7;
  Film a = run(cloud(), s).film;
  s.options.first_sample = 7;
  const Film b = run(cloud(), s).film;
  add_samples(a, b);
  s.options.first_sample = 0;
  s.options.samples = 14;
  const Film whole = run(cloud(), s).film;
  for (const char* name : {"single", "depth", "nearest", "normal", "albedo"}) {
    for (std::size_t i = 0; i < whole.pixels.size(); ++i) {
      const Vec3d x = value(layer(a, name), a, i), y = value(layer(whole, name), whole, i);
      EXPECT_LT(length(x - y), 1e-9 * (1 + length(y))) << name;
    }
  }
  // Halves go by the number of a sample in the picture, whatever part of it was rendered.
  EXPECT_EQ(layer(a, "half_1").weights[0], 7);
  EXPECT_EQ(layer(whole, "half_1").weights[0], 7);
  EXPECT_EQ(layer(a, "half_1").sums, layer(whole, "half_1").sums);
}

/// Else a picture would have two layers of one name.
TEST(Aov, NoLightGroupHasTheNameOfAnotherLayer) {
  CloudScene s = bright_scene(true, GuideUse::off);
  s.options.samples = 2;
  s.options.aovs = all_but({Aov::lights, Aov::objects});
  const Film film = run(cloud(), s).film;
  for (const Layer& l : film.layers) EXPECT_FALSE(is_group_name(l.name)) << l.name;
  for (const AovRow& r : kAovs) EXPECT_FALSE(is_group_name(r.name)) << r.name;
  for (const char* name : {"noisy", "noisy_variance", "sums", "rgba", "picture", "A"}) {
    EXPECT_FALSE(is_group_name(name)) << name;
  }
  EXPECT_TRUE(is_group_name("key_light"));
  EXPECT_TRUE(is_group_name("sky"));
}

}  // namespace aov_test
}  // namespace pvol
