// The two halves of a picture's samples, which a filter takes to be independent (THEORY.md, T5.10
// and T5.15); and the two groups of them that tell its noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "render/path/camera_rays.h"
#include "support/bodies.h"

namespace pvol::test {
namespace halves_test {

constexpr std::uint32_t kSamples = 16;

/// Dark balls before a sky of 1, so that pixels differ by what their samples cover alone.
CloudScene balls() {
  CloudScene s;
  s.medium.extinction = 1e-12;
  s.camera.position = {0, 0, 10}, s.camera.target = {0, 0, 0};
  s.environment = ConstantSky{Rgb(1.0f)};
  for (int i = -3; i <= 3; ++i) {
    for (int j = -2; j <= 2; ++j) {
      s.surfaces.push_back(BallSurface{{i + 0.1 * j, j - 0.1 * i, 0}, 0.3, {.albedo = Rgb(0.0f)}});
    }
  }
  s.options.width = 48, s.options.height = 32;
  s.options.samples = kSamples;
  s.options.look_up = LookUp::nearest;
  s.options.guide = GuideUse::off;
  return s;
}

Film film_of(const CloudScene& s) {
  return render(make_volumes(cube(), std::vector{s.medium}, s), s).film;
}

/// Red of each pixel in the even and in the odd samples, whatever sequences these come from.
using Pictures = std::array<std::vector<double>, 2>;

Pictures halves_of(CloudScene s) {
  s.options.aovs.add(Aov::halves);
  const Film film = film_of(s);
  Pictures halves;
  for (std::size_t half = 0; half < 2; ++half) {
    for (const Vec3d& sum : film.layers[half].sums) halves[half].push_back(sum.x / (kSamples / 2));
  }
  return halves;
}

Pictures every_other_sample_of(CloudScene s) {
  Pictures pictures;
  s.options.samples = 1;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    s.options.first_sample = i;
    const Film film = film_of(s);
    auto& sums = pictures[i % 2];
    sums.resize(film.pixels.size());
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += film.pixels[k].sum.x / (kSamples / 2);
  }
  return pictures;
}

std::vector<double> truth_of(CloudScene s, std::uint32_t samples = 256) {
  s.options.samples = samples, s.options.seed = 777;
  std::vector<double> truth;
  for (const PixelSums& p : film_of(s).pixels) truth.push_back(mean(p).x);
  return truth;
}

/// How errors of the two vary together, and the mean square of those of one.
struct Errors {
  double correlation, square;
};
Errors errors_of(const Pictures& p, const std::vector<double>& truth) {
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double a = p[0][i] - truth[i], b = p[1][i] - truth[i];
    aa += a * a, bb += b * b, ab += a * b;
  }
  return {ab / std::sqrt(aa * bb), (aa + bb) / double(2 * truth.size())};
}

struct View {
  const char* name;
  CloudScene scene;
};
std::vector<View> views() {
  const CloudScene still = balls();
  CloudScene moving = still, lens = still;
  moving.camera.shutter = {0, 1};
  moving.camera.to = CameraPlace{{0.5, 0.2, 10}, {0.5, 0.2, 0}};
  moving.options.filter_width = 0.1;
  lens.camera.f_stop = 0.03, lens.camera.focus_distance = 7;
  lens.options.filter_width = 0.1;
  return {{"edges", still}, {"motion", moving}, {"lens", lens}};
}

TEST(Halves, AreIndependentAtEdgesInMotionAndBehindALens) {
  for (const View& v : views()) {
    const std::vector<double> truth = truth_of(v.scene);
    const Errors halves = errors_of(halves_of(v.scene), truth);
    EXPECT_LT(std::abs(halves.correlation), 0.15) << v.name;
    // What the test is to find: samples of one sequence, of which each half lacks what the other
    // has.
    const Errors others = errors_of(every_other_sample_of(v.scene), truth);
    EXPECT_LT(others.correlation, -0.4) << v.name;
    EXPECT_LT(halves.square, others.square) << v.name;
  }
}

TEST(Halves, CoverPixelLensAndShutterEvenly) {
  CloudScene s = balls();
  s.camera.shutter = {0, 1};
  s.options.aovs.add(Aov::halves);
  const std::vector<Volume> volumes = make_volumes(cube(), std::vector{s.medium}, s);
  const Scene scene = s.scene();
  const detail::PathSetup setup(plan(volumes, scene));
  for (std::uint32_t half = 0; half < 2; ++half) {
    for (const std::uint32_t first : {0u, 32u}) {
      std::set<int> times, columns, rows, boxes;
      for (std::uint32_t i = 0; i < 16; ++i) {
        const detail::PixelSample sample{5, 7, first + 2 * i + half};
        // A time may be rounded to the end.
        times.insert(std::min(15, int(detail::sample_time(setup, sample) * 16)));
        const auto [u, v] = detail::sample_point(setup, sample, detail::Aside::lens);
        columns.insert(int(u * 16)), rows.insert(int(v * 16));
        boxes.insert(int(u * 4) * 4 + int(v * 4));
      }
      for (const auto& strata : {times, columns, rows, boxes}) EXPECT_EQ(strata.size(), 16u);
    }
  }
}

/// The root mean square of a picture's error over its mean, and what the film says of it: by groups
/// of its samples, and as if they were independent.
struct Noise {
  double error, by_groups, as_if_independent;
};

Noise noise_of(const CloudScene& s, const std::vector<double>& truth) {
  const Film film = film_of(s);
  double error = 0, light = 0, sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const PixelSums& p = film.pixels[i];
    const double d = mean(p).x - truth[i];
    error += d * d, light += mean(p).x, sum += pvol::noise_of(p);
  }
  const double unit = std::sqrt(double(truth.size())) / light;
  return {std::sqrt(error) * unit, relative_noise(film).value(), std::sqrt(sum) * unit};
}

TEST(Groups, TellTheNoiseOfStratifiedSamples) {
  for (const View& v : views()) {
    const std::vector<double> truth = truth_of(v.scene, 1024);
    CloudScene s = v.scene;
    s.options.samples = 64;
    const Noise noise = noise_of(s, truth);
    // Groups are less even than all.
    EXPECT_GT(noise.by_groups, 0.95 * noise.error) << v.name;
    EXPECT_LT(noise.by_groups, 0.8 * noise.as_if_independent) << v.name;
    s.options.aovs.add(Aov::halves);
    const Noise of_independent_halves = noise_of(s, truth);
    EXPECT_NEAR(of_independent_halves.by_groups / of_independent_halves.error, 1, 0.08) << v.name;
  }
}

/// Noise of the paths, which nothing stratifies.
TEST(Groups, TellTheNoiseOfIndependentSamples) {
  CloudScene s = balls();
  s.surfaces.clear();
  s.medium.extinction = 0.1;
  s.camera.position = {6, 6, 100}, s.camera.target = {6, 6, 0}, s.camera.fov = 5;
  s.options.transmittance = Transmittance::analog;
  for (const std::uint32_t samples : {16u, 100u}) {
    s.options.samples = samples;
    const Film film = film_of(s);
    double groups = 0, independent = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      groups += luminance_variance(film, i), independent += pvol::noise_of(film.pixels[i]);
    }
    EXPECT_NEAR(groups / independent, 1, 0.15) << samples;  // four standard errors
    EXPECT_NE(groups, independent);
  }
}

/// Few samples or pixels leave one degree of freedom too many in doubt.
TEST(Groups, AreNotAskedWhereTheyAreFew) {
  CloudScene s = balls();
  s.options.samples = 15;
  const auto is_independent = [&] {
    const Film film = film_of(s);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      if (luminance_variance(film, i) != pvol::noise_of(film.pixels[i])) return false;
    }
    return true;
  };
  EXPECT_TRUE(is_independent());
  s.options.samples = 16;
  EXPECT_FALSE(is_independent());
  s.options.crop_width = 10, s.options.crop_height = 9;
  EXPECT_TRUE(is_independent());
}

}  // namespace halves_test
}  // namespace pvol::test
