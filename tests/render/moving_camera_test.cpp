// Cameras that move while the shutter is open: against closed forms and what stands still.
#include <gtest/gtest.h>

#include <cmath>

#include "pvol/error.h"
#include "pvol/render/render.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/fields.h"
#include "support/lit_scenes.h"
#include "support/messages.h"
#include "support/pictures.h"

namespace pvol::test {
namespace moving_camera_test {

constexpr double kDegree = 3.14159265358979 / 180;

/// From where the sunny cloud is seen, turning by 50 degrees in a frame and coming nearer.
Camera passing(Shutter shutter) {
  Camera c{.position = {90, 20, 70}, .target = {20, 16, 18}, .shutter = shutter};
  c.to = CameraPlace{{60, 30, 90}, {0, 30, 18}, {0.3, 1, 0}};
  return c;
}

TEST(MovingCamera, IsWhereItIsToldAtBothFrames) {
  const Camera c = passing({-0.5, 0.5});
  const auto expect_like = [](const Camera& a, const CameraPlace& b) {
    EXPECT_LT(length(a.position - b.position), 1e-12);
    const Vec3d view = normalize(b.target - b.position);
    EXPECT_LT(length(normalize(a.target - a.position) - view), 1e-12);
    EXPECT_LT(length(normalize(cross(a.target - a.position, a.up)) - normalize(cross(view, b.up))),
              1e-12);
  };
  expect_like(camera_at(c, 0), {c.position, c.target, c.up});
  expect_like(camera_at(c, 1), *c.to);
  const Camera half = camera_at(c, 0.5);
  EXPECT_LT(length(half.position - (c.position + c.to->position) * 0.5), 1e-12);
  EXPECT_NEAR(length(half.target - half.position), length(c.target - c.position), 1e-12)
      << "the focus moves along";
  // Half the turn is half the angle, about the same axis.
  const auto turn = [](const Camera& from, const Camera& to) {
    return std::acos(
        dot(normalize(from.target - from.position), normalize(to.target - to.position)));
  };
  const Camera quarter = camera_at(c, 0.25), start = camera_at(c, 0);
  EXPECT_NEAR(turn(start, quarter), turn(quarter, half), 0.05);
  EXPECT_FALSE(half.to);
}

TEST(MovingCamera, AnInstantIsTheStillPictureWithAllItsLayers) {
  CloudScene s = sunny();
  for (const AovRow& r : kAovs) s.options.aovs.add(r.aov);
  const Volume v = volume_of(s);
  for (const double time : {0.0, 0.7, -1.2}) {
    s.camera = passing({time, time});
    CloudScene still = s;
    still.camera = camera_at(s.camera, time);
    const Film a = render(v, s).film, b = render(v, still).film;
    EXPECT_TRUE(same_bytes(a, b)) << time;
    EXPECT_GT(average(a).mean.x, 0.1);
    for (std::size_t i = 0; i < a.layers.size(); ++i) {
      EXPECT_TRUE(a.layers[i].sums == b.layers[i].sums) << a.layers[i].name;
    }
  }
}

TEST(MovingCamera, IsTheMeanOfPicturesOverTheShutter) {
  proof::Family family;
  for (const bool lens : {false, true}) {
    CloudScene s = sunny();
    const Volume v = volume_of(s);
    s.camera = passing({-0.25, 0.5});
    if (lens) s.camera.f_stop = 0.02, s.camera.focus_distance = 60;
    s.options.samples = proof::samples(2048);
    const Film blurred = render(v, s).film;
    const Film sum = over_shutter(s.camera.shutter, 32, [&](double time, std::uint64_t seed) {
      CloudScene still = s;
      still.camera = camera_at(s.camera, time);
      still.options.samples = proof::samples(64u), still.options.seed = seed;
      return render(v, still).film;
    });
    compare(blurred, sum, lens ? "through a lens" : "sharp", family);
  }
  EXPECT_TRUE(family.passes());
}

/// A cube of optical depth 2 that a camera far away passes, as it would pass the camera.
TEST(MovingCamera, PassesTheEdgeOfACubeAsTheClosedFormSays) {
  proof::Family family;
  for (const Shutter shutter : {Shutter{-0.5, 0.5}, Shutter{0, 0.75}}) {
    for (const double place : {15.2, 8.0, -2.5}) {
      CloudScene s;
      s.medium.extinction = 0.125;
      s.medium.albedo = Rgb(0.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      s.lights.clear();
      constexpr double kSpeed = 13;
      s.camera = {
          .position = {8, place, 1e5}, .target = {8, place, 0}, .fov = 1e-9, .shutter = shutter};
      s.camera.to = CameraPlace{{8, place + kSpeed, 1e5}, {8, place + kSpeed, 0}, {0, 1, 0}};
      s.options.width = s.options.height = 4;
      s.options.samples = proof::samples(8192);
      const Field block = make_field("block", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
      const Volume v = make_volume(block.grid, build_pyramid(block.grid), s);
      double expected = 0;
      constexpr int kSteps = 20'000;
      for (int i = 0; i < kSteps; ++i) {
        const double y = place + kSpeed * shutter.at((i + 0.5) / kSteps);
        const double depth = 0.125 * 16 * std::clamp(std::min(y + 1, 16 - y), 0.0, 1.0);
        expected += std::exp(-depth) / kSteps;
      }
      compare(average(render(v, s).film), {Vec3d(expected), Vec3d(1e-14)},
              "at " + std::to_string(place), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// White surfaces and clouds in white light are white from everywhere, with whatever else moves.
TEST(MovingCamera, EveryPixelOfTheFurnaceIsTheSky) {
  for (const CameraKind kind :
       {CameraKind::perspective, CameraKind::orthographic, CameraKind::latlong}) {
    for (const bool many : {false, true}) {
      CloudScene s = sunny();
      s.medium.albedo = Rgb(1.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      s.lights.clear();
      s.options.samples = 16;
      const Volume v = volume_of(s);
      s.camera = passing({-0.5, 0.5});
      s.camera.kind = kind, s.camera.ortho_scale = 50;
      if (many)
        s.surfaces = {
            BallSurface{.centre = {60, 16, 18}, .radius = 9, .material = {.albedo = Rgb(1.0f)}}};
      const std::vector<Volume> volumes(many ? 2 : 1, v);
      double hits = 0;
      for (const PixelSums& p : render(volumes, s).film.pixels) {
        EXPECT_NEAR(mean(p).x, 1, 1e-6);
        hits += p.alpha;
      }
      EXPECT_GT(hits, 10);
    }
  }
}

/// Depths are along the axis of the camera in the middle of the shutter, so they are linear in the
/// positions, and their means are exact.
TEST(MovingCamera, DepthsAreAlongTheAxisInTheMiddle) {
  CloudScene s = sunny();
  s.options.aovs = {Aov::depth, Aov::position};
  const Volume v = volume_of(s);
  s.camera = passing({0, 0.5});
  const Camera middle = camera_at(s.camera, 0.25);
  const Vec3d axis = normalize(middle.target - middle.position);
  const Film film = render(v, s).film;
  int hits = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    if (film.pixels[i].alpha == 0) continue;
    const Vec3d at = value(film.layers[1], film, i);
    EXPECT_NEAR(value(film.layers[0], film, i).x, dot(at - middle.position, axis), 1e-6);
    ++hits;
  }
  EXPECT_GT(hits, 50);
}

/// Depths of deep pictures are from the camera as it stands at a sample's time: what moves along
/// keeps its depth, and nothing is behind the camera.
TEST(MovingCamera, DeepPicturesHaveDepthsAtTheSamplesTimes) {
  CloudScene s = sunny();
  s.options.deep = true;
  const Volume v = volume_of(s);
  s.camera = Camera{.position = {0, 0, 100}, .target = {0, 0, 0}, .shutter = {-0.5, 0.5}};
  s.surfaces = {BallSurface{.centre = {0, 0, 70}, .radius = 9}};
  const auto depths = [&] {
    std::vector<double> all;
    const Film film = render(v, s).film;
    for (const auto& pixel : film.deep.surfaces) {
      double last = 0;
      for (const DeepSurface& surface : pixel) {
        const double depth = surface.depth / double(surface.count);
        EXPECT_GT(depth, last) << "in order, and before the camera";
        all.push_back(last = depth);
      }
    }
    return all;
  };
  const std::vector<double> still = depths();
  ASSERT_GT(still.size(), 10u);
  auto& ball = std::get<BallSurface>(s.surfaces[0]);
  s.camera.to = CameraPlace{{0, 0, 40}, {0, 0, -60}};
  ball.to = BallPlace{{0, 0, 10}};
  const std::vector<double> along = depths();
  ASSERT_EQ(along.size(), still.size());
  for (std::size_t i = 0; i < still.size(); ++i) EXPECT_NEAR(along[i], still[i], 1e-6 * still[i]);
  // The camera passes the ball, which stands still.
  ball.to.reset();
  EXPECT_GT(depths().size(), still.size());
}

/// Their bins reach no further than a cloud may lie, with little room for times in between.
TEST(MovingCamera, DeepPicturesReachAsFarAsVolumesMayLie) {
  CloudScene s = sunny();
  s.options.deep = true;
  const Volume v = volume_of(s);
  const Box box = world_box({&v, 1});
  s.camera = Camera{.position = {0, 0, 200}, .target = {0, 0, 0}, .shutter = {-0.5, 0.5}};
  s.camera.to = CameraPlace{{0, 0, 300}, {0, 0, 0}};
  const DeepFilm deep = render(v, s).film.deep;
  constexpr double kRoom = 2 * 100 / 16.0;
  EXPECT_LE(deep.front, 150 - box.hi.z);
  EXPECT_GE(deep.front, 150 - box.hi.z - kRoom);
  EXPECT_GE(deep.back, 250 - box.lo.z);
  EXPECT_LE(deep.back, 250 - box.lo.z + kRoom);
}

TEST(MovingCamera, RefusesAWayThatIsNotOne) {
  const auto refusal = [](const CameraPlace& to) {
    Camera c{.position = {0, 0, 5}, .target = {0, 0, 0}};
    c.to = to;
    return error_of([&] { validate(c); });
  };
  EXPECT_TRUE(says(refusal({{0, 0, 5}, {0, 0, 10}, {0, 1, 0}}), "moving_camera.half_turn"));
  EXPECT_TRUE(says(refusal({{0, 0, 5}, {0, 0, 5}, {0, 1, 0}}), "moving_camera.way_without_target"));
  EXPECT_TRUE(says(refusal({{0, 0, 5}, {0, 3, 5}, {0, 1, 0}}), "moving_camera.way_along_up"));
  EXPECT_EQ(refusal({{0, 0, 5}, {1, 0, 5}, {0, 1, 0}}), "");
}

TEST(MovingCamera, ThePlanSaysHowFarItMoves) {
  CloudScene s = sunny();
  const Volume v = volume_of(s);
  s.camera = passing({-0.25, 0.25});
  const auto reason = [&] {
    for (const Decision& d : plan(std::span(&v, 1), s.scene()).decisions) {
      if (d.what == "camera") return d.choice + ": " + d.reason;
    }
    return std::string();
  };
  const std::string said = reason();
  ASSERT_TRUE(said.starts_with("moves: by ")) << said;
  const double way = length(s.camera.to->position - s.camera.position) / 2;
  EXPECT_NEAR(std::stod(said.substr(10)), way, 0.01);
  const Vec3d view = normalize(s.camera.target - s.camera.position);
  const Vec3d later = normalize(s.camera.to->target - s.camera.to->position);
  const double degrees = std::stod(said.substr(said.find(" and ") + 5));
  EXPECT_GE(degrees, std::acos(dot(view, later)) / kDegree / 2 - 0.01) << "and it rolls";
  EXPECT_LT(degrees, 30);
  s.camera.shutter = {};
  EXPECT_TRUE(reason().starts_with("stands still: "));
  s.camera.to.reset();
  EXPECT_EQ(reason(), "");
}

}  // namespace moving_camera_test
}  // namespace pvol::test
