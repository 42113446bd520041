// Which samples a render takes: that limits hold, and that adaptive samples leave means unbiased.
#include "render/engine/passes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "pvol/error.h"
#include "pvol/math/rng.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol {
namespace passes_test {

using detail::Passes;
using detail::SampleTargets;
using test::cloud;
using test::cloud_scene;
using test::CloudScene;
using test::run;
using test::same_bytes;

Film empty_film(int width, int height) {
  Film f;
  f.width = f.crop_width = width;
  f.height = f.crop_height = height;
  f.pixels.resize(std::size_t(width) * std::size_t(height));
  f.counts.resize(f.pixels.size());
  return f;
}

void add(PixelSums& p, double v) {
  p.sum += Vec3d(v), p.sum_squares += Vec3d(v * v);
  ++p.samples;
}

/// Brings a film to targets by samples of `value(pixel)`.
void fill(Film& film, const SampleTargets& targets,
          const std::function<double(std::size_t)>& value) {
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    PixelSums& p = film.pixels[i];
    while (p.samples < targets.of(i)) {
      add(p, value(i));
      ++film.counts[i][std::size_t(PixelCounter::collisions)];
    }
  }
}

std::uint64_t samples(const Film& film) {
  std::uint64_t n = 0;
  for (const PixelSums& p : film.pixels) n += p.samples;
  return n;
}

TEST(Passes, OfAFixedNumberGiveEveryPixelThatMany) {
  for (const std::uint32_t wanted : {1u, 2u, 16u, 17u, 100u}) {
    RenderOptions o;
    o.samples = wanted;
    Film film = empty_film(3, 2);
    Passes passes(o, 6);
    EXPECT_EQ(passes.total(), 6 * wanted);
    for (std::uint32_t pass = 0; const auto targets = passes.next(film, 0); ++pass) {
      ASSERT_TRUE(targets->each.empty());
      const std::uint32_t before = film.pixels[0].samples;
      EXPECT_GT(targets->all, before);
      EXPECT_EQ(before == 0, pass == 0);
      EXPECT_EQ(targets->all == 1, pass == 0) << "the first picture is there at once";
      fill(film, *targets, [](std::size_t) { return 1.0; });
    }
    EXPECT_EQ(samples(film), 6 * wanted);
  }
}

/// A clock by which each sample takes as long as it likes.
TEST(Passes, EndWhenTheTimeIsUp) {
  for (const double limit : {1e-4, 0.01, 1.0, 20.0}) {
    RenderOptions o;
    o.time = limit;
    Film film = empty_film(8, 8);
    Passes passes(o, 64);
    Rng rng(3, 0, 0);
    double seconds = 0;
    while (const auto targets = passes.next(film, seconds)) {
      fill(film, *targets, [&](std::size_t pixel) {
        seconds += pixel < 32 ? 1e-4 : 3e-4;
        return pixel < 32 ? 0.1 : double(rng.uniform());
      });
      if (samples(film) > 64) {
        EXPECT_GE(passes.total(), samples(film));
      }
    }
    constexpr double kOnePass = 64 * 2e-4;
    EXPECT_LT(seconds, std::max(1.05 * limit, 1.001 * kOnePass)) << limit;
    EXPECT_GT(seconds, 0.9 * limit) << limit;
    EXPECT_EQ(passes.total(), samples(film));
    for (const PixelSums& p : film.pixels) EXPECT_GE(p.samples, 1u);
  }
}

TEST(Passes, EndAtTheWantedNoise) {
  for (const double noise : {0.5, 0.05, 0.01}) {
    RenderOptions o;
    o.noise = noise;
    Film film = empty_film(32, 32);
    Passes passes(o, film.pixels.size());
    Rng rng(4, 0, 0);
    while (const auto targets = passes.next(film, 0)) {
      fill(film, *targets, [&](std::size_t i) {
        const double spread = i < 512 ? 1.9 : 0.1;
        return 1 + spread * (double(rng.uniform()) - 0.5);
      });
    }
    if (noise > 0.1) {
      EXPECT_EQ(samples(film), 1024 * kPilot) << "the pilot is enough";
    } else {
      EXPECT_NEAR(pixel_noise(film).value(), noise, 0.06 * noise);
      // As the roots of the variances, of which a hundredth of the larger is everywhere.
      const double above = film.at(16, 8).samples, below = film.at(16, 24).samples;
      const double pilot = kPilot / above;
      EXPECT_NEAR(below / above, std::max(pilot, std::sqrt(0.046 / 3.646)), 0.02);
    }
  }
}

/// With the same variance they need more, since noise is that beside their own brightness.
TEST(Passes, GiveDarkPixelsMoreSamples) {
  RenderOptions o;
  o.noise = 0.02;
  Film film = empty_film(32, 32);
  Passes passes(o, film.pixels.size());
  Rng rng(4, 0, 0);
  while (const auto targets = passes.next(film, 0)) {
    fill(film, *targets,
         [&](std::size_t i) { return (i < 512 ? 1 : 0.25) + 0.4 * (double(rng.uniform()) - 0.5); });
  }
  // As the roots of the relative variances, with a fiftieth of their mean everywhere.
  const double above = film.at(16, 6).samples, below = film.at(16, 26).samples;
  EXPECT_NEAR(above / below, std::sqrt(0.0156 / 0.2156), 0.02);
  EXPECT_NEAR(pixel_noise(film).value(), 0.02, 0.001);
}

/// Of a film whose pixels' means and variances are known.
TEST(PixelNoise, IsThatBesideTheBrightnessOfPixels) {
  Film film = empty_film(2, 1);
  for (const double v : {9.0, 11.0}) add(film.pixels[0], v);
  for (const double v : {0.0, 0.02}) add(film.pixels[1], v);
  // Variances of the means: 1 and 1e-4. Brightness 10 and 0.01, of which the mean is 5.005.
  const double floor = 0.05005 * 0.05005;
  const double expected = std::sqrt((1 / (100 + floor) + 1e-4 / (1e-4 + floor)) / 2);
  EXPECT_NEAR(pixel_noise(film).value(), expected, 1e-6);
  film.pixels[1].samples = 1;
  EXPECT_FALSE(pixel_noise(film));
  EXPECT_EQ(pixel_noise(empty_film(0, 0)), 0);
}

/// Each colour of pixels goes on to its own needs, whichever has more.
TEST(Passes, EachColourEndsAtItsOwnNeeds) {
  for (const std::array<double, 2> needs : {std::array{100.0, 400.0}, std::array{400.0, 100.0}}) {
    RenderOptions o;
    o.noise = 0.01;
    Film film = empty_film(16, 16);
    Passes passes(o, film.pixels.size());
    while (const auto targets = passes.next(film, 0)) {
      fill(film, *targets, [](std::size_t) { return 1.0; });
      if (!film.needs && film.pixels[0].samples == kPilot) {
        film.needs = AdaptiveSamples{std::vector<float>(film.pixels.size(), 1.0f), needs};
      }
    }
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      EXPECT_EQ(film.pixels[i].samples, needs[std::size_t(detail::colour_of(film, i))]) << i;
    }
  }
}

/// As a fire before black: fewer samples a pixel than the pilot's, all of them for few pixels.
TEST(Passes, EndAtTheWantedNoiseWhereMostPixelsAreBlack) {
  RenderOptions o;
  o.noise = 0.02;
  Film film = empty_film(64, 64);
  const auto is_lit = [](std::size_t i) { return i % 64 < 8 && i / 64 < 8; };
  Passes passes(o, film.pixels.size());
  Rng rng(7, 0, 0);
  while (const auto targets = passes.next(film, 0)) {
    fill(film, *targets,
         [&](std::size_t i) { return is_lit(i) ? 1 + 3.4 * (double(rng.uniform()) - 0.5) : 0.0; });
  }
  // Pixels at its edge are measured by the dark around them, too, and get more samples than they
  // need.
  EXPECT_LT(pixel_noise(film).value(), 0.021);
  EXPECT_GT(pixel_noise(film).value(), 0.014);
  EXPECT_LT(samples(film), 4096 * 1.5 * kPilot);
}

/// One sample in each half, which a filter needs, whatever the time.
TEST(Passes, HalvesHaveASampleEach) {
  RenderOptions o;
  o.time = 1e-4;
  o.aovs.add(Aov::halves);
  Film film = empty_film(8, 8);
  Passes passes(o, 64);
  double seconds = 0;
  while (const auto targets = passes.next(film, seconds)) {
    fill(film, *targets, [&](std::size_t) { return seconds += 1; });
  }
  for (const PixelSums& p : film.pixels) EXPECT_EQ(p.samples, 2u);
}

/// What a pixel gets, and what its colour gets in all, does not depend on any sample of its colour.
TEST(Needs, OfAPixelFollowFromPixelsOfTheOtherColourAlone) {
  Film film = empty_film(9, 7);
  Rng rng(5, 0, 0);
  fill(film, {.all = 16}, [&](std::size_t) { return double(rng.uniform()); });
  const AdaptiveSamples before = detail::find_adaptive_samples(film, 0.01);
  for (std::size_t changed = 0; changed < film.pixels.size(); ++changed) {
    Film other = film;
    add(other.pixels[changed], 1000);
    other.pixels[changed].samples = 16;
    other.counts[changed][std::size_t(PixelCounter::collisions)] = 100000;
    const AdaptiveSamples after = detail::find_adaptive_samples(other, 0.01);
    const std::size_t colour = detail::colour_of(film, changed);
    EXPECT_EQ(after.samples[colour], before.samples[colour]);
    EXPECT_NE(after.samples[1 - colour], before.samples[1 - colour]);
    int moved = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      if (detail::colour_of(film, i) == colour) {
        EXPECT_EQ(after.share[i], before.share[i]);
      } else {
        moved += after.share[i] != before.share[i];
      }
    }
    EXPECT_GT(moved, 10);
  }
}

/// Rare bright samples, which draw samples to where they were found: were a pixel's number of
/// samples to follow from its own, its mean would be far off.
TEST(Passes, AdaptiveLeaveMeansUnbiased) {
  constexpr int kEdge = 6;
  const int pictures = proof::samples(10'000);
  std::vector<proof::Moments> means(kEdge * kEdge);
  proof::Moments all, number;
  for (int picture = 0; picture < pictures; ++picture) {
    RenderOptions o;
    o.noise = 0.12;
    Film film = empty_film(kEdge, kEdge);
    Passes passes(o, film.pixels.size());
    Rng rng(proof::seeded(6), 0, std::uint64_t(picture));
    while (const auto targets = passes.next(film, 0)) {
      fill(film, *targets, [&](std::size_t i) {
        const float chance = i % 5 == 0 ? 0.05f : 0.5f;
        return rng.uniform() < chance ? 1 / double(chance) : 0.0;
      });
    }
    double sum = 0;
    for (std::size_t i = 0; i < means.size(); ++i) {
      means[i].add(mean(film.pixels[i]).x);
      sum += mean(film.pixels[i]).x / double(means.size());
    }
    all.add(sum);
    number.add(double(samples(film)) / double(means.size()));
  }
  proof::Family family;
  const auto test = [&](const std::string& name, const proof::Moments& m) {
    family.add(name, proof::normal_p_value((m.mean() - 1) / std::sqrt(m.variance_of_mean())));
  };
  for (std::size_t i = 0; i < means.size(); ++i) test("pixel " + std::to_string(i), means[i]);
  test("picture", all);
  EXPECT_TRUE(family.passes());
  const double shown = proof::runs_all() ? 0.01 : 0.02;
  EXPECT_LT(std::sqrt(all.variance_of_mean()), 0.1 * shown) << "a bias of this would not show";
  EXPECT_GT(number.mean(), 1.5 * kPilot) << "most samples are adaptive";
}

CloudScene noisy_scene() {
  CloudScene s = cloud_scene();
  s.options.width = 12;
  s.options.height = 10;
  s.options.noise = 0.1;
  s.options.guide = GuideUse::off;  // guided paths are not that noisy
  return s;
}

TEST(Render, AdaptiveGivesTheSameBytesForAnyThreadsAndWithCounts) {
  CloudScene s = noisy_scene();
  s.options.threads = 1;
  const RenderResult one = run(cloud(), s);
  EXPECT_TRUE(one.complete);
  EXPECT_NEAR(pixel_noise(one.film).value(), 0.1, 0.02);
  EXPECT_EQ(one.counts, Counts{}) << "those of the pilot are not of the render";
  EXPECT_TRUE(one.film.counts.empty());
  for (const int threads : {2, 7}) {
    s.options.threads = threads;
    EXPECT_TRUE(same_bytes(one.film, run(cloud(), s).film)) << threads;
  }
  s.options.count = true;
  EXPECT_TRUE(same_bytes(one.film, run(cloud(), s).film)) << "counted";
}

/// Adaptive samples are those of a fixed number: a pixel's are numbered from 0 on.
TEST(Render, AdaptiveTakesSamplesOfTheSameNumbers) {
  CloudScene s = noisy_scene();
  s.options.noise = 0.06;  // 0.1 takes the least samples everywhere
  s.options.guide = GuideUse::off;
  const Film film = run(cloud(), s).film;
  std::uint32_t most = 0, least = ~0u;
  for (const PixelSums& p : film.pixels) {
    most = std::max(most, p.samples), least = std::min(least, p.samples);
  }
  EXPECT_GT(most, least);
  s.options.noise.reset();
  for (const std::uint32_t n : {least, most}) {
    s.options.samples = n;
    const Film fixed = run(cloud(), s).film;
    int same = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      if (film.pixels[i].samples != n) continue;
      EXPECT_TRUE(same_bytes(fixed.pixels[i], film.pixels[i]));
      ++same;
    }
    EXPECT_GT(same, 0);
  }
}

/// Whole adaptive renders against one of many samples.
TEST(Render, AdaptiveIsUnbiased) {
  CloudScene s = noisy_scene();
  s.options.guide = GuideUse::off;
  s.options.width = s.options.height = 6;
  s.options.noise = 0.25;
  proof::Moments adaptive;
  for (s.options.seed = 1; s.options.seed <= 1000; ++s.options.seed) {
    adaptive.add(test::average(run(cloud(), s).film).mean.y);
  }
  s.options.noise.reset();
  s.options.samples = proof::samples(60'000);
  const test::Average fixed = test::average(run(cloud(), s).film);
  const double deviation = std::sqrt(adaptive.variance_of_mean() + fixed.variance.y);
  EXPECT_LT(deviation, 0.003 * fixed.mean.y) << "a bias of 1 % would show";
  proof::Family family;
  family.add("mean", proof::normal_p_value((adaptive.mean() - fixed.mean.y) / deviation));
  EXPECT_TRUE(family.passes());
}

TEST(Render, ByTimeLeavesAWholePicture) {
  CloudScene s = noisy_scene();
  s.options.noise.reset();
  s.options.time = 1e-6;
  const RenderResult r = run(cloud(), s);
  EXPECT_TRUE(r.complete);
  for (const PixelSums& p : r.film.pixels) EXPECT_EQ(p.samples, 1u);
}

TEST(Render, AdaptiveDoesNotRunOutOfSampleNumbers) {
  CloudScene s = noisy_scene();
  s.options.first_sample = 3'000'000'000;
  EXPECT_TRUE(run(cloud(), s).complete);
  s.options.first_sample = 4'000'000'000;
  EXPECT_THROW((void)run(cloud(), s), Error);
}

TEST(Render, NoiseOfOnePixelIsRefused) {
  CloudScene s = noisy_scene();
  s.options.width = s.options.height = 1;
  EXPECT_THROW((void)run(cloud(), s), Error);
}

}  // namespace passes_test
}  // namespace pvol
