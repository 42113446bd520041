// Pictures of volumes that move as a whole: closed forms, averages of still pictures, and what must
// not change.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/velocities.h"

namespace pvol::test {
namespace rigid_motion_test {

/// 16^3 samples of 1: along each axis the density climbs from -1 to 0, and falls from 15 to 16.
const Field& block() {
  static const Field f = make_field("block", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}
double block_profile(double y) { return std::clamp(std::min(y + 1, 16 - y), 0.0, 1.0); }

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
    if (a.layers[i].name == "velocity") continue;  // what stands still has none
    EXPECT_TRUE(a.layers[i].sums == b.layers[i].sums) << a.layers[i].name;
  }
  EXPECT_EQ(still_world_box({&v, 1}), world_box(std::vector{still_at(puff(), s, places, 0)}));
}

/// What has no density is nowhere, though its fire moves.
TEST(RigidMotion, OfAFireAloneOnlyTheFireHasABox) {
  CloudScene s = sunny();
  s.camera.shutter = {-0.5, 0.5};
  const VoxelGrid none;
  Volume v = pvol::make_volume(none, build_pyramid(none), s.medium.medium(), s.volume_options());
  v.fire = std::make_shared<const Emitter>(make_emitter(
      Fire{.intensity = 2}, {block().grid, build_pyramid(block().grid)}, nullptr, Affine{}));
  v = move_places(v, alone(shifted(Vec3d{}, {5, 3, 1})), s.camera.shutter);
  ASSERT_TRUE(places_move(v));
  EXPECT_TRUE(world_box(v.density, v, 0).empty());
  EXPECT_FALSE(world_box(v.fire->field, v, 0).empty());
  s.camera = frame(world_box({&v, 1}), 1);
  s.camera.shutter = {-0.5, 0.5};
  s.lights = {AreaLight{.position = {0, 90, 0}, .radiance = Rgb(4.0f)}};
  s.options.samples = 4;
  double sum = 0;
  for (const PixelSums& p : render(v, s).film.pixels) sum += double(luminance(Rgb(mean(p))));
  EXPECT_GT(sum, 0);
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
        s.options.samples = proof::samples(8192);
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
      s.options.samples = proof::samples(2048);
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
    s.options.samples = proof::samples(1024);
    const Volume by_place = moving(block(), s, alone(shifted(Vec3d{}, step)));
    const Volume by_velocity = with_velocity(block(), s, still_at(block(), s, alone({}), 0), step);
    const Film a = render({&by_place, 1}, s).film;
    s.options.seed = 5;
    compare(a, render({&by_velocity, 1}, s).film, "even", family);
  }
  EXPECT_TRUE(family.passes());
}

/// Places of instances are those of the still volume, of which none need be the volume's own.
TEST(RigidMotion, InstancesOfWhatFlowsAreWhereTheyAre) {
  proof::Family family;
  const Vec3d step(8, -6, 4);
  const std::vector<Affine> instances{translation(Vec3d(30, 0, 4)) * scaling(Vec3d(1.25)),
                                      translation(Vec3d(-20, 5, 0))};
  CloudScene s = scene_of({0.75, 0.75});
  s.options.samples = proof::samples(1024);
  const Pyramid pyramid = build_pyramid(block().grid);
  const auto made = [&](const Affine& object_to_world) {
    VolumeOptions o = s.volume_options();
    o.object_to_world = object_to_world;
    o.instances = instances;
    return pvol::make_volume(block().grid, pyramid, s.medium.medium(), o);
  };
  const Volume there = made(translation(step * 0.75));
  const Volume flows = with_velocity(block(), s, made({}), step);
  s.camera = frame(world_box({&there, 1}), 1);
  s.camera.shutter = {0.75, 0.75};
  const Film a = render({&flows, 1}, s).film;
  s.options.seed = 9;
  s.camera.shutter = {};
  compare(a, render({&there, 1}, s).film, "two instances", family);
  EXPECT_TRUE(family.passes());
}

/// Velocities are those of the volume's own space, which moves.
TEST(RigidMotion, CarriesWhatVelocitiesMoveAlong) {
  proof::Family family;
  for (const double time : {-0.5, 0.75}) {
    CloudScene s = scene_of({time, time});
    s.options.samples = proof::samples(1024);
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

/// Deep samples lie where the density is while the shutter is open.
TEST(RigidMotion, DeepPicturesReachAsFarAsItMoves) {
  CloudScene s = scene_of({0, 1});
  s.options.deep = true;
  s.options.samples = 4;
  const Volume v = moving(block(), s, alone(shifted(Vec3d{}, {0, 0, -60})));
  const DeepFilm deep = render({&v, 1}, s).film.deep;
  EXPECT_GT(deep.back - deep.front, 76);
  EXPECT_LT(deep.back - deep.front, 90);
}

TEST(RigidMotion, WeightedTrackersHaveTheMeansOfTheOthers) {
  CloudScene s = scene_of({-0.5, 0.5});
  s.options.guide = GuideUse::off;
  s.options.samples = proof::samples(400);
  const auto picture = [&](Tracker tracker, std::uint64_t seed) {
    s.options.tracker = tracker, s.options.seed = seed;
    const Volume v = moving(puff(), s, alone(swinging()));
    return render({&v, 1}, s).film;
  };
  const Film analog = picture(Tracker::decomposition, 1);
  proof::Family family;
  compare(picture(Tracker::weighted_delta, 2), analog, "delta", family);
  compare(picture(Tracker::weighted_decomposition, 3), analog, "decomposition", family);
  EXPECT_TRUE(family.passes());
}

TEST(RigidMotion, ThePlanSaysWhatItTakes) {
  CloudScene s = scene_of({-0.5, 0.5});
  const Volume v = moving(block(), s, alone(shifted(Vec3d{}, {0, 10, 0})));
  const RenderPlan p = plan({&v, 1}, s.scene());
  EXPECT_TRUE(p.kernel.places_move);
  EXPECT_FALSE(p.kernel.moving);
  const Volume still = still_at(block(), s, alone(shifted(Vec3d{}, {0, 10, 0})), 0);
  EXPECT_EQ(p.kernel.kind, plan({&still, 1}, s.scene()).kernel.kind);
  EXPECT_GT(p.forecast.collisions, 0);
  std::string all;
  for (const Decision& d : p.decisions) all += d.what + ' ' + d.choice + ": " + d.reason + '\n';
  EXPECT_TRUE(says(all, "motion.motion_whole_moves"));
  EXPECT_TRUE(p.warnings.empty()) << p.warnings.front();
  const auto refused = [&](const Volume& of, const auto& change) {
    CloudScene with = s;
    change(with);
    return error_of([&] { (void)plan({&of, 1}, with.scene()); });
  };
  EXPECT_TRUE(says(refused(v, [](auto& c) { c.camera.shutter.close = 1; }),
                   "motion.instances_of_another_shutter"));
}

TEST(RigidMotion, RefusesPlacesThatBecomeFlatOrAreTooMany) {
  CloudScene s = scene_of({0, 3});
  const MovingMap shrinks = between(Placement{}, scaled(Vec3d(0.5, 1, 1)));
  const auto error = [&](const std::vector<MovingPlace>& places) {
    return error_of([&] { (void)moving(block(), s, places); });
  };
  EXPECT_TRUE(says(error(alone(shrinks)), "motion.moving_placement_becomes"));
  MovingMap turns;
  turns.turns = {{.axis = {0, 2, 0}, .angle = 0, .rate = 0.1}};
  EXPECT_TRUE(says(error(alone(turns)), "motion.turn_about_no_unit_axis"));
  EXPECT_TRUE(
      says(error({MovingPlace{}, place_of(shrinks, {})}), "motion.moving_placement_becomes_flat"));
  s.camera.shutter = {-5, 1.5};
  EXPECT_EQ(error(alone(shrinks)), "");
  const Volume v = still_at(block(), s, alone({}), 0);
  EXPECT_TRUE(says(error_of([&] {
                     (void)move_places(v, std::vector<MovingPlace>(2), {0, 1});
                   }),
                   "motion.moving_instances_volume"));
  const auto elsewhere = alone(shifted({1e-3, 0, 0}, {1, 0, 0}));
  EXPECT_TRUE(says(error_of([&] {
                     (void)move_places(v, elsewhere, {0, 1});
                   }),
                   "motion.moving_instance_starts"));
  s.options.homogenise = 0.01;
  EXPECT_NE(error(alone(shrinks)).find("homogenise"), std::string::npos);
  EXPECT_EQ(error(alone(shifted(Vec3d{}, {1, 0, 0}))), "");
  s.camera.shutter = {};
  EXPECT_EQ(error(alone(shrinks)), "") << "it grows while no one looks";
}

}  // namespace rigid_motion_test
}  // namespace pvol::test
