// Places that move: the ways that placements say, boxes around them, and rays at each time against
// those of what stands still there.
#include "pvol/volume/moving_places.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/shell/fit_shell.h"
#include "pvol/volume/facts.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/rays_through.h"

namespace pvol::test {
namespace moving_places_test {

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
  EXPECT_TRUE(
      says(expected(turned({1, 0, 0}, 0), turned({0, 1, 0}, 180)), "motion.rotation_less_half"));
  EXPECT_NE(expected(Placement{}, scaled(Vec3d(1, -1, 1))).find("mirrors"), std::string::npos);
  EXPECT_NE(expected(Placement{}, scaled(Vec3d(-1, -1, 1))).find("passes 0"), std::string::npos);
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
  // It turns and grows out of almost nothing: likewise.
  MovingMap grows = between(turned({0, 0, 1}, 0), turned({0, 0, 1}, 90));
  grows.linear = scaling(Vec3d(1e-3));
  grows.linear_rate[0].x = 1;
  const MovingPlace spiral = place_of(MovingMap{}, grows);
  for (int k = 0; k < 40; ++k) {  // wherever the extreme, at 0.548, is between the ends of steps
    const double end = 0.555 + 0.002 * k;
    const Box winding = swept_box(spiral, {}, point, 0, end);
    for (int i = 0; i <= 20'000; ++i) {
      ASSERT_TRUE(winding.contains(spiral.at(end * i / 20'000).point(point.lo))) << end;
    }
  }
}

/// Compares rays at a time, all over a box of the world, with those through what stands still
/// there: where they begin and what they leave of light, exactly. Returns how many met much.
int compare_rays(const detail::PathSetup& moving, float time, const detail::PathSetup& still,
                 const Box& around, Rng& rng, detail::ShellCounts& shells) {
  int met = 0;
  for (int r = 0; r < 24; ++r) {
    const auto [x, y, z, w] = rng.uniform4();
    const Vec3d target = around.lo + around.extent() * Vec3d(Vec3f(x, y, z));
    const double turns = 20 * double(w);
    const Vec3d from =
        target + Vec3d(300 * std::cos(turns), 90 * double(w) - 50, 300 * std::sin(turns));
    const Ray ray{from, normalize(target - from)};
    detail::ShellCounts none;
    const Passed a = pass(moving, ray, time, detail::kEndless, shells),
                 b = pass(still, ray, 0, detail::kEndless, none);
    if (a.first == detail::kEndless || b.first == detail::kEndless) {
      EXPECT_TRUE(a.first == b.first || moving.volumes.front().shell);
    } else if (!moving.volumes.front().shell) {  // which turns rays away from boxes
      EXPECT_NEAR(a.first, b.first, 1e-6);
    }
    EXPECT_NEAR(a.transmittance, b.transmittance, 2e-5);
    met += b.transmittance < 0.9;
  }
  return met;
}

/// What moves against what stands where it is at each of some times.
void expect_still_looks(const std::vector<MovingPlace>& places, bool shell, int times) {
  CloudScene s = scene_of({-0.25, 0.75});
  s.medium.extinction = 0.05;
  s.options.shells = shell ? ShellUse::on : ShellUse::off;
  Volume v = moving(puff(), s, places);
  if (shell) {
    v.shell = std::make_shared<const Shell>(
        fit_shell(make_support(puff().grid, build_pyramid(puff().grid)), {ShellKind::hard, 6}));
  }
  ASSERT_NE(v.moving_places, nullptr);
  const PlanOptions quick{.force = true, .forecast = false};
  const RenderPlan p = plan({&v, 1}, s.scene(), quick);
  EXPECT_TRUE(p.kernel.places_move);
  const detail::PathSetup setup(p);
  detail::ShellCounts shells;
  const Box around = world_box({&v, 1});
  Rng rng(4, 0, places.size());
  int met = 0;
  for (int k = 0; k < times; ++k) {
    const auto time = float(s.camera.shutter.at(double(rng.uniform())));
    const Volume still = still_at(puff(), s, places, double(time));
    const RenderPlan q = plan({&still, 1}, s.scene(), quick);
    const detail::PathSetup still_setup(q);
    met += compare_rays(setup, time, still_setup, around, rng, shells);
  }
  EXPECT_GT(met, 2 * times);
  EXPECT_EQ(shells.rejections > 0, shell);
}

/// In every way to move, with another map before it.
TEST(MovingPlaces, LookStillAtEachTime) {
  for (const bool shell : {false, true}) {
    for (std::size_t i = shell ? 5 : 0; i < maps().size(); ++i) {
      SCOPED_TRACE(i);
      const MovingMap object = maps()[(3 * i + 2) % maps().size()];
      expect_still_looks(
          {place_of(maps()[i], object), place_of(shifted({60, 0, 0}, {60, 20, 0}), object)}, shell,
          proof::samples(40));
    }
  }
}

TEST(MovingPlaces, LookStillInACrowd) { expect_still_looks(crowd(), false, proof::samples(40)); }

/// Guiding reckons with the middle of the shutter.
TEST(MovingPlaces, StandInTheMiddleOfTheShutterForEstimates) {
  const CloudScene s = scene_of({0, 0.5});
  const std::vector<MovingPlace> places = alone(swinging());
  const Volume v = moving(puff(), s, places), middle = still_at(puff(), s, places, 0.25);
  const detail::Instances a(std::span(&v, 1)), b(std::span(&middle, 1));
  EXPECT_TRUE(a.moves());
  EXPECT_FALSE(b.moves());
  EXPECT_LT(distance(a.all[0].world_to_cells, b.all[0].world_to_cells), 1e-12);
}

}  // namespace moving_places_test
}  // namespace pvol::test
