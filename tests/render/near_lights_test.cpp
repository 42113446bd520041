// Balls, spots and areas: what is sampled of them is what rays meet, and adds up to closed forms.
#include "pvol/render/near_lights.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/math/direction.h"
#include "pvol/render/lights.h"
#include "support/bodies.h"
#include "support/estimators.h"

namespace pvol::test {
namespace near_lights_test {

constexpr double kPi = std::numbers::pi;

Vec3d random_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return Vec3d(turn(Vec3f(0, 0, 1), 2 * u, v));
}

/// Lights that rays meet, and places that see them from near and far, aside and aslant.
const std::vector<Light>& met_lights() {
  static const std::vector<Light> all{
      PointLight{{1, 2, 3}, Rgb(2.0f, 1.0f, 0.5f), "", 0.7},
      PointLight{{0, 0, 0}, Rgb(5.0f), "", 40},
      AreaLight{{1, 2, 3}, {0.2, -1, 0.3}, {2, 0.5}, {0, 0.3, 1}, Rgb(2.0f, 1.0f, 0.5f), ""},
      AreaLight{{0, 5, 0}, {0, -1, 0}, {100, 80}, {0, 1, 0}, Rgb(1.0f), ""},
  };
  return all;
}
Vec3d position(const Light& light) {
  return std::visit(
      [](const auto& l) {
        if constexpr (requires { l.position; }) return l.position;
        return Vec3d();
      },
      light);
}
std::vector<Vec3d> places_around(const Light& light) {
  std::vector<Vec3d> all;
  Rng rng(11, 0, 0);
  for (const double distance : {45.0, 60.0, 3e3, 2e6}) {
    for (int i = 0; i < 3; ++i) all.push_back(position(light) + random_direction(rng) * distance);
  }
  // Close before areas, which balls hold.
  all.push_back(position(light) + Vec3d(0.1, -0.8, 0.1));
  all.push_back(position(light) + Vec3d(0.3, -0.02, 0.2));
  return all;
}

LightSample sample_at(const LightSource& light, Vec3d place, Rng& rng) {
  return std::visit([&](const auto& l) { return l.sample([&] { return place; }, rng); }, light);
}
LightMet met(const LightSource& light, const Ray& ray, double distance) {
  return std::visit([&](const auto& l) { return l.met(ray, distance); }, light);
}
Rgb on_plane(const LightSource& light, Vec3d place, Vec3d normal) {
  return std::visit([&](const auto& l) { return l.on_plane(place, normal); }, light);
}

TEST(NearLights, SamplesAreMetByRays) {
  for (const Light& kind : met_lights()) {
    const LightSource light = make_light_sources({&kind, 1}).front();
    int met_count = 0, far_count = 0, count = 0;
    for (const Vec3d place : places_around(kind)) {
      Rng rng(12, 0, 0);
      for (int i = 0; i < 1000; ++i) {
        const LightSample s = sample_at(light, place, rng);
        if (s.radiance == Rgb(0.0f)) continue;
        ++count;
        ASSERT_GT(s.pdf, 0);
        EXPECT_NEAR(length(Vec3d(s.direction)), 1, 1e-6);
        // From so far that float directions hardly tell its parts apart, rays miss its rim.
        const bool far = length(position(kind) - place) > 1e5;
        const LightMet m = met(light, {place, Vec3d(s.direction)}, s.distance * 1.001 + 1e-3);
        far_count += far;
        if (m.radiance == Rgb(0.0f)) continue;
        ++met_count;
        EXPECT_EQ(m.radiance, s.radiance);
        EXPECT_NEAR(m.pdf, s.pdf, (far ? 0.2f : 1e-3f) * s.pdf);
        const LightMet before = met(light, {place, Vec3d(s.direction)}, s.distance * 0.99);
        EXPECT_TRUE(far || before.radiance == Rgb(0.0f));
      }
    }
    EXPECT_GT(count, 2000);
    EXPECT_GT(met_count, 0.99 * (count - far_count));
  }
}

/// The integral of light times a function of direction by samples and by rays in all directions.
TEST(NearLights, SamplesAddUpToWhatRaysMeet) {
  proof::Family family;
  const auto weight = [](Vec3f d) { return double((1.5f + d.x) * (1.2f + d.y * d.z)); };
  for (std::size_t k = 0; k < met_lights().size(); ++k) {
    const Light& kind = met_lights()[k];
    const LightSource light = make_light_sources({&kind, 1}).front();
    for (const Vec3d offset : {Vec3d(0.3, -1.4, 0.8), Vec3d(-0.5, -0.9, -0.4), Vec3d(20, -45, 9),
                               Vec3d(30, -2.5, -31), Vec3d(0.4, 2, 0.3)}) {
      const Vec3d place = position(kind) + offset;
      proof::Moments by_samples, by_rays;
      Rng rng(proof::seeded(13), k, 0);
      for (int i = 0; i < 200'000; ++i) {
        const LightSample s = sample_at(light, place, rng);
        by_samples.add(s.pdf > 0 ? double(s.radiance.x / s.pdf) * weight(s.direction) : 0);
        const Vec3d d = random_direction(rng);
        by_rays.add(double(met(light, {place, d}, 1e9).radiance.x) * weight(Vec3f(d)) * 4 * kPi);
      }
      if (by_rays.mean() == 0 && by_samples.mean() == 0) continue;
      if (by_rays.variance() == 0 || by_rays.mean() < 10 * std::sqrt(by_rays.variance_of_mean())) {
        continue;  // so small that hardly a ray met it
      }
      family.add("light " + std::to_string(k), proof::equal_means_p_value(by_samples, by_rays));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Irradiances of planes: closed forms against samples, for normals that see a part of the light.
TEST(NearLights, OnPlanesAreTheirSamples) {
  proof::Family family;
  std::vector<Light> all = met_lights();
  all.emplace_back(SpotLight{{1, 2, 3}, {0, -1, 0.2}, Rgb(3.0f), 120, 0.5, ""});
  all.emplace_back(Sun{{1, 2, 3}, Rgb(3.0f), 50});
  all.emplace_back(PointLight{{1, 2, 3}, Rgb(3.0f)});
  all.emplace_back(Sun{{1, 2, 3}, Rgb(3.0f), 0});
  for (std::size_t k = 0; k < all.size(); ++k) {
    const LightSource light = make_light_sources({&all[k], 1}).front();
    Rng rng(proof::seeded(14), k, 0);
    for (int n = 0; n < 12; ++n) {
      const double distance = k == 1 ? 45 : n % 2 ? 1.2 : 4;
      Vec3d away = random_direction(rng);
      away.y = -std::abs(away.y);
      const Vec3d place = position(all[k]) + away * distance;
      const Vec3d normal = normalize(random_direction(rng) - (n % 3 ? away : Vec3d()));
      proof::Moments by_samples;
      for (int i = 0; i < 40'000; ++i) {
        const LightSample s = sample_at(light, place, rng);
        const double cosine = std::max(0.0, dot(Vec3d(s.direction), normal));
        by_samples.add(double(s.radiance.x) * cosine / (s.pdf > 0 ? double(s.pdf) : 1.0));
      }
      const auto expected = double(on_plane(light, place, normal).x);
      const std::string name = "light " + std::to_string(k) + ", plane " + std::to_string(n);
      if (by_samples.variance() < 1e-10 * expected * expected || expected == 0) {
        EXPECT_NEAR(by_samples.mean(), expected, 1e-5 * expected) << name;
      } else {
        family.add(name, proof::mean_p_value(by_samples, expected, 2e-5 * expected));
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(NearLights, BallsAndAreasFarAwayArePoints) {
  const PointSource point{{0, 0, 0}, Rgb(2.0f)};
  const BallSource ball(PointLight{{0, 0, 0}, Rgb(2.0f), "", 0.01});
  const AreaSource area(AreaLight{{0, 0, 0}, {0, -1, 0}, {0.01, 0.02}, {0, 0, 1}, Rgb(1e4f), ""});
  const Vec3d place(3, -10, 1), normal = normalize(Vec3d(0.1, 1, 0.2));
  const float expected = point.on_plane(place, normal).x;
  EXPECT_NEAR(ball.on_plane(place, normal).x, expected, 1e-5f * expected);
  const auto slant = float(10 / std::sqrt(110.0));
  EXPECT_NEAR(area.on_plane(place, normal).x, expected * slant, 1e-4f * expected);
  EXPECT_NEAR(area.irradiance_on({place, place}).x, 2 * slant / 110, 1e-5f);
  // So small an area is sampled by its points: each brings what all of it does.
  const LightSource source(area);
  Rng rng(17, 0, 0);
  for (int i = 0; i < 100; ++i) {
    const LightSample s = sample_at(source, place, rng);
    EXPECT_NEAR(s.radiance.x / s.pdf, 2 * slant / 110, 0.01f * 2 / 110);
    const LightMet m = met(source, {place, Vec3d(s.direction)}, 1e9);
    if (m.radiance == Rgb(0.0f)) continue;
    EXPECT_NEAR(m.pdf, s.pdf, 0.01f * s.pdf);
  }
}

/// Before its face a rectangle fills half of the view, however near to its plane the place is: what
/// lamps are drawn by must not be less by an unbounded factor.
TEST(AreaLights, NearTheirPlaneAreNotTakenForFaint) {
  const AreaSource area(AreaLight{
      .position = {0, 0, 0}, .direction = {0, 1, 0}, .size = {2, 3}, .radiance = Rgb(1.0f)});
  for (const double height : {1.0, 0.1, 1e-3, 1e-6, 1e-9}) {
    for (const Vec3d inside : {Vec3d(0.7, height, 1.2), Vec3d(0, height, 0)}) {
      EXPECT_GT(area.irradiance_on({inside, inside}).x, 0.2) << height;
    }
    EXPECT_EQ(area.irradiance_on({Vec3d(0.7, -height, 1.2), Vec3d(0.7, -height, 1.2)}).x, 0);
  }
}

/// What is computed of its angles holds where it is all that is seen, a sliver, or nearly nothing.
TEST(NearLights, AreasAreSampledFromNearAndAside) {
  const AreaSource area(AreaLight{{0, 0, 0}, {0, -1, 0}, {2, 1}, {0, 0, 1}, Rgb(3.0f), ""});
  const Vec3d up(0, 1, 0);
  proof::Family family;
  for (const double depth : {1e-12, 1e-8, 1e-4, 0.05, 0.3, 1.0, 30.0, 1e3}) {
    for (const Vec3d aside : {Vec3d(0.1, 0, 0.05), Vec3d(0.96, 0, -0.4), Vec3d(1.5, 0, 0.2)}) {
      if (aside.x > 1 && depth < 1e-3) continue;  // hardly anything is seen: nearly all is noise
      const Vec3d place = aside - up * depth;
      const double expected = double(area.on_plane(place, up).x);
      Rng rng(proof::seeded(27), std::uint64_t(1e6 * aside.x), 0);
      proof::Moments m;
      for (int i = 0; i < 20'000; ++i) {
        const LightSample s = sample_at(LightSource(area), place, rng);
        ASSERT_GT(s.pdf, 0) << depth;
        m.add(double(s.radiance.x) * dot(Vec3d(s.direction), up) / double(s.pdf));
        if (aside.x < 0.5 && depth < 1e-3) {
          ASSERT_NEAR(double(s.pdf) * 2 * kPi, 1, 10 * depth + 1e-6);
        }
      }
      if (m.variance() < 1e-10 * expected * expected) {
        EXPECT_NEAR(m.mean(), expected, 1e-4 * expected) << depth;
      } else {
        family.add(std::to_string(depth), proof::mean_p_value(m, expected, 2e-5 * expected));
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(NearLights, ASpotShinesWithinItsCone) {
  const SpotSource spot(SpotLight{{0, 0, 0}, {0, -2, 0}, Rgb(1.0f), 60, 0.5, ""});
  const auto at = [](double degrees) {
    const double a = degrees * kPi / 180;
    return Vec3d(std::sin(a), -std::cos(a), 0);
  };
  EXPECT_EQ(spot.share(at(0)), 1);
  EXPECT_EQ(spot.share(at(14.9)), 1);
  EXPECT_EQ(spot.share(at(30.1)), 0);
  EXPECT_EQ(spot.share(at(180)), 0);
  const auto cosine = [](double degrees) { return std::cos(degrees * kPi / 180); };
  const double x = (cosine(22) - cosine(30)) / (cosine(15) - cosine(30));
  EXPECT_NEAR(spot.share(at(22)), x * x * (3 - 2 * x), 1e-12);
  const SpotSource hard(SpotLight{{0, 0, 0}, {0, -1, 0}, Rgb(1.0f), 60, 0, ""});
  EXPECT_EQ(hard.share(at(29.99)), 1);
  EXPECT_EQ(hard.share(at(30.01)), 0);
  // A box beside the cone is dark, one that the cone pierces between its corners is not.
  EXPECT_EQ(spot.irradiance_on({{5, -1, 5}, {6, 1, 6}}).x, 0);
  EXPECT_GT(spot.irradiance_on({{-90, -11, -90}, {70, -10, 70}}).x, 0);
}

TEST(NearLights, AreFiniteEverywhere) {
  std::vector<Light> all = met_lights();
  all.emplace_back(SpotLight{{1, 2, 3}, {0, -1, 0}, Rgb(1e30f), 1, 1, ""});
  all.emplace_back(PointLight{{1, 2, 3}, Rgb(1e-30f), "", 1e-30});
  all.emplace_back(AreaLight{{1, 2, 3}, {0, -1, 0}, {1e-20, 1e20}, {0, 1, 0}, Rgb(1.0f), ""});
  Rng rng(15, 0, 0);
  for (const Light& kind : all) {
    const LightSource light = make_light_sources({&kind, 1}).front();
    for (const double distance : {0.0, 1e-300, 1e-20, 1e-8, 0.6999999, 0.7, 1.0, 1e20, 1e100}) {
      for (const Vec3d way :
           {Vec3d(0, -1, 0), Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0.6, -0.8, 0)}) {
        const Vec3d place = position(kind) + way * distance;
        for (int i = 0; i < 100; ++i) {
          const LightSample s = sample_at(light, place, rng);
          EXPECT_TRUE(is_finite(s.radiance) && is_finite(s.direction) && std::isfinite(s.pdf));
          EXPECT_NEAR(length(Vec3d(s.direction)), 1, 1e-5) << distance;
          const LightMet m = met(light, {place, random_direction(rng)}, 1e30);
          EXPECT_TRUE(is_finite(m.radiance) && std::isfinite(m.pdf));
        }
        EXPECT_FALSE(std::isnan(on_plane(light, place, {0, 1, 0}).x));
      }
    }
  }
}

/// A cube in the light of each kind, from without and within.
struct Lit {
  const char* name;
  Light light;
};
const Lit kLit[] = {
    {"ball", PointLight{{20, 15, 9}, Rgb(50.0f, 100.0f, 25.0f), "", 3}},
    {"ball within", PointLight{{9.5, 3, 5}, Rgb(20.0f), "", 0.8}},
    {"spot", SpotLight{{20, 15, 9}, {-14, -9, -5}, Rgb(90.0f), 30, 0.6, ""}},
    {"area", AreaLight{{6, 16, 6}, {0.1, -1, 0.2}, {6, 3}, {0, 0, 1}, Rgb(4.0f), ""}},
    {"area within", AreaLight{{9, 6, 5}, {-1, 0.1, 0}, {3, 2}, {0, 1, 0}, Rgb(4.0f), ""}},
};

TEST(NearLights, SingleScatteringIsItsIntegral) {
  const Affine aside{{Vec3d{0.8, 0.1, 0}, Vec3d{0, 0.7, 0.1}, Vec3d{0.1, 0, 0.9}}, {5, 3, -2}};
  const std::vector<Body> one{component(0.15, Rgb(1.0f, 0.5f, 0.25f), 0.4)};
  const std::vector<Body> two{one.front(), component(0.2, Rgb(0.9f), -0.3, Rgb(0.0f), aside)};
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 0;
  for (const Lit& lit : kLit) {
    for (const std::vector<Body>& bodies : {one, two}) {
      OneRay r(bodies, {6, 25, 30}, {6.5, 6, 5});
      r.scene.lights.push_back(lit.light);
      r.scene.options.seed = ++seed;
      all.add(compare(r, std::string(lit.name) + ", " + std::to_string(bodies.size()), family));
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// More lights than are asked one by one: each is drawn by what it promises, and all that they
/// bring arrives, also of a far bright one among many near faint ones and of one that shines
/// elsewhere.
TEST(NearLights, OfManySomeAreAsked) {
  OneRay r({component(0.15, Rgb(1.0f, 0.5f, 0.25f), 0.4)}, {6, 25, 30}, {6.5, 6, 5});
  for (const Lit& lit : kLit) r.scene.lights.push_back(lit.light);
  Rng rng(proof::seeded(16), 0, 0);
  for (int i = 0; i < 70; ++i) {
    const Vec3d place = Vec3d(6) + random_direction(rng) * (4 + 10 * double(rng.uniform()));
    r.scene.lights.emplace_back(PointLight{place, Rgb(rng.uniform(), 1.0f, 0.5f)});
  }
  r.scene.lights.emplace_back(Sun{{1, 2, 3}, Rgb(0.5f), 0});
  r.scene.lights.emplace_back(SpotLight{{20, 15, 9}, {1, 1, 0}, Rgb(1e3f), 40, 0.5, ""});
  r.scene.options.samples = proof::samples(100'000);
  proof::Family family;
  compare(r, "many", family);
  r.scene.options.aovs.add(Aov::lights);
  const Film layers = render(make_volumes(cube(), r.bodies, r.scene), r.scene).film;
  Vec3d sum;
  for (std::size_t i = 0; i + 2 < layers.layers.size(); ++i) sum += layers.layers[i].sums[0];
  EXPECT_NEAR(sum.x, layers.pixels[0].sum.x, 1e-3 * sum.x);
  EXPECT_TRUE(family.passes());
}

/// The camera sees a lamp through a cloud, which dims it and adds nothing where it is black.
TEST(NearLights, LampsAreSeen) {
  for (const bool behind : {true, false}) {
    OneRay r({component(0.1, Rgb(0.0f), 0)}, {6, 6, 40}, {6, 6, 0});
    r.scene.lights = {PointLight{{6, 6, behind ? -10.0 : 20.0}, Rgb(float(4 * kPi)), "", 2}};
    const Average a = average(render(make_volumes(cube(), r.bodies, r.scene), r.scene).film);
    const double expected = behind ? std::exp(-1.3) : 1;
    EXPECT_NEAR(a.mean.x, expected, 5 * std::sqrt(a.variance.x) + 1e-6);
  }
}

/// Guided paths and those among surfaces gather the same light.
TEST(NearLights, AllTracersAgree) {
  proof::Family family;
  CloudScene s;
  s.medium = component(0.5, Rgb(0.95f), 0.6);
  s.camera.position = {40, 20, 30};
  s.camera.target = {6, 6, 6};
  s.environment = ConstantSky{Rgb(0.1f)};
  s.options.look_up = LookUp::nearest;
  s.options.width = s.options.height = 12;
  s.options.samples = proof::samples(256);
  s.options.threads = 2;
  for (const Lit& lit : kLit) s.lights.push_back(lit.light);
  const Volume volume = make_volume(cube().grid, build_pyramid(cube().grid), s);
  const auto picture = [&](GuideUse guide, bool surface, std::uint64_t seed) {
    CloudScene t = s;
    t.options.guide = guide;
    t.options.seed = seed;
    // Far off: nothing meets it, but another tracer renders.
    if (surface) t.surfaces = {BallSurface{{0, 0, 1e7}, 1, {}}};
    return average(render(volume, t).film);
  };
  for (const bool many : {false, true}) {  // of many some are drawn, by importance, too
    for (int i = 0; many && i < 64; ++i) {
      s.lights.emplace_back(PointLight{{i * 0.5 - 8, 16 - i * 0.4, 18}, Rgb(7.5f)});
    }
    const std::string of = many ? ", many" : "";
    const Average plain = picture(GuideUse::off, false, 1);
    compare(picture(GuideUse::on, false, 2), plain, "guided" + of, family);
    compare(picture(GuideUse::off, true, 3), plain, "among surfaces" + of, family);
    compare(picture(GuideUse::on, true, 4), plain, "guided among surfaces" + of, family);
  }
  EXPECT_TRUE(family.passes());
}

RenderResult render_field(const Field& field, const CloudScene& scene) {
  return render(make_volume(field.grid, build_pyramid(field.grid), scene), scene);
}

TEST(NearLights, ShineOnPathsOfWeightedTrackersAlike) {
  CloudScene s;
  s.medium = component(0.5, Rgb(0.95f), 0.6);
  s.options.look_up = LookUp::nearest;
  s.options.guide = GuideUse::off;
  s.options.width = s.options.height = 64;
  s.options.samples = proof::samples(400);
  s.lights = {PointLight{{0, 20, 0}, Rgb(1.0f), "", 2}};
  const Film analog = render_field(cube(), s).film;
  s.options.tracker = Tracker::weighted_delta, s.options.seed = 2;
  proof::Family family;
  compare(render_field(cube(), s).film, analog, "weighted delta", family);
  EXPECT_TRUE(family.passes());
}

}  // namespace near_lights_test
}  // namespace pvol::test
