#include "pvol/render/denoise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "pvol/error.h"
#include "support/known_film.h"
#include "support/messages.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace denoise_test {

double root_mean(const std::vector<Vec3d>& squares) {
  double sum = 0;
  for (const Vec3d& v : squares) sum += v.x;
  return std::sqrt(sum / double(squares.size()));
}

double mean_light(const Denoised& d) {
  double sum = 0;
  for (const Vec3d& c : d.colour) sum += c.x;
  return sum / double(d.colour.size());
}

TEST(Denoise, AveragesOverTheWindowWhereNothingDiffers) {
  const Truth t;
  for (const int window : {3, 6}) {
    const Denoised d = denoise(make(t), {.window = window});
    const double before = t.noise / std::sqrt(t.samples);
    // Planes through all pixels of a window have three unknowns; weights differ by noise.
    const double best = before / (2 * window + 1);
    EXPECT_LT(error(t, d.colour), 2 * best) << window;
    EXPECT_GT(error(t, d.colour), 0.3 * best) << window;
  }
}

TEST(Denoise, KeepsAnEdgeThatTheColourShows) {
  Truth t;
  t.light = [](int x, int) { return x < 24 ? 1.0 : 2.0; };
  const Denoised d = denoise(make(t));
  const auto at_edge = [](int x, int) { return std::abs(x - 24) < 3; };
  EXPECT_LT(error(t, d.colour, at_edge), 0.5 * error(t, means(make(t)), at_edge));
  EXPECT_LT(error(t, d.colour), 0.3 * error(t, means(make(t))));
}

/// Noise hides the edge from the weights: only a feature tells of it.
TEST(Denoise, KeepsAnEdgeThatAFeatureShows) {
  Truth t;
  t.noise = 4;
  t.light = [](int x, int) { return x < 24 ? 3.0 : 4.0; };
  const auto at_edge = [](int x, int) { return std::abs(x - 24) < 4; };
  const double without = error(t, denoise(make(t)).colour, at_edge);
  for (const char* name : {"alpha", "depth", "normal", "albedo"}) {
    Film film = make(t);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      if (i % 48 < 24) continue;
      if (name == std::string("alpha")) film.pixels[i].alpha *= 0.5;
      for (Layer& l : film.layers) {
        if (l.name == name) l.sums[i] *= 0.5;
      }
    }
    const double with = error(t, denoise(film).colour, at_edge);
    EXPECT_LT(with, 0.6 * without) << name;
    EXPECT_LT(with, 0.5 * error(t, means(make(t)), at_edge)) << name;
  }
}

/// Where a half chose its own neighbours, a pixel that is bright by chance would find none.
TEST(Denoise, TakesWeightsFromTheOtherHalf) {
  const Truth t;
  Film film = make(t);
  const std::size_t at = film.index(20, 20);
  film.layers[0].sums[at] += Vec3d(10, 20, 5) * film.layers[0].weights[at];
  EXPECT_LT(denoise(film).colour[at].x, 2);
}

TEST(Denoise, ReproducesWhatIsLinearInFeatures) {
  Truth t;
  t.noise = 0.02;
  t.width = 46;  // features are even at the edges, where they are smoothed from one side
  t.depth = [](int x, int y) { return 5 + std::cos(0.7 * x) + std::cos(0.9 * y); };
  t.light = [&](int x, int y) { return 1 + 0.2 * t.depth(x, y) + 0.03 * x + 0.04 * y; };
  const Denoised d = denoise(make(t), {.bandwidth = 40});
  EXPECT_LT(error(t, d.colour), 0.01) << "the window spans 0.5 in light";
  // Windows are cut in half there.
  EXPECT_LT(error(t, d.colour, [](int x, int) { return x == 0; }), 0.015);
  EXPECT_LT(error(t, d.colour, [](int, int y) { return y == 0; }), 0.015);
  EXPECT_LT(error(t, d.colour, [](int x, int) { return x == 45; }), 0.02);
  EXPECT_LT(error(t, d.colour, [](int, int y) { return y == 39; }), 0.02);
}

TEST(Denoise, SpreadsRareBrightSamplesWithoutLosingLight) {
  Truth t;
  t.width = t.height = 96;
  t.rare = 0.02;
  const Denoised d = denoise(make(t));
  const double before = error(t, means(make(t)));
  EXPECT_LT(error(t, d.colour), 0.2 * before);
  double sum = 0;
  for (const Vec3d& c : d.colour) sum += c.x;
  double noisy = 0;
  for (const Vec3d& c : means(make(t))) noisy += c.x;
  EXPECT_NEAR(sum / noisy, 1, 0.02);
}

TEST(Denoise, GivesNoNegativeLight) {
  Truth t;
  t.light = [](int, int) { return 0.0; };
  const Denoised d = denoise(make(t));
  for (const Vec3d& c : d.colour) ASSERT_GE(min_component(c), 0);
}

TEST(Denoise, LeavesWhatHasNoNoise) {
  Truth t;
  t.noise = 0;
  t.light = [](int x, int y) { return 1 + 0.5 * std::sin(x * y); };
  const Film film = make(t);
  const Denoised d = denoise(film);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    ASSERT_NEAR(d.colour[i].x, mean(film.pixels[i]).x, 1e-6);
  }
  EXPECT_LT(d.relative_error, 1e-4);
}

TEST(Denoise, LeavesPixelsFarFromCollisionsAlone) {
  Truth t;
  t.alpha = [](int x, int) { return x < 10 ? 0.0 : 1.0; };
  const Film film = make(t);
  const Denoised d = denoise(film);
  int others = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const bool same = d.colour[i] == mean(film.pixels[i]);
    if (int(i) % t.width < 8) {
      ASSERT_TRUE(same);
      ASSERT_EQ(d.mse[i], variance_of_mean(film.pixels[i]));
    } else {
      others += !same;
    }
  }
  EXPECT_EQ(others, (t.width - 8) * t.height);
}

/// In thin smoke few samples collide: pixels that had none are too dark by chance, and have no
/// features.
TEST(Denoise, TakesPixelsWithoutCollisionsAmongOthersForOneOfThem) {
  Truth t;
  t.width = t.height = 96;
  t.rare = 0.02;
  t.samples = 16;
  Film film = make(t);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    PixelSums& p = film.pixels[i];
    p.alpha = p.sum.x > 0 ? 1 : 0;
    for (std::size_t k = 2; k < film.layers.size(); ++k) {
      Layer& l = film.layers[k];
      // Near or far, and differing by chance.
      const double off = i % 96 < 48 ? 1 : 2;
      l.sums[i] = p.alpha * (Vec3d(off) + 0.02 * Vec3d(std::sin(double(i))));
      l.weights[i] = p.alpha;
    }
  }
  double before = 0, after = 0;
  for (const Vec3d& c : means(film)) before += c.x;
  const Denoised d = denoise(film);
  for (const Vec3d& c : d.colour) after += c.x;
  EXPECT_NEAR(after / before, 1, 0.03);
  EXPECT_LT(error(t, d.colour), 0.25 * error(t, means(film)));
}

TEST(Denoise, EstimatesItsError) {
  Truth bumpy;
  bumpy.width = bumpy.height = 96;
  bumpy.light = [](int x, int y) { return 2 + std::sin(0.5 * x) * std::sin(0.4 * y); };
  Truth even = bumpy;
  even.light = [](int, int) { return 1.0; };
  Truth steps = bumpy;
  steps.light = [](int x, int y) { return (x / 6 + y / 6) % 2 ? 1.0 : 1.3; };
  const Denoised calm = denoise(make(even));
  const double ratio = root_mean(calm.variance) / error(even, calm.colour);
  EXPECT_NEAR(ratio, 1, 0.2) << "all of the error is variance";
  for (const Truth& t : {bumpy, even, steps}) {
    const Denoised d = denoise(make(t));
    const double of = error(t, d.colour), estimated = root_mean(d.mse);
    const double whole = d.relative_error * mean_light(d);
    EXPECT_LT(whole, 2 * of);
    EXPECT_GT(whole, 0.5 * of);
    EXPECT_LT(estimated, 2 * of);
    EXPECT_GT(estimated, 0.5 * of);
    EXPECT_LE(root_mean(d.variance), estimated);
  }
}

TEST(Denoise, GivesTheSameBytesForAnyNumberOfThreads) {
  Truth t;
  t.width = 101, t.height = 67;
  t.light = [](int x, int y) { return 1 + 0.5 * std::sin(0.1 * x * y); };
  const Film film = make(t);
  const Denoised one = denoise(film, {.threads = 1});
  for (const int threads : {2, 7}) {
    const Denoised many = denoise(film, {.threads = threads});
    EXPECT_EQ(many.colour, one.colour);
    EXPECT_EQ(many.variance, one.variance);
    EXPECT_EQ(many.mse, one.mse);
  }
}

TEST(Denoise, DoesNotDependOnTheUnitOfLight) {
  const Film film = make({});
  const Denoised a = denoise(film);
  for (const double unit : {0x1p100, 0x1p-100}) {
    Film other = film;
    for (PixelSums& p : other.pixels) p.sum *= unit, p.sum_squares *= unit * unit;
    for (int half : {0, 1}) {
      for (Vec3d& v : other.layers[std::size_t(half)].sums) v *= unit;
    }
    const Denoised b = denoise(other);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      ASSERT_EQ(a.colour[i] * unit, b.colour[i]);
      ASSERT_EQ(a.mse[i] * (unit * unit), b.mse[i]);
    }
  }
}

TEST(Denoise, TakesPicturesOfAnySize) {
  for (const int width : {1, 2, 33}) {
    for (const int height : {1, 7, 32}) {
      Truth t;
      t.width = width, t.height = height;
      const Denoised d = denoise(make(t));
      EXPECT_LT(error(t, d.colour), 0.5) << width << " x " << height;
    }
  }
  EXPECT_TRUE(denoise(make({.width = 0, .height = 0})).colour.empty());
}

std::string refusal(const Film& film, const DenoiseOptions& o = {}) {
  try {
    (void)denoise(film, o);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Denoise, RefusesFilmsThatLackSomethingByName) {
  const Film film = make({});
  const char* const needed[] = {"halves", "halves", "depth", "normal", "albedo"};
  for (std::size_t i = 0; i < film.layers.size(); ++i) {
    Film less = film;
    less.layers.erase(less.layers.begin() + std::ptrdiff_t(i));
    EXPECT_NE(refusal(less).find(std::string("--aov ") + needed[i]), std::string::npos)
        << refusal(less);
  }
  Film few = film;
  few.pixels[7].samples = 1;
  EXPECT_TRUE(says(refusal(few), "denoise.pixel_fewer_two"));
  Film broken = film;
  broken.pixels[7].sum.y = NAN;
  EXPECT_TRUE(says(refusal(broken), "denoise.pixel_not_finite"));
}

TEST(Denoise, RefusesOptionsOutOfRange) {
  const Film film = make({.width = 4, .height = 4});
  for (const DenoiseOptions& o : {DenoiseOptions{.window = 0},
                                  {.window = 33},
                                  {.patch = -1},
                                  {.patch = 9},
                                  {.bandwidth = 0},
                                  {.bandwidth = NAN},
                                  {.threads = -1}}) {
    EXPECT_NE(refusal(film, o), "");
  }
}

TEST(Denoise, KeepsTheNoisyPictureBesideTheFilteredOne) {
  const Film film = make({});
  const Denoised d = denoise(film);
  const Film both = with_colour(film, d);
  ASSERT_EQ(both.layers.size(), film.layers.size() + 2);
  const Layer& noisy = both.layers[film.layers.size()];
  const Layer& variance = both.layers[film.layers.size() + 1];
  EXPECT_EQ(noisy.name, "noisy");
  EXPECT_EQ(variance.name, "noisy_variance");
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const PixelSums& p = film.pixels[i];
    ASSERT_EQ(value(noisy, both, i), mean(p));
    ASSERT_NEAR(value(variance, both, i).x, variance_of_mean(p).x, 1e-12);
    ASSERT_NEAR(mean(both.pixels[i]).x, d.colour[i].x, 1e-12);
    ASSERT_NEAR(variance_of_mean(both.pixels[i]).x, d.mse[i].x, 1e-9);
    ASSERT_EQ(both.pixels[i].alpha, p.alpha);
    ASSERT_EQ(both.pixels[i].samples, p.samples);
  }
}

/// On a real picture, against many samples: less error, and hardly other light.
TEST(Denoise, ComesNearerToACloud) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 64;
  s.options.samples = proof::samples(1024);
  s.options.seed = 77;
  const Film reference = run(cloud(), s).film;
  s.options.samples = 16;
  s.options.aovs = denoising_aovs();
  double noisy = 0, filtered = 0, estimated = 0, light = 0, difference = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    s.options.seed = seed;
    const Film film = run(cloud(), s).film;
    const Denoised d = denoise(film);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const double truth = mean(reference.pixels[i]).y;
      const double known = variance_of_mean(reference.pixels[i]).y;
      noisy += std::pow(mean(film.pixels[i]).y - truth, 2) - known;
      filtered += std::pow(d.colour[i].y - truth, 2) - known;
      estimated += d.mse[i].y;
      light += mean(film.pixels[i]).y, difference += d.colour[i].y - mean(film.pixels[i]).y;
    }
  }
  RecordProperty("gain", std::to_string(std::sqrt(noisy / filtered)));
  EXPECT_LT(filtered, noisy / 4);
  EXPECT_LT(estimated, 4 * filtered);
  EXPECT_GT(estimated, filtered / 4);
  EXPECT_LT(std::abs(difference), 0.01 * light);
}

}  // namespace denoise_test
}  // namespace pvol::test
