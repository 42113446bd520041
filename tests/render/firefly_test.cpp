// What rare bright samples leave in a filtered picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "pvol/render/denoise.h"
#include "render/denoise/fireflies.h"
#include "render/denoise/summed_area.h"
#include "support/known_film.h"

namespace pvol::test {
namespace firefly_test {

/// A hilly cloud before a bright and a dark half, seen with 16 samples.
Truth cloud_truth() {
  Truth t;
  t.width = 96, t.height = 80, t.samples = 16, t.noise = 0.3;
  t.depth = [](int x, int y) { return 5 + std::cos(0.2 * x) + std::cos(0.15 * y); };
  t.light = [](int x, int y) {
    return (x < 48 ? 1.0 : 3.0) * (1 + 0.4 * std::sin(0.2 * x) * std::sin(0.15 * y));
  };
  return t;
}

Vec3d sum_of(const std::vector<Vec3d>& colour) {
  return std::accumulate(colour.begin(), colour.end(), Vec3d{});
}

/// Least and greatest red of a filtered picture, over the truth.
std::pair<double, double> ratios(const Truth& t, const Denoised& d) {
  double least = 1e30, most = 0;
  for (std::size_t i = 0; i < d.colour.size(); ++i) {
    const double r = d.colour[i].x / t.light(int(i) % t.width, int(i) / t.width);
    least = std::min(least, r), most = std::max(most, r);
  }
  return {least, most};
}

TEST(Fireflies, NeitherGlowNorLeaveDarkPixels) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Truth t = cloud_truth();
    t.seed = seed;
    const double without = sum_of(denoise(make(t)).colour).x;
    for (const double times : {30.0, 1000.0, 10000.0}) {
      Film film = make(t);
      const std::vector<std::size_t> bright = add_fireflies(film, t, times, 400);
      const Denoised d = denoise(film);
      // What they have on average is there everywhere.
      const double more = sum_of(d.colour).x / without;
      const auto [least, most] = ratios(t, d);
      EXPECT_GT(least, 0.6) << times;
      EXPECT_LT(most, 2 * std::max(1.0, more)) << times;
    }
  }
}

TEST(Fireflies, KeepTheirLight) {
  const Truth t = cloud_truth();
  for (const double times : {30.0, 1000.0, 10000.0}) {
    Film film = make(t);
    add_fireflies(film, t, times, 400);
    const Vec3d noisy = sum_of(means(film)), filtered = sum_of(denoise(film).colour);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(filtered[c] / noisy[c], 1, 0.01) << times;
  }
}

TEST(Fireflies, AreCounted) {
  const Truth t = cloud_truth();
  Film film = make(t);
  EXPECT_EQ(denoise(film).fireflies, 0u);
  const std::vector<std::size_t> bright = add_fireflies(film, t, 1000, 400);
  ASSERT_GT(bright.size(), 10u);
  EXPECT_EQ(denoise(film).fireflies, bright.size());
}

/// The others are filtered as if there were none, but for the light that comes to them.
TEST(Fireflies, DoNotBlurWhatIsAround) {
  const Truth t = cloud_truth();
  Film film = make(t);
  const Denoised clean = denoise(film);
  add_fireflies(film, t, 1000, 400);
  const Denoised d = denoise(film);
  const double more = sum_of(d.colour).x / sum_of(clean.colour).x;
  std::vector<Vec3d> darker = d.colour;
  for (Vec3d& c : darker) c *= 1 / more;
  EXPECT_LT(error(t, darker), 2 * error(t, clean.colour));
}

/// Of bright pixels that are too many to be fireflies the window's range is left: planes through
/// them fall below zero beside them.
TEST(Fireflies, LeaveEachPixelWithinWhatItsWindowHas) {
  const Truth t = cloud_truth();
  Film film = make(t);
  for (const auto& [x, y] : {std::pair{20, 20}, {60, 30}, {47, 60}}) {
    for (int i = 0; i < 9; ++i) {
      const std::size_t at = film.index(x + i % 3, y + i / 3);
      const Vec3d v(2000, 4000, 1000);
      film.pixels[at].sum += v, film.pixels[at].sum_squares += v * v;
      film.layers[std::size_t(i % 2)].sums[at] += v;
    }
  }
  const DenoiseOptions o;
  const Denoised d = denoise(film, o);
  for (std::size_t at = 0; at < film.pixels.size(); ++at) {
    const int x = int(at) % t.width, y = int(at) / t.width;
    double least = 1e30, most = 0;
    for (int j = std::max(0, y - o.window); j <= std::min(t.height - 1, y + o.window); ++j) {
      for (int i = std::max(0, x - o.window); i <= std::min(t.width - 1, x + o.window); ++i) {
        for (const std::size_t half : {0u, 1u}) {
          const double v = value(film.layers[half], film, film.index(i, j)).x;
          least = std::min(least, v), most = std::max(most, v);
        }
      }
    }
    ASSERT_GT(least, 0);
    ASSERT_GE(d.colour[at].x, least * (1 - 1e-6)) << x << ", " << y;
    ASSERT_LE(d.colour[at].x, most * (1 + 1e-6)) << x << ", " << y;
  }
}

/// Both halves see it, and so do most samples: it is a lamp.
TEST(Fireflies, AreNotWhatMostSamplesSee) {
  Truth t = cloud_truth();
  t.light = [](int x, int y) { return x == 40 && y == 30 ? 100.0 : 1.0; };
  const Film film = make(t);
  const Denoised d = denoise(film);
  EXPECT_EQ(d.fireflies, 0u);
  EXPECT_GT(d.colour[film.index(40, 30)].x, 90);
}

TEST(Fireflies, HaveTheUncertaintyOfTheirLightInTheEstimatedError) {
  const Truth t = cloud_truth();
  const double chance = 1.0 / 400, times = 3000;
  double squares = 0, estimated = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Truth own = t;
    own.seed = seed;
    Film film = make(own);
    add_fireflies(film, own, times, 400);
    const Denoised d = denoise(film);
    Truth bright = t;
    bright.light = [&](int x, int y) { return t.light(x, y) * (1 + chance * times / t.samples); };
    squares += std::pow(error(bright, d.colour), 2);
    for (const Vec3d& m : d.mse) estimated += m.x / double(d.mse.size());
  }
  EXPECT_LT(estimated, 4 * squares);
  EXPECT_GT(estimated, squares / 4);
}

detail::Plane plane(int width, int height, float value) {
  detail::Plane p(width, height, 0);
  for (int y = 0; y < height; ++y) std::fill_n(p.row(y), width, value);
  return p;
}

double total(const detail::Plane& p) {
  double sum = 0;
  for (int y = 0; y < p.height(); ++y) sum = std::accumulate(p.row(y), p.row(y) + p.width(), sum);
  return sum;
}

/// Each half and channel keeps its own sum, in corners too and where little is near.
TEST(Fireflies, KeepTheSumOfEachHalfAndChannel) {
  detail::TwoHalves p;
  for (int c = 0; c < 3; ++c) {
    p.values[0].push_back(plane(60, 40, 1)), p.values[1].push_back(plane(60, 40, 1));
    p.variances.push_back(plane(60, 40, 0));
  }
  detail::Plane where = plane(60, 40, 1);
  for (int y = 0; y < 40; ++y) std::fill_n(where.row(y) + 30, 20, 0.0f);
  const auto brighten = [&](std::size_t half, std::size_t c, int x, int y, float light) {
    p.values[half][c].row(y)[x] = light, p.variances[c].row(y)[x] = light * light;
  };
  brighten(0, 0, 0, 0, 1000), brighten(1, 0, 59, 39, 30), brighten(0, 1, 25, 20, 1e5f);
  brighten(1, 2, 10, 10, 50), brighten(1, 2, 40, 10, 50);
  std::array<std::array<double, 3>, 2> before{};
  for (std::size_t h : {0u, 1u}) {
    for (std::size_t c = 0; c < 3; ++c) before[h][c] = total(p.values[h][c]);
  }
  const detail::Fireflies f = detail::spread_fireflies(p, where);
  EXPECT_EQ(f.pixels, 4u) << "one lies where nothing may be changed";
  for (std::size_t h : {0u, 1u}) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(total(p.values[h][c]) / before[h][c], 1, 1e-6);
    }
  }
  EXPECT_EQ(p.values[1][2].row(10)[40], 50);
  EXPECT_EQ(p.values[0][0].row(10)[40], 1);
  EXPECT_LT(p.values[1][0].row(39)[59], 1.2);
}

TEST(SummedArea, SumsAndAddsRectangles) {
  detail::Plane p(7, 5, 0);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) p.row(y)[x] = float(x * x + 10 * y);
  }
  const detail::RectangleSums sums(p);
  detail::AddedRectangles added(7, 5);
  const detail::Rectangle r{2, 1, 6, 4};
  double sum = 0;
  for (int y = 1; y < 4; ++y) sum = std::accumulate(p.row(y) + 2, p.row(y) + 6, sum);
  EXPECT_EQ(sums.over(r), sum);
  added.add(r, 3), added.add({0, 0, 7, 2}, 4);
  added.finish();
  EXPECT_EQ(added.at(2, 1), 7);
  EXPECT_EQ(added.at(1, 1), 4);
  EXPECT_EQ(added.at(5, 3), 3);
  EXPECT_EQ(added.at(6, 3), 0);
  EXPECT_EQ(added.at(3, 4), 0);
}

}  // namespace firefly_test
}  // namespace pvol::test
