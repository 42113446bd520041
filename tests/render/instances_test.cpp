// One volume at many places: as many volumes are, in closed form, and in memory once.
#include "render/path/instances.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "pvol/error.h"
#include "pvol/render/placement.h"
#include "pvol/render/shell_choice.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "support/bodies.h"
#include "support/error_of.h"
#include "support/lit_scenes.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/rays_through.h"

namespace pvol::test {
namespace instances_test {

using detail::kEndless;

/// The volume of a scene's medium at places.
Volume instances_of(const Field& field, CloudScene s, const std::vector<Affine>& places) {
  VolumeOptions o = s.volume_options();
  o.instances = places;
  return pvol::make_volume(field.grid, build_pyramid(field.grid), s.medium.medium(), o);
}

/// The same as volumes of their own.
std::vector<Volume> copies_of(const Field& field, const CloudScene& s,
                              const std::vector<Affine>& places) {
  std::vector<Body> bodies;
  for (const Affine& place : places) {
    bodies.push_back(s.medium);
    bodies.back().object_to_world = place * s.medium.object_to_world;
  }
  return make_volumes(field, bodies, s);
}

/// Maps that double represents exactly, with their inverses and products: scaled by powers of two,
/// turned by right angles, mirrored, moved; some overlap.
std::vector<Affine> exact_places() {
  const Affine turn{{Vec3d{0, 0, 1}, Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}}, {}};
  const Affine mirror = scaling({-1, 1, 1});
  return {translation({64, 0, 0}) * turn,
          translation({16, 8, -32}),
          translation({-64, 0, 16}) * scaling(Vec3d(0.5)) * mirror,
          translation({32, -64, 0}) * scaling(Vec3d(2.0)) * turn,
          translation({-48, 48, -64}) * turn * mirror,
          translation({24, 8, -40}) * scaling(Vec3d(0.5)),
          translation({0, 64, 64})};
}

/// Of every kind of light, with every layer, for many places.
CloudScene busy_scene() {
  CloudScene s = sunny();
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}, PointLight{{10, 200, 40}, Rgb(9000.0f)}};
  s.environment = GradientSky{};
  s.options.guide = GuideUse::automatic;
  s.options.depth = 0;                              // not by the size of a place
  s.options.transmittance = Transmittance::analog;  // nor by how many they are
  s.options.width = 24, s.options.height = 20;
  s.options.samples = 16;
  for (const AovRow& r : kAovs) s.options.aovs.add(r.aov);
  return s;
}

TEST(Instances, AreToTheByteWhatVolumesOfTheirOwnAre) {
  CloudScene s = busy_scene();
  for (const std::size_t count : {std::size_t(1), std::size_t(3), exact_places().size()}) {
    std::vector<Affine> places = exact_places();
    places.resize(count);
    const Volume v = instances_of(puff(), s, places);
    const std::vector<Volume> copies = copies_of(puff(), s, places);
    EXPECT_EQ(count_places(v), count);
    const Box box = world_box(std::span(&v, 1));
    EXPECT_EQ(box, world_box(copies));
    s.camera = frame(box, 1.2);
    const Film a = render({&v, 1}, s).film;
    const Film b = render(copies, s).film;
    EXPECT_TRUE(same_bytes(a, b)) << count;
    ASSERT_EQ(a.layers.size(), b.layers.size());
    for (std::size_t i = 0; i < a.layers.size(); ++i) {
      EXPECT_TRUE(a.layers[i].sums == b.layers[i].sums) << a.layers[i].name << ' ' << count;
    }
  }
}

/// Places as users say them: turned, stretched, mirrored, overlapping.
std::vector<Affine> random_places(int count, double reach, std::uint64_t seed) {
  Rng rng(seed, 0, 0);
  const auto uniform = [&](double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); };
  std::vector<Affine> places;
  for (int i = 0; i < count; ++i) {
    Placement p;
    p.scale = Vec3d(uniform(0.4, 1.5), uniform(0.4, 1.5), uniform(0.4, 1.5));
    if (i % 3 == 1) p.scale->x = -p.scale->x;
    p.rotate = {{{uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)}, uniform(0, 360)},
                {{0, 1, 0}, uniform(0, 360)}};
    p.translate = Vec3d(uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach));
    places.push_back(p.map());
  }
  return places;
}

TEST(Instances, HaveTheExpectationOfVolumesOfTheirOwn) {
  proof::Family family;
  for (const int count : {2, 12}) {
    CloudScene s = sunny();
    s.options.guide = GuideUse::automatic;
    s.options.samples = proof::samples(200);
    const auto places = random_places(count, 40, std::uint64_t(count));
    const Volume v = instances_of(puff(), s, places);
    s.camera = frame(world_box(std::span(&v, 1)), 1);
    CloudScene other = s;
    other.options.seed = 77;
    compare(render({&v, 1}, s).film, render(copies_of(puff(), s, places), other).film,
            std::to_string(count), family);
  }
  EXPECT_TRUE(family.passes());
}

/// Cubes about the origin, all of which overlap there.
std::vector<Body> crossed_cubes(int count, double extinction, std::uint64_t seed) {
  std::vector<Body> bodies;
  for (const Affine& place : random_places(count, 3, seed)) {
    bodies.push_back(component(extinction, Rgb(0.8f), 0.3, {}, place * translation(Vec3d(-6.0))));
  }
  return bodies;
}

std::vector<Affine> places_of(const std::vector<Body>& bodies) {
  std::vector<Affine> places;
  for (const Body& b : bodies) places.push_back(b.object_to_world);
  return places;
}

/// Single scattering in cubes that overlap, of which some are mirrored, with shadow rays through
/// all of them.
TEST(Instances, ThatOverlapHaveTheirClosedForm) {
  proof::Family family;
  for (const int count : {2, 3, 9}) {
    const std::vector<Body> bodies = crossed_cubes(count, 0.15, 40 + std::uint64_t(count));
    OneRay r(bodies, {40, 30, 55}, {1, 0.5, -1});
    const auto places = places_of(bodies);
    r.scene.environment = ConstantSky{Rgb(0.25f)};
    r.scene.lights = {Sun{{0.3, 1, 0.1}, Rgb(3.0f), 0}, PointLight{{-4, 30, 9}, Rgb(700.0f)}};
    r.scene.options.max_bounces = 1;
    r.scene.options.samples = proof::samples(200'000);
    r.scene.medium = bodies.front();
    r.scene.medium.object_to_world = {};
    for (const Transmittance t : {Transmittance::analog, Transmittance::residual_ratio}) {
      r.scene.options.transmittance = t;
      const Volume v = instances_of(cube(), r.scene, places);
      const Film film = render({&v, 1}, r.scene).film;
      Average a = average(film);
      // The sky that scatters towards the camera is left out of the closed form.
      CloudScene unlit = r.scene;
      unlit.lights.clear();
      unlit.options.seed = 9;
      const Average sky = average(render({&v, 1}, unlit).film);
      const double behind = 0.25 * std::exp(-optical_depth(r.bodies, r.ray));
      a = a + Average{Vec3d(behind) - sky.mean, sky.variance};
      compare(a, {radiance(r), Vec3d(0.0)}, std::to_string(count) + name(t), family, 3e-5);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// Along a ray through cubes that overlap: where flights end, in which cube, and how much passes.
TEST(Instances, FlightsAndTransmittancesAreThoseOfTheSum) {
  proof::Family family;
  for (const int count : {2, 9}) {
    const std::vector<Body> bodies = crossed_cubes(count, 0.2 / count, 60 + std::uint64_t(count));
    OneRay r(bodies, {40, 30, 55}, {1, 0.5, -1});
    const auto places = places_of(bodies);
    r.scene.medium.object_to_world = {};
    const Volume v = instances_of(cube(), r.scene, places);
    const RenderPlan p = plan({&v, 1}, r.scene.scene());
    const detail::PathSetup setup(p);
    detail::ShellCounts shells;
    const double all = optical_depth(bodies, r.ray);
    EXPECT_GT(all, 1);
    const int kFlights = proof::samples<int>(1'000'000), kBins = 16;
    // Of optical depth: bins of equal probability, and one for what leaves.
    std::vector<std::uint64_t> counts(kBins + 1);
    for (int i = 0; i < kFlights; ++i) {
      Rng rng(proof::seeded(3), std::uint64_t(count), std::uint64_t(i));
      if (i < 1000) {
        const double distance = 40 + 0.03 * i, depth = optical_depth(bodies, r.ray, distance);
        ASSERT_NEAR(pass(setup, r.ray, 0, distance, shells).transmittance, std::exp(-depth), 1e-5);
      }
      const auto place = detail::first_collision(setup, r.ray, 0, rng);
      if (!place) {
        ++counts.back();
        continue;
      }
      const double t = length(*place - r.ray.o);
      const double share = std::expm1(-optical_depth(bodies, r.ray, t)) / std::expm1(-all);
      ++counts[std::size_t(std::min(int(share * kBins), kBins - 1))];
    }
    std::vector<double> expected(kBins + 1, -kFlights * std::expm1(-all) / kBins);
    expected.back() = kFlights * std::exp(-all);
    family.add(std::to_string(count), proof::counts_p_value(counts, expected));
  }
  EXPECT_TRUE(family.passes());
}

TEST(Instances, FiftyInAWhiteFurnaceAreInvisible) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::automatic;
  s.options.samples = 20;
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.environment = ConstantSky{Rgb(1.0f)};
  const auto places = random_places(50, 60, 3);
  const Volume v = instances_of(puff(), s, places);
  s.camera = frame(world_box(std::span(&v, 1)), 1);
  double scattered = 0;
  for (const PixelSums& p : render({&v, 1}, s).film.pixels) {
    EXPECT_EQ(mean(p), Vec3d(1.0));
    scattered += p.alpha;
  }
  EXPECT_GT(scattered, 500);
}

TEST(Instances, DoNotHangOnThreads) {
  CloudScene s = busy_scene();
  const Volume v = instances_of(puff(), s, random_places(60, 80, 8));
  s.camera = frame(world_box(std::span(&v, 1)), 1);
  const Film one = render({&v, 1}, s).film;
  s.options.threads = 3;
  EXPECT_TRUE(same_bytes(one, render({&v, 1}, s).film));
}

/// Fires shine from each place, and light what lies at others.
TEST(Instances, HaveFiresOfTheirOwn) {
  CloudScene s = busy_scene();
  s.lights.clear();
  s.environment = ConstantSky{Rgb(0.1f)};
  s.options.aovs = {};
  const Pyramid pyramid = build_pyramid(puff().grid);
  const BoundedGrid grid{puff().grid, pyramid};
  const Affine beside = translation({16, -32, 0}) * scaling(Vec3d(0.5));
  const auto places = exact_places();
  Volume v = instances_of(puff(), s, places);
  v.fire = std::make_shared<const Emitter>(
      make_emitter({.intensity = 2}, grid, &grid, v.object_to_world * beside));
  std::vector<Volume> copies = copies_of(puff(), s, places);
  for (Volume& copy : copies) {
    copy.fire = std::make_shared<const Emitter>(
        make_emitter({.intensity = 2}, grid, &grid, copy.object_to_world * beside));
  }
  const Box box = world_box(std::span(&v, 1));
  EXPECT_EQ(box, world_box(copies));
  s.camera = frame(box, 1);
  EXPECT_TRUE(same_bytes(render({&v, 1}, s).film, render(copies, s).film));
  proof::Family family;
  for (Volume& copy : copies) copy.fire = copies.front().fire;  // all at one place: another picture
  EXPECT_FALSE(same_bytes(render({&v, 1}, s).film, render(copies, s).film));
}

TEST(Instances, OfAShellTurnRaysAwayAndKeepTheMean) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::automatic;
  s.options.samples = proof::samples(200);
  s.options.count = true;
  Volume v = instances_of(puff(), s, random_places(30, 60, 5));
  s.camera = frame(world_box(std::span(&v, 1)), 1);
  const Pyramid pyramid = build_pyramid(puff().grid);
  v.shell = std::make_shared<const Shell>(
      fit_shell(make_support(puff().grid, pyramid), {ShellKind::hard, 6}));
  s.options.shells = ShellUse::off;
  const RenderResult without = render({&v, 1}, s);
  s.options.seed = 5;
  const RenderResult alike = render({&v, 1}, s);
  s.options.shells = ShellUse::on;
  const RenderResult with = render({&v, 1}, s);
  EXPECT_EQ(without.counts.shell_tests, 0u);
  EXPECT_GT(with.counts.shell_rejections, with.counts.shell_tests / 20);
  // Of the same paths.
  EXPECT_LT(with.counts.path.segments + with.counts.shadow.segments,
            alike.counts.path.segments + alike.counts.shadow.segments);
  proof::Family family;
  compare(without.film, with.film, "shells", family);
  EXPECT_TRUE(family.passes());
}

TEST(Instances, TakeAboutTwoHundredBytesEach) {
  constexpr int kMany = 1000;
  const CloudScene s = sunny();
  const Volume v = instances_of(puff(), s, random_places(kMany, 1000, 1));
  const detail::Instances all(std::span(&v, 1));
  const double bytes = double(all.bytes() + v.further_places.capacity() * sizeof(Affine)) / kMany;
  EXPECT_LT(bytes, 256);
  const Volume copy = v;
  EXPECT_EQ(copy.density.values, v.density.values);
}

TEST(Instances, ThatCannotBeAreNamed) {
  const CloudScene s = sunny();
  const auto error = [&](const Affine& third) {
    return error_of([&] { (void)instances_of(puff(), s, {{}, translation({9, 0, 0}), third}); });
  };
  EXPECT_TRUE(says(error(scaling({1, 0, 1})), "instances.volume_placement_world"));
  EXPECT_TRUE(says(error(translation({1e15, 0, 0})), "instances.cloud_lies_far"));
  EXPECT_TRUE(says(error(scaling(Vec3d(1e15))), "instances.optical_depth_per"));
  EXPECT_NE(error_of([&] {
              (void)instances_of(puff(), s, {scaling(Vec3d(0.0)), Affine{}});
            }).find("instance 1: "),
            std::string::npos);
}

/// Weights of flights multiply wherever they end.
TEST(Instances, WeightedTrackersHaveTheMeansOfTheOthers) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::off;
  s.options.samples = proof::samples(400);
  const Volume v = instances_of(puff(), s, {{}, translation({9, 0, 0})});
  s.camera = frame(world_box({&v, 1}), 1);
  const Film analog = render({&v, 1}, s).film;
  proof::Family family;
  for (const Tracker tracker : {Tracker::weighted_delta, Tracker::weighted_decomposition}) {
    s.options.tracker = tracker, s.options.seed = 2 + std::uint64_t(tracker);
    compare(render({&v, 1}, s).film, analog, name(tracker), family);
  }
  EXPECT_TRUE(family.passes());
}

/// A thousand clouds are one to users who read what was decided, and as thick as one.
TEST(Instances, AreOneVolumeToThePlan) {
  CloudScene s = sunny();
  s.options.guide = GuideUse::automatic;
  const Volume one = instances_of(puff(), s, {});
  const Volume many = instances_of(puff(), s, random_places(1000, 500, 2));
  s.camera = frame(world_box(std::span(&many, 1)), 1);
  const RenderPlan p = plan({&many, 1}, s.scene());
  EXPECT_EQ(p.decisions.size(), plan({&one, 1}, s.scene()).decisions.size());
  EXPECT_TRUE(p.warnings.empty()) << p.warnings.front();
  const double thickness = choose_transmittance({&one, 1}).thickness;
  EXPECT_NEAR(choose_transmittance({&many, 1}).thickness / thickness, 0.9, 0.3);
}

/// Calls on rays and points see the first place.
TEST(Instances, AreEmbeddedAtTheFirstPlace) {
  const CloudScene s = sunny();
  const auto places = random_places(3, 60, 4);
  const Volume v = instances_of(puff(), s, places);
  CloudScene moved = s;
  moved.medium.object_to_world = places.front();
  const Volume first = make_volume(puff().grid, build_pyramid(puff().grid), moved);
  EXPECT_EQ(v.density.world_to_cells, first.density.world_to_cells);
  EXPECT_EQ(v.density.world_box, first.density.world_box);
  EXPECT_EQ(v.object_to_world, first.object_to_world);
}

}  // namespace instances_test
}  // namespace pvol::test
