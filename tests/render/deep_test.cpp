// Deep pictures: that their samples add up to the picture, at every depth; closed forms; and scenes
// rendered apart and put together in depth.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pvol/error.h"
#include "pvol/math/rng.h"
#include "support/bodies.h"
#include "support/lit_scenes.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/statistics.h"

namespace pvol::test {
namespace deep_test {

/// Whether two values are the same but for the rounding of sums of this size.
testing::AssertionResult near(const DeepValue& a, Vec3d colour, double alpha, double size) {
  const double error = length(a.colour - colour) / size + std::abs(a.alpha - alpha);
  if (error < 1e-12) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "off by " << error;
}

/// The size of what a pixel's bins add up to, where they may have signs.
double size_of(const Film& film, std::size_t pixel) {
  double size = 1e-300;
  for (const DeepBin& b : film.deep.pixels[pixel]) size += length(b.sum);
  return size / film.pixels[pixel].samples;
}

std::vector<DeepSample> samples_of(const Film& film, std::size_t pixel, double error) {
  return deep_samples(film.deep, pixel, film.pixels[pixel].samples, error);
}

bool same_bins(const DeepFilm& a, const DeepFilm& b) {
  const auto same = [](const DeepBin& p, const DeepBin& q) {
    return p.sum == q.sum && p.count == q.count && p.number == q.number;
  };
  if (a.front != b.front || a.back != b.back || a.pixels.size() != b.pixels.size()) return false;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (!std::ranges::equal(a.pixels[i], b.pixels[i], same)) return false;
  }
  return true;
}

testing::AssertionResult is_tidy(const std::vector<DeepSample>& samples) {
  double end = 0;
  for (const DeepSample& s : samples) {
    const bool thin = s.z == s.z_back;
    if (!(s.z >= end && s.z <= s.z_back && s.alpha > 0 && s.alpha <= 1 && thin == (s.alpha == 1))) {
      return testing::AssertionFailure()
             << "[" << s.z << ", " << s.z_back << "] behind " << end << ", alpha " << s.alpha;
    }
    end = s.z_back;
  }
  return testing::AssertionSuccess();
}

/// Every light and medium, guided and not; and the picture does not change for it.
TEST(Deep, AddsUpToThePictureWithoutBackground) {
  for (Case& c : cases()) {
    CloudScene& s = c.scene;
    s.options.samples = proof::samples(30u);
    const Volume v = volume_of(s);
    const Film plain = render(v, s).film;
    EXPECT_TRUE(plain.deep.pixels.empty()) << "nobody asked";
    s.options.deep = true;
    const Film film = render(v, s).film;
    EXPECT_TRUE(same_bytes(plain, film)) << c.name;
    s.options.background = false;
    const Film cut_out = render(v, s).film;
    EXPECT_TRUE(same_bins(film.deep, cut_out.deep)) << c.name << ": a background is in it";
    std::size_t covered = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const std::vector<DeepSample> samples = samples_of(film, i, 0.01);
      const PixelSums& p = cut_out.pixels[i];
      ASSERT_TRUE(is_tidy(samples)) << c.name;
      ASSERT_TRUE(near(flatten(samples), mean(p), p.alpha / p.samples, size_of(film, i)))
          << c.name << ", pixel " << i;
      covered += samples.empty() ? 0 : 1;
    }
    EXPECT_GT(covered, 0u) << c.name;
  }
}

Film deep_puff(std::uint32_t samples, int bins) {
  CloudScene s = sunny();
  s.medium.extinction = 0.08;
  s.options.deep = true;
  s.options.samples = samples;
  s.options.deep_bins = bins;
  return render(volume_of(s), s).film;
}

TEST(Deep, AddsUpToTheBinsBeforeEveryEdge) {
  const Film film = deep_puff(200, 40);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const std::vector<DeepSample> samples = samples_of(film, i, 0);
    const double n = film.pixels[i].samples;
    const auto& bins = film.deep.pixels[i];
    DeepValue before;
    for (std::uint32_t k = 0, next = 0; k <= 40; ++k) {
      for (; next < bins.size() && bins[next].number < k; ++next) {
        before.colour += bins[next].sum / n;
        before.alpha += bins[next].count / n;
      }
      ASSERT_TRUE(near(seen_before(samples, film.deep.edge(k)), before.colour, before.alpha,
                       size_of(film, i)));
    }
  }
}

/// From amid an even cube, in all directions: of these half are behind the view.
TEST(Deep, OfALatlongCameraIsByDistance) {
  CloudScene s;
  s.medium = component(1.5, Rgb(0.0f), 0);
  s.camera.kind = CameraKind::latlong;
  s.camera.position = {6, 6.2, 5.9};
  s.camera.target = {9, 5, 7};
  s.options.width = 16, s.options.height = 8;
  s.options.look_up = LookUp::nearest;
  s.options.samples = 400;
  s.options.deep = true;
  s.options.deep_bins = 200;
  s.options.aovs.add(Aov::nearest);
  const Film film =
      render(make_volume(cube().grid, build_pyramid(cube().grid, s.options.look_up), s), s).film;
  EXPECT_EQ(film.deep.front, 0);
  double sum[2] = {}, count[2] = {};  // before and behind
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    EXPECT_TRUE(is_tidy(samples_of(film, i, 0.01)));
    const bool behind = i % 16 < 4 || i % 16 >= 12;
    for (const DeepBin& b : film.deep.pixels[i]) {
      sum[behind] += b.count * 0.5 * (film.deep.edge(b.number) + film.deep.edge(b.number + 1));
      count[behind] += b.count;
    }
  }
  for (const bool behind : {false, true}) {
    ASSERT_GT(count[behind], 25'000);
    EXPECT_NEAR(sum[behind] / count[behind], 1 / 1.5, 0.02) << behind;
  }
}

TEST(Deep, MergesToTheErrorThatIsAllowedAndNoFurther) {
  const Film film = deep_puff(2000, 64);
  std::size_t before = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) before += film.deep.pixels[i].size();
  for (const double error : {0.0, 0.002, 0.01, 0.1, 1.0}) {
    std::size_t count = 0;
    double most = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const auto fine = samples_of(film, i, 0), coarse = samples_of(film, i, error);
      const DeepValue all = flatten(fine);
      ASSERT_TRUE(is_tidy(coarse));
      ASSERT_TRUE(near(flatten(coarse), all.colour, all.alpha, size_of(film, i)));
      count += coarse.size();
      for (int k = 0; k <= 777 && !fine.empty(); ++k) {
        const double z = film.deep.front + (film.deep.back - film.deep.front) * k / 777;
        const DeepValue a = seen_before(fine, z), b = seen_before(coarse, z);
        most = std::max(most, std::abs(a.alpha - b.alpha) / all.alpha);
        for (int c = 0; c < 3; ++c) {
          most = std::max(most, std::abs(a.colour[c] - b.colour[c]) / all.colour[c]);
        }
      }
    }
    EXPECT_LE(most, error + 1e-12);
    if (error == 0) {
      EXPECT_EQ(count, before);
      continue;
    }
    EXPECT_LT(count, before) << error;
    // Of all that may be merged at a share of 1, a few samples are left.
    EXPECT_GT(most, error < 1 ? 0.9 * error : 0) << "merges less than it may";
  }
}

/// Two bins of one medium are one sample; where the second is thinner they are not.
TEST(Deep, MergesAnEvenMediumWithoutError) {
  const auto film = [](std::uint32_t first, std::uint32_t second) {
    DeepFilm f{10, 14, 4, std::vector<std::vector<DeepBin>>(1)};
    f.pixels[0] = {{Vec3d(2.0 * first), first, 1}, {Vec3d(2.0 * second), second, 2}};
    return f;
  };
  const auto one = deep_samples(film(512, 256), 0, 1024, 1e-12);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].z, 11);
  EXPECT_EQ(one[0].z_back, 13);
  EXPECT_EQ(one[0].alpha, 0.75);
  EXPECT_EQ(one[0].colour, Vec3d(1.5));
  EXPECT_EQ(deep_samples(film(512, 200), 0, 1024, 1e-3).size(), 2u);
  // What covers all that is left is thin, and stays alone.
  const auto two = deep_samples(film(512, 512), 0, 1024, 1);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[1].alpha, 1);
  EXPECT_EQ(two[1].z, 12.5);
  EXPECT_EQ(two[1].z_back, 12.5);
}

/// Bins so dense that most of what happens in them happens at their front: the greatest change lies
/// inside.
TEST(Deep, MergingKeepsToItsErrorWithinDenseBins) {
  constexpr std::uint32_t kSamples = 1'000'000;
  constexpr int kBins = 6;
  std::size_t merged = 0;
  for (std::uint64_t k = 0; k < 400; ++k) {
    Rng rng(1, k, 0);
    DeepFilm f{10, 10 + kBins, kBins, std::vector<std::vector<DeepBin>>(1)};
    std::uint32_t left = kSamples;
    for (std::uint32_t i = 0; i < kBins; ++i) {
      const double open = std::exp(-8 * double(rng.uniform()) * double(rng.uniform()));
      const auto count = std::uint32_t((1 - open) * left);
      if (count == 0 || rng.uniform() < 0.2f) continue;
      const Vec3d light(rng.uniform(), double(rng.uniform()) - 0.3, 1);
      f.pixels[0].push_back({light * count, count, i});
      left -= count;
    }
    const auto fine = deep_samples(f, 0, kSamples, 0);
    for (const double error : {0.02, 0.1, 0.3}) {
      const auto coarse = deep_samples(f, 0, kSamples, error);
      merged += fine.size() - coarse.size();
      const DeepValue all = flatten(fine);
      for (int step = 0; step <= 200 * kBins; ++step) {
        const double z = 10 + step / 200.0;
        const DeepValue a = seen_before(fine, z), b = seen_before(coarse, z);
        ASSERT_LE(std::abs(a.alpha - b.alpha), error * all.alpha + 1e-9) << k << ", depth " << z;
        for (int c = 0; c < 3; ++c) {
          ASSERT_LE(std::abs(a.colour[c] - b.colour[c]), error * std::abs(all.colour[c]) + 1e-9);
        }
      }
    }
  }
  EXPECT_GT(merged, 400u);
}

TEST(Deep, BinsBeginAtACameraInside) {
  CloudScene s = sunny();
  s.camera.position = {20, 16, 18};
  s.camera.target = {26, 16, 18};
  s.options.deep = true;
  const Volume v = volume_of(s);
  const DeepFilm film = render(v, s).film.deep;
  EXPECT_EQ(film.front, 0);
  EXPECT_NEAR(film.back, v.density.world_box.hi.x - 20, 1e-6);
}

TEST(Deep, WhatRoundingPutsOutsideBelongsToTheLastBins) {
  DeepFilm f{10, 14, 4, std::vector<std::vector<DeepBin>>(1)};
  for (const double depth : {14.0001, 9.9999, 14.0, 10.0, 12.0}) f.add(0, depth, Vec3d(1));
  ASSERT_EQ(f.pixels[0].size(), 3u);
  DeepFilm inside{10, 14, 4, std::vector<std::vector<DeepBin>>(1)};
  for (const double depth : {10.9999, 11.0}) inside.add(0, depth, Vec3d(1));
  EXPECT_EQ(inside.pixels[0].size(), 2u) << "an edge belongs to the bin behind it";
  const std::uint32_t expected[3][2] = {{0, 2}, {2, 1}, {3, 2}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(f.pixels[0][i].number, expected[i][0]);
    EXPECT_EQ(f.pixels[0][i].count, expected[i][1]);
    EXPECT_EQ(f.pixels[0][i].sum, Vec3d(expected[i][1]));
  }
}

/// A cube seen from the front and, by a pixel far from the axis, at an angle: T = exp(-mu d / cos)
/// with d along the axis.
TEST(Deep, FollowsTheClosedFormOfACubeByDepthAlongTheAxis) {
  proof::Family family;
  for (const int column : {500, 999}) {
    CloudScene s;
    s.medium = component(0.12, Rgb(0.0f), 0, Rgb(1.0f, 2.0f, 3.0f));
    s.camera.fov = 40;
    s.options.width = s.options.height = 1000;
    s.options.crop_x = column, s.options.crop_y = 500;
    s.options.crop_width = s.options.crop_height = 1;
    // Of a ray's way for each unit of depth, what goes to the right.
    const double right = (column + 0.5 - 500) / 500 * std::tan(20 * std::numbers::pi / 180);
    s.camera.position = {3 - 50 * right, 6, 62.5};
    s.camera.target = {3 - 50 * right, 6, 0};
    s.environment = ConstantSky{Rgb(0.7f)};
    s.options.look_up = LookUp::nearest;
    s.options.samples = proof::samples(40'000);
    s.options.deep = true;
    s.options.deep_bins = 14;
    const Volume v = make_volumes(cube(), std::vector{s.medium}, s).front();
    const Film film = render(v, s).film;
    EXPECT_LE(film.deep.front, 50);
    EXPECT_GE(film.deep.back, 63);
    EXPECT_LE(film.deep.back - film.deep.front, 14) << "the box of the support, in whole cells";
    const double slant = std::sqrt(1 + right * right);
    const auto transmittance = [&](double depth) {
      return std::exp(-s.medium.extinction * slant * (std::clamp(depth, 50.0, 63.0) - 50));
    };
    std::vector<std::uint64_t> counts(15);
    std::vector<double> expected(15);
    counts[14] = s.options.samples;
    for (const DeepBin& b : film.deep.pixels[0]) {
      counts[b.number] = b.count;
      counts[14] -= b.count;
      EXPECT_LT(length(b.sum / b.count - Vec3d(1, 2, 3)), 1e-6);
    }
    double before = 1;
    for (std::uint32_t k = 0; k < 14; ++k) {
      const double behind = transmittance(film.deep.edge(k + 1));
      expected[k] = s.options.samples * (before - behind);
      before = behind;
    }
    expected[14] = s.options.samples * before;
    family.add("column " + std::to_string(column), proof::counts_p_value(counts, expected));
    // But for noise and half bins at its ends an even medium is one sample.
    EXPECT_LE(samples_of(film, 0, 0.02).size(), 3u);
  }
  EXPECT_TRUE(family.passes());
}

TEST(Deep, IsTheSameForAnyNumberOfThreadsAndPasses) {
  CloudScene s = sunny();
  s.options.deep = true;
  s.options.samples = 40;
  const Volume v = volume_of(s);
  const Film one = render(v, s).film;
  for (const int threads : {2, 7}) {
    s.options.threads = threads;
    EXPECT_TRUE(same_bins(one.deep, render(v, s).film.deep)) << threads;
  }
  s.options.samples = 25;
  Film both = render(v, s).film;
  s.options.samples = 15;
  s.options.first_sample = 25;
  add_samples(both, render(v, s).film);
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    const auto &a = one.deep.pixels[i], &b = both.deep.pixels[i];
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(a[k].count, b[k].count);
      ASSERT_LE(length(a[k].sum - b[k].sum), 1e-12 * length(a[k].sum));
    }
  }
  s.options.deep_bins = 63;
  EXPECT_THROW(add_samples(both, render(v, s).film), Error);
}

/// Two glowing cubes that lie apart, and the picture of both.
TEST(Deep, ScenesRenderedApartAreOneSceneInDepth) {
  const std::vector<Body> bodies{
      component(0.05, Rgb(0.0f), 0, Rgb(3.0f, 1.0f, 0.5f)),
      component(0.1, Rgb(0.0f), 0, Rgb(0.2f, 1.0f, 4.0f), translation({4, 3, -30}))};
  CloudScene s;
  s.camera.position = {8, 9, 60};
  s.camera.target = {7, 7, -10};
  s.camera.fov = 22;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 12;
  s.options.samples = 64;
  s.options.look_up = LookUp::nearest;
  s.options.threads = 1;
  const std::vector<Volume> volumes = make_volumes(cube(), bodies, s);
  std::array<proof::Moments, 4> together, apart;
  s.options.filter = PixelFilter::box;  // what pixels share has no depth
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    s.options.deep = false;
    s.options.seed = seed;
    const Film film = render(volumes, s).film;
    s.options.deep = true;
    std::array<Film, 2> one;
    for (std::size_t k = 0; k < 2; ++k) {
      s.options.seed = 1000 + 2 * seed + k;
      one[k] = render(std::span(&volumes[k], 1), s).film;
    }
    ASSERT_LT(one[0].deep.back, one[1].deep.front) << "apart";
    DeepValue a, b;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      a.colour += mean(film.pixels[i]);
      a.alpha += film.pixels[i].alpha / film.pixels[i].samples;
      std::vector<DeepSample> merged = samples_of(one[1], i, 0.005);
      const auto front = samples_of(one[0], i, 0.005);
      merged.insert(merged.begin(), front.begin(), front.end());
      const DeepValue seen = flatten(merged);
      b.colour += seen.colour;
      b.alpha += seen.alpha;
    }
    for (int c = 0; c < 3; ++c) {
      together[std::size_t(c)].add(a.colour[c]), apart[std::size_t(c)].add(b.colour[c]);
    }
    together[3].add(a.alpha), apart[3].add(b.alpha);
  }
  proof::Family family;
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_GT(together[c].mean(), 1);
    family.add(std::to_string(c), proof::equal_means_p_value(together[c], apart[c]));
  }
  EXPECT_TRUE(family.passes());
}

std::string refusal(const std::function<void(CloudScene&)>& change) {
  CloudScene s = sunny();
  s.options.deep = true;
  change(s);
  try {
    const Volume v = volume_of(s);
    (void)pvol::plan(std::span(&v, 1), s.scene());
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Deep, RefusesWeightsAndMoreMemoryThanIsSensible) {
  EXPECT_EQ(refusal([](CloudScene&) {}), "");
  EXPECT_TRUE(
      says(refusal([](CloudScene& s) { s.options.tracker = Tracker::weighted_decomposition; }),
           "deep.deep_pictures_count"));
  const auto large = [](int bins, std::uint32_t samples) {
    return [=](CloudScene& s) {
      s.options.width = s.options.height = 8192;
      s.options.deep_bins = bins;
      s.options.samples = samples;
    };
  };
  EXPECT_TRUE(says(refusal(large(64, 1000)), "deep.deep_picture_pixels"));
  EXPECT_EQ(refusal(large(64, 1)), "") << "one sample fills no more than a bin";
  EXPECT_EQ(refusal(large(1, 1000)), "");
  EXPECT_NE(refusal([&](CloudScene& s) {
              large(64, 1)(s);
              s.options.noise = 0.01;
            }),
            "");
}

}  // namespace deep_test
}  // namespace pvol::test
