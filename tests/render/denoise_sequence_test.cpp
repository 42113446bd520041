// The filter over frames of a sequence, on films of known expectation.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/render/denoise.h"
#include "support/error_of.h"
#include "support/known_film.h"
#include "support/messages.h"

namespace pvol::test {
namespace denoise_sequence_test {

struct Frame {
  Truth truth;
  Film film;
  FilterFrame ready;

  explicit Frame(Truth t, const std::optional<Camera>& camera = std::nullopt,
                 const DenoiseOptions& o = {}, double time = 0)
      : truth(std::move(t)), film(make(truth)), ready(film, camera, o, time) {}
};

/// One of the frames, filtered with all others.
Denoised filter(const std::vector<Frame>& frames, std::size_t which) {
  std::vector<FilterFrame> others;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i != which) others.push_back(frames[i].ready);
  }
  return denoise(frames[which].film, frames[which].ready, others);
}

/// As many frames of a picture that does not move.
std::vector<Frame> still(Truth t, int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    t.seed = unsigned(i + 1);
    frames.emplace_back(t);
  }
  return frames;
}

double difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i].x - b[i].x) * (a[i].x - b[i].x);
  return std::sqrt(sum / double(a.size()));
}

TEST(DenoiseSequence, LeavesAFifthOfTheFlickerOfFiveFrames) {
  Truth t;
  t.light = [](int x, int y) { return 2 + std::cos(0.4 * x) * std::cos(0.3 * y); };
  const std::vector<Frame> frames = still(t, 6);
  const std::vector<Frame> first(frames.begin(), frames.end() - 1);
  const std::vector<Frame> second(frames.begin() + 1, frames.end());
  const Denoised a = filter(first, 2), b = filter(second, 2);
  const Denoised alone_a = denoise(frames[2].film), alone_b = denoise(frames[3].film);
  // Means of five frames of which four are the same differ by a fifth of what two frames do.
  const double flicker = difference(a.colour, b.colour);
  EXPECT_LT(flicker, 0.3 * difference(alone_a.colour, alone_b.colour));
  EXPECT_LT(error(t, a.colour), 0.65 * error(t, alone_a.colour));
  // What is left is told as well as it is of one frame.
  EXPECT_NEAR(a.relative_error / alone_a.relative_error,
              error(t, a.colour) / error(t, alone_a.colour), 0.3);
}

TEST(DenoiseSequence, IsTheFilterOfOneFrameWithoutOthers) {
  const Frame f{Truth{}};
  const Denoised one = denoise(f.film), same = denoise(f.film, f.ready, {});
  for (std::size_t i = 0; i < one.colour.size(); ++i) {
    ASSERT_EQ(one.colour[i], same.colour[i]);
    ASSERT_EQ(one.mse[i], same.mse[i]);
  }
}

/// A wall at depth 5, seen by a camera that moves along it by so many pixels a frame.
std::vector<Frame> pan(Camera camera, double pixels, int count, bool known) {
  std::vector<Frame> frames;
  Truth t;
  t.width = 96;
  const double pixel = 5 * 2 * half_height(camera, 96.0 / 40) / 40;  // of the wall
  for (int i = 0; i < count; ++i) {
    const double moved = pixels * (i - count / 2);
    t.light = [moved](int x, int y) {
      return 2 + std::cos(0.25 * (x + moved)) * std::cos(0.3 * y) +
             0.5 * std::cos(0.9 * (x + moved));
    };
    t.seed = unsigned(i + 1);
    camera.position = {moved * pixel, 0, 5}, camera.target = {moved * pixel, 0, 0};
    frames.emplace_back(t, known ? std::optional(camera) : std::nullopt);
  }
  return frames;
}

TEST(DenoiseSequence, FollowsTheCamera) {
  const auto error_of = [](const std::vector<Frame>& frames) {
    return error(frames[2].truth, filter(frames, 2).colour);
  };
  const Camera camera;
  const std::vector<Frame> still = pan(camera, 0, 5, true), fast = pan(camera, 17, 5, true);
  const double alone = error(still[2].truth, denoise(still[2].film).colour);
  EXPECT_LT(error_of(still), 0.65 * alone);
  // Of frames two steps away a third is out of the picture.
  EXPECT_LT(error_of(fast), 1.3 * error_of(still));
  EXPECT_GT(error_of(pan(camera, 17, 5, false)), 1.2 * error_of(still))
      << "without cameras nothing is found that far away";
}

/// A wall at depth 5 that slides by so many pixels a frame, twice as fast below the middle, before
/// a camera that goes along with the slower half or stands still.
std::vector<Frame> slide(double pixels, bool follows, bool told) {
  std::vector<Frame> frames;
  Truth t;
  t.width = 96, t.noise = 0.7;
  Camera camera;
  const double pixel = 5 * 2 * half_height(camera, 96.0 / 40) / 40;  // of the wall
  const auto speed = [](int y) { return y < 20 ? 1 : 2; };
  if (told) t.velocity = [=](int, int y) { return Vec3d(-pixels * pixel * speed(y), 0, 0); };
  for (int i = 0; i < 5; ++i) {
    const double moved = pixels * (i - 2);
    t.light = [=](int x, int y) {
      const double at = x + moved * (speed(y) - (follows ? 1 : 0));
      return 2 + std::cos(0.25 * at) * std::cos(0.3 * y) + 0.5 * std::cos(0.9 * at);
    };
    t.seed = unsigned(i + 1);
    const double x = follows ? -moved * pixel : 0;
    camera.position = {x, 0, 5}, camera.target = {x, 0, 0};
    frames.emplace_back(t, camera, DenoiseOptions{}, i);
  }
  return frames;
}

TEST(DenoiseSequence, FollowsWhatMoves) {
  const auto error_of = [](const std::vector<Frame>& frames) {
    const auto away_from_the_edge = [](int, int y) { return y < 14 || y > 26; };
    return error(frames[2].truth, filter(frames, 2).colour, away_from_the_edge);
  };
  const double at_rest = error_of(slide(0, false, true));
  for (const bool follows : {false, true}) {
    const double told = error_of(slide(11, follows, true));
    EXPECT_LT(told, 1.25 * at_rest) << follows;
    EXPECT_GT(error_of(slide(11, follows, false)), 1.2 * told)
        << "velocities that are not told are not known";
  }
}

/// Of a picture of which a part was rendered, far from the middle, about which the camera turns.
TEST(DenoiseSequence, FollowsTheCameraInACrop) {
  std::vector<Film> films;
  std::vector<FilterFrame> ready;
  Truth t;
  for (const int i : {-1, 1, 0}) {
    const double turn = 0.08 * i, c = std::cos(turn), s = std::sin(turn);
    t.light = [c, s](int x, int y) {
      const double right = x + 400 - 249.5, down = y + 230 - 249.5;
      return 3 + std::cos(0.35 * (right * c - down * s)) + std::cos(0.3 * (right * s + down * c));
    };
    t.seed = unsigned(i + 2);
    Film& film = films.emplace_back(make(t));
    film.width = film.height = 500, film.x = 400, film.y = 230;
    ready.emplace_back(film, Camera{.target = {0, 0, -5}, .up = {s, c, 0}});
  }
  const Denoised d = denoise(films[2], ready[2], std::vector{ready[0], ready[1]});
  const auto shared = [](int, int y) { return y > 14 && y < 26; };
  EXPECT_LT(error(t, d.colour, shared), 0.8 * error(t, denoise(films[2]).colour, shared));
}

/// Depth is told from a camera that moves: the same points are at other depths.
TEST(DenoiseSequence, TakesDepthsFromItsOwnCamera) {
  const auto frames_of = [](double step) {
    std::vector<Frame> frames;
    for (int i = 0; i < 3; ++i) {
      Truth t;
      const double nearer = step * i;
      t.noise = 0.2, t.seed = unsigned(i + 1);
      const auto hills = [](int x, int y) { return std::cos(1.3 * x) + std::cos(1.1 * y); };
      t.depth = [=](int x, int y) { return 8 + hills(x, y) - nearer; };
      t.light = [=](int x, int y) { return 3 + hills(x, y); };
      const Camera camera{.position = {0, 0, 8 - nearer},
                          .target = {0, 0, -10},
                          .kind = CameraKind::orthographic,
                          .ortho_scale = 3};
      frames.emplace_back(t, camera, DenoiseOptions{.bandwidth = 40});
    }
    return frames;
  };
  const std::vector<Frame> at_rest = frames_of(0), dolly = frames_of(2);
  EXPECT_LT(error(dolly[2].truth, filter(dolly, 2).colour),
            1.05 * error(at_rest[2].truth, filter(at_rest, 2).colour));
}

/// A flash beside what stays as it is: the mean light of the frames, and their features, differ.
TEST(DenoiseSequence, TakesNothingFromWhatChanged) {
  std::vector<Frame> frames;
  for (int i = 0; i < 3; ++i) {
    Truth t;
    t.seed = unsigned(i + 1);
    t.light = [i](int x, int) { return x < 24 || i == 1 ? 2.0 : 6.0; };
    t.depth = [i](int x, int) { return x < 24 || i == 1 ? 5.0 : 50.0; };
    frames.emplace_back(t);
  }
  const Denoised with = filter(frames, 1), alone = denoise(frames[1].film);
  const auto same = [](int x, int) { return x < 18; };
  const auto changed = [](int x, int) { return x >= 24; };
  const Truth& t = frames[1].truth;
  EXPECT_LT(error(t, with.colour, same), 0.8 * error(t, alone.colour, same));
  EXPECT_LT(error(t, with.colour, changed), 1.05 * error(t, alone.colour, changed));
}

TEST(DenoiseSequence, FiltersPartsThatSumUpToThePicture) {
  const auto part = [](int x, int) { return 0.4 + 0.1 * std::sin(0.1 * x); };
  std::vector<Film> films;
  std::vector<FilterFrame> ready;
  Truth t;
  for (int i = 0; i < 5; ++i) {
    t.seed = unsigned(i + 1);
    add_parts(films.emplace_back(make(t)), t, "sky", "sun_1", part);
    ready.emplace_back(films.back());
  }
  const auto error_of = [&](const Denoised& d) {
    double sum = 0;
    for (std::size_t i = 0; i < d.colour.size(); ++i) {
      EXPECT_NEAR(d.layers[0].values[i].x + d.layers[1].values[i].x, d.colour[i].x, 1e-9);
      const int x = int(i) % t.width, y = int(i) / t.width;
      sum += std::pow(d.layers[0].values[i].x - part(x, y), 2);
    }
    return std::sqrt(sum / double(d.colour.size()));
  };
  const std::vector<FilterFrame> others{ready[0], ready[1], ready[3], ready[4]};
  EXPECT_LT(error_of(denoise(films[2], ready[2], others)), 0.7 * error_of(denoise(films[2])));
}

TEST(DenoiseSequence, RefusesFramesThatDiffer) {
  const auto refusal = [](const Film& own, const Film& other) {
    return error_of([&] { (void)denoise(own, FilterFrame(own), std::vector{FilterFrame(other)}); });
  };
  Truth t, wide;
  wide.width = 50;
  EXPECT_TRUE(says(refusal(make(t), make(wide)), "denoise.frames_size"));
  Film aces = make(t);
  aces.color_space = ColorSpace::acescg;
  EXPECT_TRUE(says(refusal(make(t), aces), "denoise.frames_color_space"));
  Film lit = make(t);
  add_parts(lit, t, "sky", "sun_1", [](int, int) { return 0.5; });
  EXPECT_TRUE(says(refusal(make(t), lit), "denoise.frames_layers"));
  EXPECT_TRUE(says(error_of([] { (void)FilterFrame(make({.width = 0})); }), "denoise.no_pixels"));
}

}  // namespace denoise_sequence_test
}  // namespace pvol::test
