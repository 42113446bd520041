// The layer of velocities: of clouds that flow, and of places that move as a whole.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/render/render.h"
#include "pvol/volume/motion.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/moving_places.h"
#include "support/velocities.h"

namespace pvol::test {
namespace velocity_layer_test {

CloudScene told(Shutter shutter) {
  CloudScene s = scene_of(shutter);
  s.options.samples = 16;
  s.options.aovs = {Aov::velocity, Aov::position};
  return s;
}

VelocityGrid everywhere(Vec3d velocity) {
  return make_velocity({-60, -60, -60}, {160, 160, 160}, [=](Vec3i) { return velocity; });
}

/// The puff of lit_scenes.h, in which everything flows alike.
Volume flowing(CloudScene& s, Vec3d velocity, double seconds) {
  const Pyramid p = build_pyramid(puff().grid);
  return make_moving(make_volume(puff().grid, p, s), p, puff().grid.index_to_world,
                     {everywhere(velocity), seconds, s.camera.shutter}, s.volume_options());
}

/// Calls f(velocity, position) for the pixels in which anything collided.
template <class F>
int for_hits(const Film& film, const F& f) {
  const Layer* velocity = nullptr;
  const Layer* position = nullptr;
  for (const Layer& l : film.layers) (l.name == "velocity" ? velocity : position) = &l;
  int hits = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const Vec3d v = value(*velocity, film, i);
    if (film.pixels[i].alpha > 0) {
      f(v, value(*position, film, i)), ++hits;
    } else {
      EXPECT_EQ(v, Vec3d{});
    }
  }
  return hits;
}

TEST(VelocityLayer, IsTheGridsInTheWorldHoweverLongTheShutterIsOpen) {
  for (const Shutter shutter : {Shutter{0, 0}, Shutter{-0.25, 0.25}}) {
    CloudScene s = told(shutter);
    s.medium.object_to_world =
        Placement{.scale = Vec3d(2), .rotate = {{{0, 0, 1}, 90}}, .translate = Vec3d(40, -30, 0)}
            .map();
    const Vec3d expected(-2 * 36.0 / 24, 2 * 12.0 / 24, 2 * 6.0 / 24);
    const Volume v = flowing(s, {12, 36, 6}, 1.0 / 24);
    EXPECT_EQ(v.density.motion != nullptr, shutter.moves());
    const int hits = for_hits(render(v, s).film, [&](Vec3d velocity, Vec3d) {
      EXPECT_LT(length(velocity - expected), 1e-5);
    });
    EXPECT_GT(hits, 20);
  }
}

/// The velocity of a body that turns about an axis is linear in the place, so its means over the
/// samples of a pixel are exact.
TEST(VelocityLayer, IsThatOfATurnAboutAnAxis) {
  for (const Shutter shutter : {Shutter{0, 0}, Shutter{-0.5, 0.5}}) {
    CloudScene s = told(shutter);
    const Vec3d axis = normalize(Vec3d(1, 2, -0.5));
    constexpr double kDegrees = 24;
    const Volume v = moving(puff(), s, alone(between(turned(axis, 0), turned(axis, kDegrees))));
    EXPECT_EQ(places_move(v), shutter.moves());
    const Vec3d turn = axis * (kDegrees * 3.14159265358979 / 180);
    const int hits = for_hits(render(v, s).film, [&](Vec3d velocity, Vec3d at) {
      EXPECT_LT(length(velocity - cross(turn, at)), 1e-4 * length(at));
    });
    EXPECT_GT(hits, 20);
  }
}

TEST(VelocityLayer, AddsTheFlowToTheMotionOfThePlace) {
  CloudScene s = told({0, 0});
  Volume v = flowing(s, {0, 1, 0}, 1);
  v = move_places(std::move(v),
                  alone(between(turned({0, 0, 1}, 0),
                                {.rotate = {{{0, 0, 1}, 0}}, .translate = Vec3d(5, 0, -2)})),
                  s.camera.shutter);
  const int hits = for_hits(render(v, s).film, [&](Vec3d velocity, Vec3d) {
    EXPECT_LT(length(velocity - Vec3d(5, 1, -2)), 1e-5);
  });
  EXPECT_GT(hits, 20);
}

/// Two clouds in one place, one of half the extinction, have on average the mean of their
/// velocities; what a ball hides has none.
TEST(VelocityLayer, IsAMeanByExtinctionAndZeroOnSurfaces) {
  CloudScene s = told({0, 0});
  s.options.samples = 256;
  const Volume slow = flowing(s, {0, 3, 0}, 1);
  s.medium.extinction *= 2;
  const Volume fast = flowing(s, {6, 0, 0}, 1);
  const Film film = render(std::vector{slow, fast}, s).film;
  double collided = 0, of_fast = 0;
  std::size_t i = 0;
  for (const Layer& l : film.layers) {
    if (l.name != "velocity") continue;
    for (; i < film.pixels.size(); ++i) {
      const Vec3d v = value(l, film, i);
      const double share = v.x / 6;  // of the samples that collided
      if (film.pixels[i].alpha == 0) continue;
      EXPECT_LT(length(v - Vec3d(6 * share, 3 * (1 - share), 0)), 1e-5);
      collided += film.pixels[i].alpha, of_fast += share * film.pixels[i].alpha;
    }
  }
  ASSERT_GT(collided, 5000);
  EXPECT_NEAR(of_fast / collided, 2.0 / 3, 4 * std::sqrt(2.0 / 9 / collided));
  s.surfaces = {BallSurface{.centre = {20, 16, 18}, .radius = 200}};
  s.camera.position = {20, 16, 600}, s.camera.target = {20, 16, 18};
  const int hits =
      for_hits(render(fast, s).film, [](Vec3d velocity, Vec3d) { EXPECT_EQ(velocity, Vec3d{}); });
  EXPECT_GT(hits, 20);
}

/// A ball of which some lies elsewhere: the boxes of both overlap, and they themselves do not.
const Field& ball() {
  static const Field f = make_field("ball", {-8, -8, -8}, {17, 17, 17}, [](Vec3i p) {
    return std::max(0.0, 1 - length(Vec3d(p)) / 8);
  });
  return f;
}

/// Looks along the z axis past all that lies beside a line.
CloudScene looking_at(Vec3d place) {
  CloudScene s = told({0, 0});
  s.options.width = s.options.height = 1;
  s.options.samples = 64;
  s.camera = Camera{place + Vec3d(0, 0, 500), place};
  s.camera.fov = 1e-3;
  s.medium.extinction = 1;
  return s;
}

TEST(VelocityLayer, IsThatOfThePlaceThatWasHit) {
  const Vec3d beside(10, 10, 0);
  CloudScene s = looking_at(beside);
  const std::vector<MovingPlace> places{
      place_of(MovingMap{}, MovingMap{}),
      place_of(between(moved(beside), moved(beside + Vec3d(3, 0, 0))), MovingMap{})};
  const int hits = for_hits(render(moving(ball(), s, places), s).film, [&](Vec3d velocity, Vec3d) {
    EXPECT_LT(length(velocity - Vec3d(3, 0, 0)), 1e-5);
  });
  EXPECT_EQ(hits, 1);
}

/// Normals are those of the density as it lies while the shutter is open.
TEST(VelocityLayer, NormalsOfWhatHasFlownAreThoseOfItsNewPlace) {
  const Vec3d flown(40, 0, 0);
  CloudScene s = looking_at(flown + Vec3d(4, 0, 0));
  s.camera.shutter = {1, 1.001};
  s.options.aovs = {Aov::normal, Aov::position};
  s.medium.extinction = 20;
  const Pyramid p = build_pyramid(ball().grid);
  const Volume v = make_moving(make_volume(ball().grid, p, s), p, ball().grid.index_to_world,
                               {everywhere(flown), 1, s.camera.shutter}, s.volume_options());
  const Film film = render(v, s).film;
  ASSERT_GT(film.pixels[0].alpha, 60);
  const Vec3d normal = value(film.layers[1], film, 0), at = value(film.layers[0], film, 0);
  ASSERT_EQ(film.layers[1].name, "normal");
  EXPECT_GT(dot(normalize(normal), normalize(at - flown)), 0.98) << normal.x << ' ' << normal.z;
}

}  // namespace velocity_layer_test
}  // namespace pvol::test
