// The parts of the filter, each against its formula (THEORY.md, T5.10).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pvol/render/denoise.h"
#include "render/denoise/denoise_inputs.h"
#include "render/denoise/patch_weights.h"
#include "support/known_film.h"

namespace pvol::test {
namespace filter_parts_test {

using detail::Guide;
using detail::Plane;

/// A plane of random values between 0 and `most`.
Plane random_plane(int width, int height, int margin, double most, std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(0, most);
  Plane p(width, height, margin);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) p.row(y)[x] = float(uniform(generator));
  }
  p.repeat_edges();
  return p;
}

/// w of pixel (x, y) and the one at an offset from it, in double and pixel by pixel.
double expected_weight(const Guide& g, const detail::PatchOptions& o, int x, int y, int dx,
                       int dy) {
  double sum = 0, count = 0;
  for (std::size_t c = 0; c < g.values.size(); ++c) {
    for (int j = -o.patch; j <= o.patch; ++j) {
      for (int i = -o.patch; i <= o.patch; ++i) {
        const auto at = [&](const Plane& p, int ox, int oy) {
          return double(p.row(y + j + oy)[x + i + ox]);
        };
        const double d = at(g.values[c], 0, 0) - at(g.values[c], dx, dy);
        const double vp = at(g.variances[c], 0, 0), vq = at(g.variances[c], dx, dy);
        const double k = double(o.bandwidth);
        sum += (d * d - vp - std::min(vp, vq)) / (k * k * (vp + vq)), ++count;
      }
    }
  }
  return std::pow(std::max(0.0, 1 - std::max(0.0, sum / count) / 8), 8);
}

TEST(PatchWeights, FollowTheFormula) {
  std::mt19937 generator(1);
  for (const int patch : {0, 1, 3}) {
    const detail::PatchOptions o{.window = 2, .patch = patch, .bandwidth = 0.9f};
    Guide g;
    for (int c = 0; c < 2; ++c) {
      g.values.push_back(random_plane(40, 12, detail::margin_of(o), 1, generator));
      g.variances.push_back(random_plane(40, 12, detail::margin_of(o), 0.3, generator));
    }
    const detail::Tile t{0, 0, detail::kTile, 12};
    const detail::PatchWeights weights(g, g, nullptr, t, o);
    int inside = 0;  // weights that are neither 0 nor 1
    for (int y = 0; y < 12; ++y) {
      for (int dy = std::max(-2, -y); dy <= std::min(2, 11 - y); ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
          for (int x = 2; x < detail::kTile; ++x) {
            const double w = expected_weight(g, o, x, y, dx, dy);
            ASSERT_NEAR(double(weights.row(dx, dy, y)[x]), w, 1e-4) << patch;
            inside += w > 0.01 && w < 0.99;
          }
        }
      }
    }
    EXPECT_GT(inside, 1000) << patch;
  }
}

/// What is nothing but noise is smoothed as far as so many pixels let it be: its variance is known.
TEST(Features, LoseTheirNoise) {
  Truth t;
  t.width = t.height = 192, t.samples = 2;
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  Film film = make(t);
  const std::size_t depth = 2;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    film.layers[depth].sums[i].x = (5 + normal(generator)) * film.layers[depth].weights[i];
  }
  const detail::Planes planes = detail::make_features(film, 0, {}).planes;
  const Plane& p =
      planes.back();  // after place and alpha, of features that are not the same everywhere
  ASSERT_EQ(planes.size(), 4u);
  double squares = 0, count = 0;
  for (int y = 8; y < 184; ++y) {
    for (int x = 8; x < 184; ++x) squares += std::pow(double(p.row(y)[x]), 2), ++count;
  }
  // The mean of 11 x 11 pixels would leave 1/11 of a deviation, which is 1 before.
  const double left = 11 * std::sqrt(squares / count);
  EXPECT_GT(left, 0.9);
  EXPECT_LT(left, 1.1);
}

double root_mean(const std::vector<Vec3d>& squares) {
  double sum = 0;
  for (const Vec3d& v : squares) sum += v.x;
  return std::sqrt(sum / double(squares.size()));
}

struct Estimate {
  double of_pixels = 0, of_picture = 0;  ///< estimated over true error
};

Estimate estimate(const Truth& t, const DenoiseOptions& o) {
  const Denoised d = denoise(make(t), o);
  double light = 0;
  for (const Vec3d& c : d.colour) light += c.x / double(d.colour.size());
  const double of = error(t, d.colour);
  return {root_mean(d.mse) / of, d.relative_error * light / of};
}

/// Each half is compared with the other: its own noise is in what it gave.
TEST(FilterError, CountsDetailThatIsLostAmongNoise) {
  Truth t;
  t.width = t.height = 128, t.samples = 16, t.noise = 1;
  t.light = [](int x, int) { return 4 + 0.3 * std::cos(2.2 * x); };
  const Estimate e = estimate(t, {.window = 1, .patch = 1, .bandwidth = 40});
  EXPECT_NEAR(e.of_pixels, 1, 0.2);
  EXPECT_NEAR(e.of_picture, 1, 0.2);
}

/// All of the error is variance, and none of it is counted twice.
TEST(FilterError, IsTheNoiseWhereNothingIsSmoothed) {
  Truth t;
  t.width = t.height = 96, t.samples = 16, t.noise = 1;
  t.light = [](int, int) { return 4.0; };
  const Estimate e = estimate(t, {.window = 1, .patch = 0, .bandwidth = 0.05});
  EXPECT_NEAR(e.of_pixels, 1, 0.15);
  EXPECT_NEAR(e.of_picture, 1, 0.1);
}

}  // namespace filter_parts_test
}  // namespace pvol::test
