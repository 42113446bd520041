// Point lights: what arrives is the inverse square of the distance through what lies between.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "pvol/render/lights.h"
#include "support/bodies.h"
#include "support/estimators.h"

namespace pvol::test {
namespace point_light_test {

LightSample sample_at(const PointSource& light, Vec3d place) {
  Rng rng(41, 0, 0);
  return light.sample([&] { return place; }, rng);
}

TEST(PointLight, FallsWithTheSquareOfTheDistance) {
  const PointSource light{{3, -4, 12}, Rgb(2.0f, 0.5f, 0.0f)};
  const LightSample l = sample_at(light, {0, 0, 0});
  EXPECT_EQ(l.distance, 13);
  EXPECT_EQ(l.pdf, 0);
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(l.radiance[c], light.intensity[c] / 169);
    EXPECT_FLOAT_EQ(l.direction[c], float(light.position[c] / 13));
  }
  EXPECT_EQ(light.met({{0, 0, 0}, Vec3d(l.direction)}, 99).radiance, Rgb(0.0f))
      << "no ray meets a point";
}

TEST(PointLight, IsFiniteEverywhere) {
  const PointSource light{{1, 1, 1}, Rgb(1e30f)};
  for (const double distance : {0.0, 1e-300, 1e-20, 1e-8, 1.0, 1e20, 1e100}) {
    const LightSample l = sample_at(light, {1, 1 + distance, 1});
    EXPECT_TRUE(is_finite(l.radiance) && is_finite(l.direction)) << distance;
    EXPECT_NEAR(length(Vec3d(l.direction)), 1, 1e-6) << distance;
    EXPECT_EQ(l.pdf, 0);
    EXPECT_TRUE(is_finite(light.irradiance_on({Vec3d(distance), Vec3d(distance + 1)})));
  }
}

TEST(PointLight, OnABoxIsThatOfItsMiddleOrItsRim) {
  const PointSource light{{0, 0, 0}, Rgb(6.0f)};
  EXPECT_FLOAT_EQ(light.irradiance_on({{9, -1, -1}, {11, 1, 1}}).x, 0.06f);
  EXPECT_FLOAT_EQ(light.irradiance_on({Vec3d(-1), Vec3d(1)}).x, 2) << "the light is in the box";
}

/// A cube or two that overlap, of different media, in the light of points.
struct Lit {
  const char* name;
  std::vector<PointLight> lights;
};
const Lit kLit[] = {
    {"outside", {{{20, 15, 9}, Rgb(50.0f, 100.0f, 25.0f)}}},
    {"within, where a ray beyond the light would be dimmed", {{{10, 4, 5}, Rgb(20.0f)}}},
    {"one within, one behind", {{{3, 9, 8}, Rgb(9.0f, 3.0f, 6.0f)}, {{6, 7, -20}, Rgb(80.0f)}}},
    {"close to a face", {{{6, 13, 6}, Rgb(10.0f)}}},
};

TEST(PointLight, SingleScatteringIsItsIntegral) {
  const Affine aside{{Vec3d{0.8, 0.1, 0}, Vec3d{0, 0.7, 0.1}, Vec3d{0.1, 0, 0.9}}, {5, 3, -2}};
  const std::vector<Body> one{component(0.15, Rgb(1.0f, 0.5f, 0.25f), 0.4)};
  const std::vector<Body> two{one.front(), component(0.2, Rgb(0.9f), -0.3, Rgb(0.0f), aside)};
  proof::Family family;
  proof::Moments all;
  std::uint64_t seed = 0;
  for (const Tracker tracker : kTrackers) {
    for (const Transmittance transmittance : kTransmittances) {
      for (const Lit& lit : kLit) {
        for (const std::vector<Body>& bodies : {one, two}) {
          for (const LineLamps lines : {LineLamps::off, LineLamps::on}) {
            if (bodies.size() > 1 && is_weighted(tracker)) continue;
            ++seed;
            const auto turn = std::size_t(tracker) + std::size_t(transmittance) +
                              std::size_t(&lit - kLit) + bodies.size();
            if (!proof::has_turn(turn + (lines == LineLamps::on))) continue;
            OneRay r(bodies, {6, 25, 30}, {6.5, 6, 5});
            r.scene.lights.assign(lit.lights.begin(), lit.lights.end());
            r.scene.options.tracker = tracker;
            r.scene.options.transmittance = transmittance;
            r.scene.options.line_lamps = lines;
            r.scene.options.seed = seed;
            r.scene.options.samples =
                proof::samples(is_slow(tracker, transmittance) ? 8'000 : 20'000);
            all.add(compare(r,
                            std::string(lit.name) + ", " + label(tracker) + ", " +
                                label(transmittance) + ", " + std::to_string(bodies.size()) +
                                ", along flights: " + name(lines),
                            family));
          }
        }
      }
    }
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// A lamp beside a small volume is far brighter there than in a large one, whose shadow rays must
/// not be saved on for that.
TEST(PointLight, NoVolumeIsSpecial) {
  const Affine small = scaling(Vec3d(1e-3));
  OneRay r({component(0.3, Rgb(0.9f), 0.2), component(300, Rgb(0.9f), 0.2, Rgb(0.0f), small)},
           {6, 25, 30}, {6.5, 6, 5});
  r.scene.lights = {PointLight{{-0.02, 0.005, 0.005}, Rgb(20.0f)}};
  r.scene.options.samples = proof::samples(4000);
  proof::Family family;
  compare(r, "small volume second", family);
  std::swap(r.bodies[0], r.bodies[1]);
  compare(r, "small volume first", family);
  EXPECT_TRUE(family.passes());
}

/// Between two clouds apart, one of which holds the lamp: its light comes through half of that one.
TEST(PointLight, WithinAnotherCloudIsDimmedUpToIt) {
  OneRay r({component(0.15, Rgb(0.9f), 0.2),
            component(0.3, Rgb(0.9f), 0.2, Rgb(0.0f), translation({20, 0, 0}))},
           {6, 25, 30}, {6.5, 6, 5});
  r.scene.lights = {PointLight{{26, 6, 6}, Rgb(500.0f)}};
  proof::Family family;
  compare(r, "lamp within the other", family);
  EXPECT_TRUE(family.passes());
}

TEST(PointLight, OrderOfKindsDoesNotMatter) {
  OneRay r({component(0.3, Rgb(0.9f), 0.2)}, {30, 25, 30}, {6, 6, 6});
  const Sun sun{{0.3, 1, 0.2}, Rgb(2.0f), 10};
  const PointLight red{{20, 9, 1}, Rgb(90.0f, 0.0f, 0.0f)},
      blue{{9, 1, 20}, Rgb(0.0f, 0.0f, 90.0f)};
  r.scene.options.samples = 10;
  r.scene.options.aovs = {Aov::lights};
  r.scene.lights = {sun, red, blue};
  const Film a = render(make_volumes(cube(), r.bodies, r.scene), r.scene).film;
  r.scene.lights = {red, sun, blue};
  const Film b = render(make_volumes(cube(), r.bodies, r.scene), r.scene).film;
  EXPECT_TRUE(same_bytes(a, b));
  ASSERT_EQ(b.layers.size(), 5u);
  for (const std::size_t i : {0u, 1u, 2u}) {
    EXPECT_EQ(b.layers[i].name, (std::array{"sun_1", "point_1", "point_2"})[i]);
    EXPECT_EQ(a.layers[i].sums, b.layers[i].sums);
  }
}

/// Light that was scattered often, too: from far away a point is a sun.
TEST(PointLight, FarAwayIsASun) {
  const Vec3d far = Vec3d(0.5, 0.7, -0.3) * 1e9;
  OneRay r({component(0.3, Rgb(0.99f), 0.6)}, {30, 25, 30}, {6, 6, 6});
  r.scene.options.max_bounces.reset();
  r.scene.options.guide = GuideUse::off;
  const auto picture = [&](const Light& light) {
    r.scene.lights = {light};
    return average(render(make_volumes(cube(), r.bodies, r.scene), r.scene).film);
  };
  const Average sun = picture(Sun{far, Rgb(2.0f), 0});
  const Average point = picture(PointLight{far, Rgb(float(2 * dot(far, far)))});
  proof::Family family;
  compare(point, sun, "far away", family);
  EXPECT_TRUE(family.passes());
  const Volume v = make_volumes(cube(), r.bodies, r.scene).front();
  if (kernel_for({&v, 1}, r.scene.scene()) == KernelKind::scalar) return;
  EXPECT_NEAR(point.mean.x / sun.mean.x, 1, 1e-3) << "by the same random numbers";
}

}  // namespace point_light_test
}  // namespace pvol::test
