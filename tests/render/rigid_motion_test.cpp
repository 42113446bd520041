// Volumes that move as a whole: against still ones at each time, closed forms, averages of still
// pictures, and what must not change.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/render/placement.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"
#include "render/path/traversal.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/lit_scenes.h"
#include "support/pictures.h"
#include "support/velocities.h"

namespace pvol::test {
namespace {

/// 16^3 samples of 1: along each axis the density climbs from -1 to 0, and falls from 15 to 16.
const Field& block() {
  static const Field f = make_field("block", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}
double block_profile(double y) { return std::clamp(std::min(y + 1, 16 - y), 0.0, 1.0); }

/// A field at places as they are at a time, standing still.
Volume still_at(const Field& f, const CloudScene& s, const std::vector<MovingPlace>& places,
                double time) {
  VolumeOptions o = s.volume_options();
  o.object_to_world = places.front().object.at(time);
  for (const MovingPlace& p : places) o.instances.push_back(p.instance.at(time));
  if (places.size() == 1 && places.front().instance == MovingMap{}) o.instances.clear();
  const Pyramid pyramid = build_pyramid(f.grid, s.options.look_up);
  return pvol::make_volume(f.grid, pyramid, s.medium.medium(), o);
}

Volume moving(const Field& f, const CloudScene& s, const std::vector<MovingPlace>& places) {
  return move_places(still_at(f, s, places, 0), places, s.camera.shutter);
}

// Made member by member: of vectors in temporaries GCC 12 warns without a reason.
Placement turned(Vec3d axis, double degrees) {
  Placement p;
  p.rotate = {{axis, degrees}};
  return p;
}
Placement moved(Vec3d by) {
  Placement p;
  p.translate = by;
  return p;
}
Placement scaled(Vec3d by) {
  Placement p;
  p.scale = by;
  return p;
}
Placement matrix(const Affine& map) {
  Placement p;
  p.matrix = map;
  return p;
}
MovingPlace place_of(MovingMap instance, MovingMap object) {
  MovingPlace p;
  p.instance = std::move(instance);
  p.object = std::move(object);
  return p;
}
std::vector<MovingPlace> alone(MovingMap object) {
  return {place_of(MovingMap{}, std::move(object))};
}

MovingMap between(const Placement& from, const Placement& to) {
  return MovingPlacement{from, to}.map();
}
MovingMap shifted(Vec3d from, Vec3d to) { return between(moved(from), moved(to)); }

/// About a point beside it.
MovingMap swinging() {
  return between({.scale = Vec3d(1, 0.8, 1.1),
                  .rotate = {{{0.2, 1, 0.1}, 10}, {{0, 0, 1}, -20}},
                  .translate = Vec3d(3, -2, 5)},
                 {.scale = Vec3d(1.3, 0.9, 0.8),
                  .rotate = {{{0.2, 1, 0.1}, 120}, {{0, 0, 1}, 25}},
                  .translate = Vec3d(9, 4, -6)});
}

/// Maps that say where they go in every way.
std::vector<MovingMap> maps() {
  const Placement stretched{
      .matrix = Affine{{Vec3d{1, 0.3, 0}, Vec3d{-0.2, 1.4, 0.1}, Vec3d{0.3, 0, 0.8}}, {4, 5, 6}}};
  const Placement askew{
      .scale = Vec3d(0.7, 1.2, 1), .rotate = {{{1, 2, 3}, 100}}, .translate = Vec3d(-7, 3, 1)};
  return {
      MovingMap{},
      shifted({1, 2, 3}, {-9, 6, 14}),
      swinging(),
      between(turned({0, 1, 0}, 0), turned({0, 1, 0}, 700)),
      between(turned({0, 1, 0}, 30), turned({1, 0, 0}, 50)),
      between(stretched, askew),
      between(scaled(Vec3d(-1, 1, 1)), {.scale = Vec3d(-2, 0.5, 1), .rotate = {{{1, 1, 0}, 80}}})};
}

CloudScene scene_of(Shutter shutter) {
  CloudScene s;
  s.medium.extinction = 0.4;
  s.medium.albedo = Rgb(0.95f);
  s.environment = ConstantSky{Rgb(0.5f)};
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.camera.position = {8, 12, 130};
  s.camera.target = {8, 8, 8};
  s.camera.shutter = shutter;
  s.options.width = s.options.height = 16;
  s.options.samples = 256;
  s.options.threads = 1;
  return s;
}

Affine linear(Affine a) {
  a.t = {};
  return a;
}
double distance(const Affine& a, const Affine& b) {
  double most = length(a.t - b.t);
  for (std::size_t r = 0; r < 3; ++r) most = std::max(most, length(a.m[r] - b.m[r]));
  return most;
}

TEST(MovingPlacement, IsEachOfItsTwoAtItsTime) {
  Rng rng(1, 0, 0);
  const auto uniform = [&](double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); };
  const auto random = [&](int turns) {
    Placement p{.scale = Vec3d(uniform(0.3, 3), uniform(0.3, 3), uniform(0.3, 3)),
                .translate = Vec3d(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9))};
    for (int i = 0; i < turns; ++i) {
      p.rotate.push_back({{uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)}, uniform(-400, 400)});
    }
    return p;
  };
  for (int i = 0; i < 300; ++i) {
    MovingPlacement m{random(i % 3), random(i / 3 % 3)};
    if (i % 2) m.to.rotate = m.from.rotate;
    for (Turn& turn : m.to.rotate) turn.degrees += uniform(-300, 300);
    if (i % 5 == 0) m.from = matrix(m.from.map());
    if (i % 7 == 0) m.to = matrix(m.to.map());
    if (misfit(m)) continue;
    const MovingMap map = m.map();
    EXPECT_LT(distance(map.at(0), m.from.map()), 1e-12) << i;
    EXPECT_LT(distance(map.at(1), m.to.map()), 1e-12) << i;
    EXPECT_TRUE(map.moves());
    EXPECT_FALSE((MovingPlacement{m.from, m.from}.map().moves()));
    EXPECT_LT(distance(MovingPlacement{m.from, m.from}.map().at(0.7), m.from.map()), 1e-12);
  }
}

TEST(MovingPlacement, TurnsByTheAnglesSaidOrTheShortestWay) {
  const Vec3d axis = normalize(Vec3d(1, 2, -1));
  const auto by = [&](double degrees) { return Placement{.rotate = {{axis, degrees}}}.map(); };
  const MovingMap spin = between(turned(axis, 20), turned(axis, 740));
  EXPECT_LT(distance(spin.at(0.25), by(200)), 1e-12);
  EXPECT_LT(distance(spin.at(-0.5), by(-340)), 1e-12);
  const MovingMap begins = between(Placement{}, turned(axis, -90));
  EXPECT_LT(distance(begins.at(1.0 / 3), by(-30)), 1e-12);
  // Of matrices a turn by 260 degrees is one by -100.
  const MovingMap shortest = between(matrix(by(0)), matrix(by(260)));
  EXPECT_LT(distance(shortest.at(0.5), by(-50)), 1e-12);
  EXPECT_LT(distance(shortest.at(1.5), by(-150)), 1e-12);
  // About other axes: rigid all the way, at an even rate.
  const MovingMap other = between(turned({0, 1, 0}, 70), turned({1, 0, 0}, 80));
  const Affine step = linear(other.at(0.1)) * inverse(linear(other.at(0)));
  for (double t = -1; t < 2; t += 0.1) {
    const Affine a = linear(other.at(t)), next = linear(other.at(t + 0.1));
    EXPECT_NEAR(determinant(a), 1, 1e-12);
    EXPECT_NEAR(length(a.vector({3, 4, 12})), 13, 1e-11);
    EXPECT_LT(distance(next, step * a), 1e-12);
  }
}

TEST(MovingPlacement, RefusesWhatHasNoWayBetween) {
  const auto expected = [](const Placement& from, const Placement& to) {
    const auto wrong = misfit(MovingPlacement{from, to});
    return wrong ? wrong->expected : std::string();
  };
  EXPECT_EQ(expected(Placement{}, turned({0, 1, 0}, 180)), "");
  EXPECT_NE(expected(turned({1, 0, 0}, 0), turned({0, 1, 0}, 180)).find("half turn"),
            std::string::npos);
  EXPECT_NE(expected(Placement{}, scaled(Vec3d(1, -1, 1))).find("mirrored"), std::string::npos);
  EXPECT_NE(expected(Placement{}, scaled(Vec3d(-1, -1, 1))).find("pass 0"), std::string::npos);
  EXPECT_EQ(expected(scaled(Vec3d(-1, -1, 1)), scaled(Vec3d(-3, -0.2, 1))), "");
}

/// All that a place holds is in its box, whatever the time; and the box is hardly larger.
TEST(MovingPlaces, StayInTheirBoxes) {
  Rng rng(2, 0, 0);
  const auto uniform = [&](double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); };
  for (const Shutter shutter : {Shutter{-0.25, 0.25}, Shutter{0, 0.9}, Shutter{-1, 2}}) {
    for (const MovingMap& instance : maps()) {
      for (const MovingMap& object : maps()) {
        const MovingPlace place = place_of(instance, object);
        if (!stays_regular(instance, shutter.open, shutter.close) ||
            !stays_regular(object, shutter.open, shutter.close)) {
          continue;
        }
        const Affine to_object = translation({uniform(-20, 20), 0, 3}) * scaling(Vec3d(0.5));
        const Box box{{-4, 2, 0}, {30, 12, 25}};
        const Box swept = swept_box(place, to_object, box, shutter.open, shutter.close);
        Box seen;
        for (int i = 0; i < 4000; ++i) {
          const double t = shutter.at(uniform(0, 1));
          Vec3d p = box.lo + box.extent() * Vec3d(uniform(0, 1), uniform(0, 1), uniform(0, 1));
          if (i % 2) {  // corners reach farthest
            for (int a = 0; a < 3; ++a) p[a] = uniform(0, 1) < 0.5 ? box.lo[a] : box.hi[a];
          }
          const Vec3d at = (place.at(t) * to_object).point(p);
          ASSERT_TRUE(swept.contains(at));
          seen = extend(seen, at);
        }
        const double size = length(transform(place.at(0) * to_object, box).extent());
        EXPECT_LT(length(swept.extent() - seen.extent()),
                  0.15 * size + 0.05 * length(seen.extent()));
      }
    }
  }
}

/// Just the extreme of an arc, which no end of a step sees.
TEST(MovingPlaces, ArcsBulgeBetweenTheEndsOfTheShutter) {
  const MovingPlace place =
      place_of(MovingMap{}, between(turned({0, 0, 1}, 0), turned({0, 0, 1}, 90)));
  const Box point{{10, 0, 0}, {10 + 1e-9, 1e-9, 1e-9}};
  const Box swept = swept_box(place, {}, point, -0.5, 0.5);
  EXPECT_GE(swept.hi.x, 10);
  EXPECT_LT(swept.hi.x, 10.1);
  EXPECT_NEAR(swept.hi.y, 10 * std::sqrt(0.5), 0.1);
  EXPECT_NEAR(swept.lo.y, -10 * std::sqrt(0.5), 0.1);
  // It turns slowly and flies fast: most of the acceleration is the product of both.
  const MovingPlace flies =
      place_of(between(Placement{}, turned({0, 0, 1}, 20)), shifted({-60, 0, 0}, {40, 0, 0}));
  const Box course = swept_box(flies, {}, point, 0, 1);
  for (int i = 0; i <= 200'000; ++i) {
    ASSERT_TRUE(course.contains(flies.at(i / 200'000.0).point(point.lo)));
  }
}

/// Compares rays at a time, all over a box of the world: where they begin and what they leave of
/// light, exactly. Returns how many met much.
int compare_rays(detail::MovingVolumes& moving, detail::ManyVolumes& still, const Box& around,
                 Rng& rng) {
  int met = 0;
  for (int r = 0; r < 24; ++r) {
    const auto [x, y, z, w] = rng.uniform4();
    const Vec3d target = around.lo + around.extent() * Vec3d(Vec3f(x, y, z));
    const double turns = 20 * double(w);
    const Vec3d from =
        target + Vec3d(300 * std::cos(turns), 90 * double(w) - 50, 300 * std::sin(turns));
    const Ray ray{from, normalize(target - from)};
    const Vec3f d(ray.d);
    const bool meets = moving.start(ray);
    EXPECT_EQ(meets, still.start(ray));
    if (!meets) continue;
    EXPECT_LT(length(moving.position() - still.position()), 1e-6);
    const double there = double(still.pass(d, detail::kEndless, rng));
    EXPECT_NEAR(double(moving.pass(d, detail::kEndless, rng)), there, 2e-5);
    met += there < 0.9;
  }
  return met;
}

/// What moves against what stands where it is at each of some times.
void expect_still_looks(const std::vector<MovingPlace>& places, bool shell, int times) {
  CloudScene s = scene_of({-0.25, 0.75});
  s.medium.extinction = 0.05;
  s.options.transmittance = Transmittance::regular;
  s.options.shells = shell ? ShellUse::on : ShellUse::off;
  Volume v = moving(puff(), s, places);
  if (shell) {
    v.shell = std::make_shared<const Shell>(
        fit_shell(make_support(puff().grid, build_pyramid(puff().grid)), {ShellKind::hard, 6}));
  }
  ASSERT_NE(v.moving_places, nullptr);
  const PlanOptions quick{.force = true, .forecast = false};
  const RenderPlan p = plan({&v, 1}, s.scene(), quick);
  EXPECT_EQ(plain(p.kernel.paths), Paths::moving_places);
  const detail::PathSetup setup(p);
  detail::MovingVolumes traversal(setup);
  const Box around = world_box({&v, 1});
  Rng rng(4, 0, places.size());
  int met = 0;
  for (int k = 0; k < times; ++k) {
    const auto time = float(s.camera.shutter.at(double(rng.uniform())));
    const Volume still = still_at(puff(), s, places, double(time));
    const RenderPlan q = plan({&still, 1}, s.scene(), quick);
    const detail::PathSetup still_setup(q);
    detail::ManyVolumes other(still_setup);
    traversal.work.set_time(time);
    met += compare_rays(traversal, other, around, rng);
  }
  EXPECT_GT(met, 2 * times);
  EXPECT_EQ(traversal.work.shell_rejections > 0, shell);
}

/// In every way to move, with another map before it.
TEST(MovingPlaces, LookStillAtEachTime) {
  for (const bool shell : {false, true}) {
    for (std::size_t i = shell ? 5 : 0; i < maps().size(); ++i) {
      SCOPED_TRACE(i);
      const MovingMap object = maps()[(3 * i + 2) % maps().size()];
      expect_still_looks(
          {place_of(maps()[i], object), place_of(shifted({60, 0, 0}, {60, 20, 0}), object)}, shell,
          40);
    }
  }
}

/// So many that a tree is asked which, and that their maps are not all kept.
std::vector<MovingPlace> crowd() {
  Placement from = scaled(Vec3d(0.3)), to = turned({0, 1, 0}, 60);
  to.scale = from.scale;
  std::vector<MovingPlace> places;
  for (int i = 0; i < 90; ++i) {
    const Vec3d at(double(i % 10) * 12 - 50, double(i / 10) * 12 - 50, i % 3 * 9);
    places.push_back(place_of(i % 4 ? shifted(at, at + Vec3d(4, 3 * (i % 7), -5)) : shifted(at, at),
                              between(from, to)));
  }
  return places;
}

TEST(MovingPlaces, LookStillInACrowd) { expect_still_looks(crowd(), false, 40); }

/// At one time the moving is a still picture, to the last bit where maps are exact.
TEST(RigidMotion, AnInstantIsTheStillPictureWithAllItsLayers) {
  CloudScene s = sunny();
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}, PointLight{{10, 200, 40}, Rgb(9000.0f)}};
  s.options.guide = GuideUse::off;
  s.options.transmittance = Transmittance::analog;
  s.options.depth = 4;
  s.options.width = s.options.height = 20;
  for (const AovRow& r : kAovs) s.options.aovs.add(r.aov);
  s.camera.shutter = {0.5, 0.5};
  const std::vector<MovingPlace> places{place_of(shifted({0, 0, 0}, {64, 0, -32}), {}),
                                        place_of(shifted({0, -64, 0}, {0, -64, 0}), {}),
                                        place_of(shifted({16, 8, 64}, {8, 32, 64}), {})};
  const Volume v = moving(puff(), s, places);
  const Volume there = still_at(puff(), s, places, 0.5);
  const Box box = world_box({&v, 1});
  s.camera.position = box.centre() + Vec3d(20, 30, 250);
  s.camera.target = box.centre();
  const Film a = render({&v, 1}, s).film, b = render({&there, 1}, s).film;
  EXPECT_TRUE(same_bytes(a, b));
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    EXPECT_TRUE(a.layers[i].sums == b.layers[i].sums) << a.layers[i].name;
  }
  EXPECT_EQ(still_world_box({&v, 1}), world_box(std::vector{still_at(puff(), s, places, 0)}));
}

TEST(RigidMotion, EveryPixelOfTheFurnaceIsTheSky) {
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 1}, Shutter{0.75, 0.75}}) {
    for (const Tracker tracker : kTrackers) {
      if (is_weighted(tracker)) continue;
      CloudScene s = scene_of(shutter);
      s.medium.albedo = Rgb(1.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      s.lights.clear();
      s.options.tracker = tracker;
      s.options.samples = 8;
      const Volume v = moving(puff(), s, alone(swinging()));
      const std::vector<Volume> both{v, still_at(block(), s, alone(shifted({9, 3, -20}, {})), 0)};
      for (const std::span<const Volume> volumes : {std::span(&v, 1), std::span(both)}) {
        double scattered = 0;
        for (const PixelSums& p : render(volumes, s).film.pixels) {
          EXPECT_EQ(mean(p), Vec3d(1.0)) << label(tracker);
          scattered += p.alpha;
        }
        EXPECT_GT(scattered, 100);
      }
    }
  }
}

/// Through a block that moves across the view, as seen from so far that rays are parallel.
TEST(RigidMotion, TransmittanceAndEmissionAreTheirMeansOverTime) {
  proof::Family family;
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 0.75}, Shutter{0.5, 0.5}}) {
    for (const double place : {15.2, 8.0, -2.5, 21.0}) {
      for (const bool emits : {false, true}) {
        CloudScene s = scene_of(shutter);
        s.medium.extinction = 0.11;
        s.medium.albedo = Rgb(0.0f);
        s.medium.emission = Rgb(emits ? 1.0f : 0.0f);
        s.environment = ConstantSky{Rgb(emits ? 0.0f : 1.0f)};
        s.lights.clear();
        s.camera.position = {8, place, 1e5};
        s.camera.target = {8, place, 0};
        s.camera.fov = 1e-9;
        s.options.width = s.options.height = 8;
        s.options.samples = 8192;
        const double speed = 13;
        const Volume v = moving(block(), s, alone(shifted(Vec3d{}, {2, speed, 0.5})));
        double expected = 0;
        constexpr int kSteps = 20'000;
        for (int i = 0; i < kSteps; ++i) {
          const double t = shutter.at((i + 0.5) / kSteps);
          const double depth = s.medium.extinction * 16 * block_profile(place - speed * t);
          expected += (emits ? 1 - std::exp(-depth) : std::exp(-depth)) / kSteps;
        }
        compare(average(render(v, s).film), {Vec3d(expected), Vec3d(1e-14)},
                "at " + std::to_string(place), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

void add_film(Film& sum, const Film& part) {
  if (sum.pixels.empty()) {
    sum = part;
    return;
  }
  for (std::size_t p = 0; p < sum.pixels.size(); ++p) {
    sum.pixels[p].sum += part.pixels[p].sum;
    sum.pixels[p].sum_squares += part.pixels[p].sum_squares;
    sum.pixels[p].alpha += part.pixels[p].alpha;
    sum.pixels[p].samples += part.pixels[p].samples;
  }
}

/// The mean of still pictures over the shutter.
Film mean_of_stills(const Field& f, CloudScene s, const std::vector<MovingPlace>& places) {
  Film sum;
  constexpr int kTimes = 64;
  s.options.samples /= kTimes;
  s.options.guide = GuideUse::off;
  for (int i = 0; i < kTimes; ++i) {
    s.options.seed = std::uint64_t(77 + i);
    const Volume v = still_at(f, s, places, s.camera.shutter.at((i + 0.5) / kTimes));
    add_film(sum, render({&v, 1}, s).film);
  }
  return sum;
}

/// What turns beside its axis, what grows, instances; guided and not.
TEST(RigidMotion, IsTheMeanOfStillPictures) {
  const MovingMap turning = between({.rotate = {{{0, 0, 1}, 0}}, .translate = Vec3d(8, 8, 8)},
                                    {.rotate = {{{0, 0, 1}, 80}}, .translate = Vec3d(8, 8, 8)});
  const std::vector<std::vector<MovingPlace>> scenes{
      alone(turning),
      alone(swinging()),
      {place_of(shifted({-20, 0, 0}, {-20, 14, 0}), turning),
       place_of(shifted({10, -20, 0}, {10, -20, 0}), turning)},
  };
  proof::Family family;
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 1}}) {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      CloudScene s = scene_of(shutter);
      s.options.samples = 2048;
      const Film expected = mean_of_stills(block(), s, scenes[i]);
      const Volume v = moving(block(), s, scenes[i]);
      for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
        s.options.guide = guide;
        const RenderResult r = render({&v, 1}, s);
        EXPECT_EQ(r.guided, guide == GuideUse::on);
        compare(r.film, expected, std::to_string(i) + (r.guided ? ", guided" : ""), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(RigidMotion, HasLessNoiseGuided) {
  CloudScene s = sunny();
  s.camera.shutter = {0.5, 1};  // where the file has it is little of it
  s.options.samples = 400;
  const Volume v = moving(puff(), s, alone(shifted({}, {60, 0, 0})));
  const Box box = world_box({&v, 1});
  s.camera.position = box.centre() + Vec3d(20, 30, 150);
  s.camera.target = box.centre();
  const auto variance = [&] {
    double sum = 0;
    for (const PixelSums& p : render({&v, 1}, s).film.pixels) sum += variance_of_mean(p).y;
    return sum;
  };
  const double guided = variance();
  s.options.guide = GuideUse::off;
  const double plain = variance();
  RecordProperty("ratio", std::to_string(guided / plain));
  EXPECT_LT(guided, 0.65 * plain);
}

Volume with_velocity(const Field& f, const CloudScene& s, Volume still, Vec3d velocity) {
  const VelocityGrid everywhere =
      make_velocity({-40, -40, -40}, {64, 64, 64}, [=](Vec3i) { return velocity; });
  VolumeOptions o = s.volume_options();
  o.object_to_world = still.object_to_world;
  return make_moving(std::move(still), build_pyramid(f.grid), f.grid.index_to_world,
                     {everywhere, 1, s.camera.shutter}, o);
}

TEST(RigidMotion, IsThatOfAnEvenVelocity) {
  proof::Family family;
  const Vec3d step(12, -9, 5);
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0.75, 0.75}}) {
    CloudScene s = scene_of(shutter);
    s.options.samples = 1024;
    const Volume by_place = moving(block(), s, alone(shifted(Vec3d{}, step)));
    const Volume by_velocity = with_velocity(block(), s, still_at(block(), s, alone({}), 0), step);
    const Film a = render({&by_place, 1}, s).film;
    s.options.seed = 5;
    compare(a, render({&by_velocity, 1}, s).film, "even", family);
  }
  EXPECT_TRUE(family.passes());
}

/// Velocities are those of the volume's own space, which moves.
TEST(RigidMotion, CarriesWhatVelocitiesMoveAlong) {
  proof::Family family;
  for (const double time : {-0.5, 0.75}) {
    CloudScene s = scene_of({time, time});
    s.options.samples = 1024;
    const Vec3d step(8, 0, -6);
    const std::vector<MovingPlace> places = alone(swinging());
    Volume v = with_velocity(block(), s, still_at(block(), s, places, 0), step);
    v = move_places(std::move(v), places, s.camera.shutter);
    const Film a = render({&v, 1}, s).film;
    CloudScene still = s;
    still.options.seed = 7;
    still.medium.object_to_world = places[0].object.at(time) * translation(step * time);
    compare(a, render(make_volume(block().grid, build_pyramid(block().grid), still), still).film,
            "at " + std::to_string(time), family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(RigidMotion, ThatIsNoneChangesNothing) {
  const Placement at{.scale = Vec3d(1.1), .rotate = {{{1, 1, 0}, 40}}, .translate = Vec3d(2, 0, 1)};
  CloudScene s = scene_of({-0.5, 0.5});
  s.medium.object_to_world = at.map();
  s.options.samples = 16;
  const Volume v = make_volume(puff().grid, build_pyramid(puff().grid), s);
  const Film expected = render({&v, 1}, s).film;
  const Volume rests = move_places(v, alone(between(at, at)), s.camera.shutter);
  EXPECT_EQ(rests.moving_places, nullptr);
  EXPECT_TRUE(same_bytes(render({&rests, 1}, s).film, expected));
  s.camera.shutter = {};
  const Volume closed = move_places(v, alone(between(at, Placement{})), s.camera.shutter);
  EXPECT_EQ(closed.moving_places, nullptr);
  EXPECT_TRUE(same_bytes(render({&closed, 1}, s).film, expected));
}

TEST(RigidMotion, ThreadsChangeNoBit) {
  CloudScene s = scene_of({-0.5, 0.5});
  s.options.samples = 16;
  const std::vector<MovingPlace> places = crowd();
  const Volume v = moving(puff(), s, places);
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    s.options.guide = guide;
    s.options.threads = 1;
    const Film one = render({&v, 1}, s).film;
    s.options.threads = 3;
    EXPECT_TRUE(same_bytes(one, render({&v, 1}, s).film));
  }
}

/// Deep samples lie where matter is while the shutter is open.
TEST(RigidMotion, DeepPicturesReachAsFarAsItMoves) {
  CloudScene s = scene_of({0, 1});
  s.options.deep = true;
  s.options.samples = 4;
  const Volume v = moving(block(), s, alone(shifted(Vec3d{}, {0, 0, -60})));
  const DeepFilm deep = render({&v, 1}, s).film.deep;
  EXPECT_GT(deep.back - deep.front, 76);
  EXPECT_LT(deep.back - deep.front, 90);
}

TEST(RigidMotion, ThePlanSaysWhatItTakes) {
  CloudScene s = scene_of({-0.5, 0.5});
  const Volume v = moving(block(), s, alone(shifted(Vec3d{}, {0, 10, 0})));
  const RenderPlan p = plan({&v, 1}, s.scene());
  EXPECT_TRUE(p.kernel.places_move);
  EXPECT_FALSE(p.kernel.moving);
  EXPECT_EQ(p.kernel.lanes, Lanes::scalar);
  EXPECT_GT(p.forecast.collisions, 0);
  std::string all;
  for (const Decision& d : p.decisions) all += d.what + ' ' + d.choice + ": " + d.reason + '\n';
  EXPECT_NE(all.find("motion as a whole: it moves by up to 5 world units"), std::string::npos)
      << all;
  EXPECT_NE(all.find("the volume moves as a whole"), std::string::npos) << all;
  EXPECT_TRUE(p.doubts.empty()) << p.doubts.front();
  const auto refused = [&](const Volume& of, const auto& change) {
    CloudScene with = s;
    change(with);
    return error_of([&] { (void)plan({&of, 1}, with.scene()); });
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos ? testing::AssertionSuccess()
                                                : testing::AssertionFailure() << text;
  };
  EXPECT_TRUE(has(refused(v, [](auto& c) { c.camera.shutter.close = 1; }), "another shutter"));
  EXPECT_TRUE(has(refused(v, [](auto& c) { c.options.line_emission = LineEmission::on; }),
                  "gathered at collisions"));
  CloudScene weighted = s;
  weighted.options.tracker = Tracker::weighted_delta;
  EXPECT_TRUE(has(refused(moving(block(), weighted, alone(shifted(Vec3d{}, {0, 10, 0}))),
                          [](auto& c) { c.options.tracker = Tracker::weighted_delta; }),
                  "tracker without weights"));
  Volume burning = v;
  const Pyramid pyramid = build_pyramid(block().grid);
  const BoundedGrid grid{block().grid, pyramid};
  burning.fire = std::make_shared<const Emitter>(make_emitter({}, grid, &grid, {}));
  EXPECT_TRUE(has(refused(burning, [](auto&) {}), "a fire stands still"));
  Volume coloured = v;
  coloured.medium.extinction_color = Rgb(1.0f, 0.5f, 0.2f);
  EXPECT_TRUE(has(refused(coloured, [](auto&) {}), "extinction_color"));
}

TEST(RigidMotion, RefusesPlacesThatBecomeFlatOrAreTooMany) {
  CloudScene s = scene_of({0, 3});
  const MovingMap shrinks = between(Placement{}, scaled(Vec3d(0.5, 1, 1)));
  const auto error = [&](const std::vector<MovingPlace>& places) {
    return error_of([&] { (void)moving(block(), s, places); });
  };
  EXPECT_NE(error(alone(shrinks)).find("becomes flat"), std::string::npos);
  EXPECT_NE(error({MovingPlace{}, place_of(shrinks, {})})
                .find("instance 2: a moving placement becomes flat"),
            std::string::npos);
  s.camera.shutter = {-5, 1.5};
  EXPECT_EQ(error(alone(shrinks)), "");
  const Volume v = still_at(block(), s, alone({}), 0);
  EXPECT_NE(error_of([&] {
              (void)move_places(v, std::vector<MovingPlace>(2), {0, 1});
            }).find("expected as many"),
            std::string::npos);
  const auto elsewhere = alone(shifted({1e-3, 0, 0}, {1, 0, 0}));
  EXPECT_NE(error_of([&] {
              (void)move_places(v, elsewhere, {0, 1});
            }).find("at time 0"),
            std::string::npos);
  s.options.homogenise = 0.01;
  EXPECT_NE(error(alone(shrinks)).find("homogenise"), std::string::npos);
  EXPECT_EQ(error(alone(shifted(Vec3d{}, {1, 0, 0}))), "");
}

}  // namespace
}  // namespace pvol::test
