// Guided paths beyond one plain volume: through many, mapped, moving and procedural ones, and by
// the light of fires. The same pictures on average, with less noise.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/embed.h"
#include "pvol/math/field_map.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "render/guide/importance.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/lit_scenes.h"
#include "support/moving_places.h"
#include "support/velocities.h"
#include "volume/cell_look_up.h"

namespace pvol::test {
namespace guided_volumes_test {

/// What a scene of the puff is lit by, and its volumes.
struct Volumes {
  std::string name;
  CloudScene scene;
  std::vector<Volume> volumes;
};

Volume instances_of(const CloudScene& s, const std::vector<Affine>& places) {
  VolumeOptions o = s.volume_options();
  o.instances = places;
  return pvol::make_volume(puff().grid, build_pyramid(puff().grid), s.medium.medium(), o);
}

/// A ball of 1 that fades over a few cells: what burns.
const Field& ember() {
  static const Field f = make_field("ember", {0, 0, 0}, {12, 12, 12}, [](Vec3i p) {
    const Vec3d d = Vec3d(p) - Vec3d(6);
    return std::clamp(2 - 0.4 * length(d), 0.0, 1.0);
  });
  return f;
}

std::shared_ptr<const Emitter> fire_at(const Affine& place) {
  const Fire fire{.intensity = 8, .color = Rgb(1.0f, 0.5f, 0.2f)};
  return std::make_shared<const Emitter>(
      make_emitter(fire, {ember().grid, build_pyramid(ember().grid)}, nullptr, place));
}

std::vector<Volume> two_puffs(CloudScene& s, const Affine& second) {
  Body other = component(0.3, Rgb(0.6f, 0.9f, 0.95f), -0.3);
  other.object_to_world = second;
  return make_volumes(puff(), std::vector{s.medium, other}, s);
}

std::vector<Volume> moving_puff(CloudScene& s, const std::function<Vec3d(Vec3i)>& velocity) {
  const Pyramid p = build_pyramid(puff().grid);
  Volume still = make_volume(puff().grid, p, s);
  const Shutter shutter{-0.5, 0.5};
  const VelocityGrid v = make_velocity({-80, -40, -8}, {200, 100, 50}, velocity);
  const std::vector<Volume> moved{make_moving(std::move(still), p, puff().grid.index_to_world,
                                              {v, 1, shutter}, s.volume_options())};
  s.camera = frame(world_box(moved), 1);
  s.camera.shutter = shutter;
  return moved;
}

/// Each has something that the others lack.
std::vector<Volumes> all_volumes() {
  std::vector<Volumes> all;
  const auto add = [&](const std::string& name,
                       const std::function<std::vector<Volume>(CloudScene&)>& make) {
    CloudScene s = sunny();
    std::vector<Volume> volumes = make(s);
    if (s.camera == Camera{}) s.camera = frame(world_box(volumes), 1);
    all.push_back({name, s, std::move(volumes)});
  };
  const Affine turn{{Vec3d{0.6, 0, 0.8}, Vec3d{0, 1.2, 0}, Vec3d{-0.8, 0, 0.6}}, {30, 5, -20}};
  add("side by side", [](CloudScene& s) { return two_puffs(s, translation({45, 5, 10})); });
  add("overlapping", [](CloudScene& s) { return two_puffs(s, translation({15, -4, 6})); });
  add("one of them empty", [](CloudScene& s) {
    std::vector<Volume> all_of = two_puffs(s, translation({45, 5, 10}));
    all_of.push_back(
        make_volumes(make_field("none", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; }),
                     std::vector{s.medium}, s)
            .front());
    return all_of;
  });
  add("instances", [&](CloudScene& s) {
    return std::vector{instances_of(s, {Affine{}, translation({-50, 10, 0}) * scaling(Vec3d(0.5)),
                                        turn, translation({0, 40, 5}) * scaling({-1, 1, 1})})};
  });
  add("mapped", [](CloudScene& s) {
    VolumeOptions o = s.volume_options();
    o.map = std::make_shared<const FieldMap>(
        FieldMap{.ramp = {{{0, 0}, {0.3f, 0}, {0.5f, 1}, {1, 0.6f}}, false}});
    return std::vector{
        pvol::make_volume(puff().grid, build_pyramid(puff().grid), s.medium.medium(), o)};
  });
  add("moving", [](CloudScene& s) {
    return moving_puff(
        s, [](Vec3i at) { return Vec3d(at.y - 16, 20 - at.x, 6 * std::sin(0.4 * at.x)); });
  });
  // By more than the cubes over which the importance is constant: most of them are empty at the
  // time of the files.
  add("moving far", [](CloudScene& s) {
    return moving_puff(s, [](Vec3i at) { return Vec3d(130, 20 + 0.3 * at.x, 9); });
  });
  add("moving far as a whole", [](CloudScene& s) {
    s.camera.shutter = {-0.5, 0.5};
    const std::vector<Volume> moved{moving(puff(), s, alone(shifted(Vec3d{}, {140, -20, 10})))};
    s.camera = frame(world_box(moved), 1);
    s.camera.shutter = {-0.5, 0.5};
    return moved;
  });
  add("tricubic", [](CloudScene& s) {
    s.options.look_up = LookUp::tricubic;
    return std::vector{make_volume(puff().grid, build_pyramid(puff().grid, LookUp::tricubic), s)};
  });
  add("a recipe", [](CloudScene& s) {
    s.options.look_up = LookUp::procedural;
    Recipe r;
    r.voxel = 1;
    r.edge = 6;
    r.forms = {FreeForm{8.0 * ellipsoid({0, 0, 0}, Vec3d(16)), {}}};
    const auto recipe = std::make_shared<const Recipe>(r);
    return std::vector{make_volume(recipe, build_pyramid(*recipe), s)};
  });
  add("by firelight and the sun", [](CloudScene& s) {
    Volume v = make_volumes(puff(), std::vector{s.medium}, s).front();
    v.fire = fire_at(translation({44, 10, 12}));
    return std::vector{v};
  });
  add("by firelight alone", [](CloudScene& s) {
    s.lights.clear();
    s.environment = ConstantSky{Rgb(0.0f)};
    std::vector<Volume> both = two_puffs(s, translation({15, -4, 6}));
    both.back().fire = fire_at(translation({10, 8, 12}));
    return both;
  });
  return all;
}

TEST(GuidedVolumes, KeepTheMean) {
  proof::Family family;
  proof::Moments all;
  for (Volumes& c : all_volumes()) {
    c.scene.options.samples = proof::samples(200);
    const RenderResult guided = render(c.volumes, c.scene);
    EXPECT_TRUE(guided.guided) << c.name;
    c.scene.options.guide = GuideUse::off;
    c.scene.options.samples *= 3;
    ++c.scene.options.seed;
    const RenderResult plain = render(c.volumes, c.scene);
    EXPECT_FALSE(plain.guided) << c.name;
    compare(guided.film, plain.film, c.name, family);
    all.add(compare(average(guided.film), average(plain.film), c.name, family));
  }
  add_all_together(all, family);
  EXPECT_TRUE(family.passes());
}

/// Light of radiance 1 from everywhere, half of it from two suns of a hemisphere each; what absorbs
/// glows as brightly.
TEST(GuidedVolumes, WhiteFurnace) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double sine = std::sin(89.95 * kDegree), belt = 0.5 * std::sin(0.05 * kDegree);
  const Rgb irradiance(Vec3d(0.5 * std::numbers::pi * sine * sine));
  proof::Family family;
  for (const float albedo : {1.0f, 0.8f}) {
    CloudScene s = sunny();
    s.options.samples = proof::samples(800);
    s.medium = component(1, Rgb(albedo), 0.5, Rgb(1.0f));
    s.environment = ConstantSky{Rgb(0.5f)};
    s.lights = {Sun{{0.1, 0.3, 1}, irradiance, 179.9}, Sun{{-0.1, -0.3, -1}, irradiance, 179.9}};
    const Volume v = instances_of(s, {Affine{}, translation({25, 5, 3}) * scaling(Vec3d(0.6))});
    s.camera = frame(world_box({&v, 1}), 1);
    const RenderResult r = render({&v, 1}, s);
    EXPECT_TRUE(r.guided);
    compare(average(r.film), {Vec3d(1 - belt / 2), Vec3d(0.0)}, std::to_string(albedo), family,
            belt / 2);
  }
  EXPECT_TRUE(family.passes());
}

double mean_variance(std::span<const Volume> volumes, const CloudScene& s) {
  double sum = 0;
  for (const PixelSums& p : render(volumes, s).film.pixels) sum += variance_of_mean(p).y;
  return sum;
}

TEST(GuidedVolumes, HaveLessNoise) {
  for (Volumes& c : all_volumes()) {
    if (c.name.find("fire") != std::string::npos) continue;  // whose own noise is the most of it
    const double guided = mean_variance(c.volumes, c.scene);
    c.scene.options.guide = GuideUse::off;
    c.scene.options.seed = 2;
    EXPECT_LT(guided, 0.65 * mean_variance(c.volumes, c.scene)) << c.name;
  }
}

TEST(GuidedVolumes, ThreadsChangeNoBit) {
  for (Volumes& c : all_volumes()) {
    c.scene.options.samples = 4;
    const Film one = render(c.volumes, c.scene).film;
    c.scene.options.threads = 3;
    EXPECT_TRUE(same_bytes(one, render(c.volumes, c.scene).film)) << c.name;
  }
}

TEST(GuidedVolumes, CoarseCellsHoldAllMass) {
  const auto sum_of = [](const std::vector<double>& all) {
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  CloudScene s = sunny();
  const Volume one = make_volumes(puff(), std::vector{s.medium}, s).front();
  const double mass = sum_of(detail::make_coarse_cells(one).mass);
  const std::vector<Affine> places = {translation({3, 1, 4}),
                                      translation({150, 10, 0}) * scaling(Vec3d(0.5)),
                                      translation({0, 90, 5}) * scaling({-3, 1, 1})};
  const std::vector<Volume> volumes{instances_of(s, places), two_puffs(s, scaling({1, 2, 1}))[1]};
  const detail::Instances instances(volumes);
  const detail::CoarseCells cells = detail::make_world_cells(volumes, instances);
  // A world of other size has other extinction along its lengths: mass is that of the extinction.
  const double first = mass * (1 + 0.125 + 3), second = mass * 0.3 / 0.4 * 2;
  EXPECT_NEAR(sum_of(cells.mass) / (first + second), 1, 1e-6);
  ASSERT_EQ(cells.mass_of_volumes.size(), 2u);
  EXPECT_NEAR(cells.mass_of_volumes[0] / first, 1, 1e-6);
  EXPECT_NEAR(cells.mass_of_volumes[1] / second, 1, 1e-6);
  EXPECT_EQ(cells.mass.size(), cells.count());
  Rng rng(5, 0, 0);
  int found = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto [x, y, z, spare] = rng.uniform4();
    const Vec3d p(300 * double(x) - 130, 150 * double(y) - 10, 100 * double(z) - 20);
    const bool dense = std::ranges::any_of(instances.all, [&](const detail::Instance& at) {
      const Volume& v = volumes[at.volume];
      return extinction_at(v, inverse(v.density.world_to_cells).point(at.world_to_cells.point(p))) >
             0.05f;
    });
    if (!dense) continue;
    ++found;
    ASSERT_NE(cells.row(p), 0u) << p.x << ' ' << p.y << ' ' << p.z;
    const Box cube = transform(cells.to_world, cells.cube(cells.row(p)));
    ASSERT_TRUE(cube.contains(p));
  }
  EXPECT_GT(found, 300);
}

/// Of mapped, moving, tricubic and procedural density it is estimated by points.
TEST(GuidedVolumes, MassIsThatOfTheDensity) {
  Rng rng(6, 0, 0);
  for (const Volumes& c : all_volumes()) {
    if (c.volumes.size() > 1 || count_places(c.volumes.front()) > 1) continue;
    const Volume& v = c.volumes.front();
    double mass = 0;
    for (const double m : detail::make_coarse_cells(v).mass) mass += m;
    const Box box = v.density.world_box;
    double sum = 0;
    constexpr int kPoints = 200'000;
    for (int i = 0; i < kPoints; ++i) {
      const auto [x, y, z, spare] = rng.uniform4();
      const Vec3d place = box.lo + box.extent() * Vec3d(Vec3f(x, y, z));
      const Motion* const motion = motion_of(v);
      const double time = motion != nullptr ? motion->shutter.at(double(spare)) : 0;
      sum += double(
          detail::extinction_in_cells(v, v.density.world_to_cells.point(place), float(time)));
    }
    const Vec3d e = box.extent();
    EXPECT_NEAR(mass / (sum / kPoints * e.x * e.y * e.z), 1, 0.02) << c.name;
  }
}

/// Of the light of the ember at all places, each of which has the fire and the thin cube.
double expected_collisions(const Volume& v, const std::vector<Affine>& places,
                           const Affine& hearth) {
  struct Point {
    Vec3d place;
    double weight;
  };
  std::vector<Point> shining, dense;
  for (const Affine& at : places) {
    for (int i = 0; i < 15 * 15 * 15; ++i) {
      const Vec3d p(i % 15, i / 15 % 15, i / 225);
      const Vec3d fire = hearth.point(p - Vec3d(1.5));
      const double shine = double(luminance(emission_at(*v.fire, fire)));
      const double edge = 13.0 / 15;
      const Vec3d cube = (p + Vec3d(0.5)) * edge - Vec3d(0.5);
      shining.push_back({at.point(fire), shine * std::abs(determinant(at * hearth))});
      dense.push_back({at.point(cube), 1e-2 * edge * edge * edge * std::abs(determinant(at))});
    }
  }
  std::erase_if(shining, [](const Point& p) { return p.weight == 0; });
  double sum = 0;
  for (const Point& f : shining) {
    for (const Point& p : dense) {
      sum += f.weight * p.weight / dot(f.place - p.place, f.place - p.place);
    }
  }
  return sum;
}

/// A thin cube, at two places, in the sun and beside a fire: photons count the light that arrives.
TEST(GuidedVolumes, PhotonsCountTheLightOfSunAndFire) {
  for (const bool by_fire : {false, true}) {
    CloudScene s = sunny();
    s.options.look_up = LookUp::nearest;
    s.medium = component(1e-2, Rgb(0.5f), 0.5);
    s.environment = ConstantSky{Rgb(0.0f)};
    if (by_fire) s.lights.clear();
    VolumeOptions o = s.volume_options();
    o.instances = {Affine{}, translation({30, 4, 2}) * scaling(Vec3d(0.5))};
    Volume v = pvol::make_volume(cube().grid, build_pyramid(cube().grid, LookUp::nearest),
                                 s.medium.medium(), o);
    const Affine hearth = translation({5, 30, 3}) * scaling(Vec3d(0.7));
    if (by_fire) v.fire = fire_at(hearth);
    s.camera = frame(world_box({&v, 1}), 1);
    const RenderPlan p = plan({&v, 1}, s.scene());
    const detail::PathSetup setup(p);
    const detail::CoarseCells cells = detail::make_world_cells({&v, 1}, *setup.instances);
    const detail::IncidentLight light = detail::trace_photons(setup, cells, 1'000'000);
    double collided = 0;
    for (const auto& row : light.collided) {
      for (const float power : row) collided += double(power);
    }
    const double mass = std::accumulate(cells.mass.begin(), cells.mass.end(), 0.0);
    EXPECT_NEAR(mass / (1e-2 * 13 * 13 * 13 * (1 + 0.125)), 1, 1e-6);
    const double expected = by_fire ? expected_collisions(v, o.instances, hearth) : 3 * mass;
    // Depths up to .2 dim it, and what is scattered counts again: about as much.
    EXPECT_NEAR(collided / expected, 1, 0.06) << by_fire;
  }
}

TEST(GuidedVolumes, AreGuidedWhereTheSunShines) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::automatic;
  s.options.samples = 2000;
  s.medium.extinction = 2;
  std::vector<Volume> both = two_puffs(s, translation({45, 5, 10}));
  s.camera = frame(world_box(both), 1);
  const double paths = 1e6;
  EXPECT_TRUE(choose_guide(both, s.scene(), paths).used);
  EXPECT_TRUE(plan(both, s.scene(), {.paths = paths}).guide.used);
  s.lights.clear();
  EXPECT_FALSE(choose_guide(both, s.scene(), paths).used) << "a smooth sky alone";
  s.lights = sunny().lights;
  const Volume crowd = instances_of(s, std::vector<Affine>(100));
  EXPECT_FALSE(choose_guide({&crowd, 1}, s.scene(), 0.1 * paths).used) << "too few photons";
  EXPECT_TRUE(choose_guide({&crowd, 1}, s.scene(), 0.2 * paths).used);
  const Volume horde = instances_of(s, std::vector<Affine>(2000));
  EXPECT_FALSE(choose_guide({&horde, 1}, s.scene(), paths).used) << "too few photons for each";
  EXPECT_TRUE(choose_guide({&horde, 1}, s.scene(), 2.1 * paths).used);
  s.lights.clear();
  both.back().medium.components.front().emission = Rgb(1.0f);
  EXPECT_TRUE(choose_guide(both, s.scene(), paths).used) << "the second one glows";
}

}  // namespace guided_volumes_test
}  // namespace pvol::test
