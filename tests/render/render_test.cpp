// Whole images: determinism, extremes, and what is refused.
#include "pvol/render/render.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <vector>

#include "pvol/error.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol {
namespace render_test {

using std::numbers::pi;
using test::cloud;
using test::cloud_scene;
using test::CloudScene;
using test::cube_of_leaves;
using test::run;
using test::same_bytes;

constexpr Tracker kTrackers[] = {Tracker::delta_global, Tracker::delta, Tracker::decomposition};

TEST(Render, AnyNumberOfThreadsGivesTheSameBytes) {
  CloudScene s = cloud_scene();
  s.options.width = 40;
  s.options.height = 24;
  s.options.samples = 20;
  s.options.count = true;
  s.options.threads = 1;
  const RenderResult one = run(cloud(), s);
  for (const int threads : {2, 7}) {
    s.options.threads = threads;
    const RenderResult many = run(cloud(), s);
    EXPECT_TRUE(same_bytes(one.film, many.film)) << threads;
    EXPECT_EQ(one.counts, many.counts) << threads;
  }
  ++s.options.seed;
  EXPECT_FALSE(same_bytes(one.film, run(cloud(), s).film));
}

TEST(Render, CountingChangesNothing) {
  CloudScene s = cloud_scene();
  const Film plain = run(cloud(), s).film;
  s.options.count = true;
  const RenderResult counted = run(cloud(), s);
  EXPECT_TRUE(same_bytes(plain, counted.film));
  EXPECT_GT(counted.counts.path.lookups, 0u);
  EXPECT_GT(counted.counts.collisions, 0u);
  EXPECT_GT(counted.counts.shadow_rays, 0u);
}

TEST(Render, WithoutCountingCountsStayZero) {
  CloudScene s = cloud_scene();
  const std::vector<Volume> volumes(2, make_volume(cloud().grid, build_pyramid(cloud().grid), s));
  for (const std::size_t count : {1u, 2u}) {
    const RenderResult r = render(std::span(volumes).first(count), s);
    EXPECT_EQ(r.counts, Counts{}) << count;
    EXPECT_TRUE(r.film.counts.empty()) << count;
  }
}

TEST(Render, ACropHoldsThePixelsOfTheWhole) {
  CloudScene s = cloud_scene();
  const Film whole = run(cloud(), s).film;
  s.options.crop_x = 3, s.options.crop_y = 2, s.options.crop_width = 5, s.options.crop_height = 7;
  const Film crop = run(cloud(), s).film;
  ASSERT_EQ(crop.pixels.size(), 35u);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 5; ++x) EXPECT_EQ(crop.at(x, y).sum, whole.at(x + 3, y + 2).sum);
  }
}

TEST(Render, WithoutBackgroundOnlyScatteredLightIsLeft) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.5f)};
  s.options.max_bounces = 0;
  const Film with = run(cloud(), s).film;
  s.options.background = false;
  const Film without = run(cloud(), s).film;
  for (std::size_t i = 0; i < with.pixels.size(); ++i) {
    const PixelSums &a = with.pixels[i], &b = without.pixels[i];
    EXPECT_EQ(b.sum, Vec3d(0.0));
    EXPECT_EQ(a.sum, Vec3d(0.5 * (a.samples - a.alpha)));
    EXPECT_EQ(a.alpha, b.alpha);
  }
}

TEST(Render, ExtremesGiveFiniteImages) {
  CloudScene s = cloud_scene();
  s.options.samples = 2;
  s.medium.albedo = Rgb(0.5f);
  struct Case {
    const test::Field& field;
    double extinction;
  };
  // Where a leaf holds empty space beside density, its majorant costs a null collision per unit of
  // optical depth in between: the extreme depth is for a cloud that fills its box.
  for (const auto& [field, extinction] :
       {Case{cloud(), 0}, Case{cloud(), 1e-30}, Case{cloud(), 1e-12}, Case{cloud(), 1e3},
        Case{cube_of_leaves(), 1e7}}) {
    for (const double g : {-0.9999, 0.9999}) {
      for (const Tracker tracker : kTrackers) {
        s.medium.extinction = extinction;
        s.medium.g = g;
        s.options.tracker = tracker;
        for (const PixelSums& p : run(field, s).film.pixels) {
          EXPECT_TRUE(is_finite(p.sum));
          if (extinction < 1e-20) {
            EXPECT_EQ(p.alpha, 0);
          }
        }
      }
    }
  }
}

TEST(Render, ACameraInsideTheCloudAndOneFarAwayWork) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.environment = ConstantSky{Rgb(1.0f)};
  for (const Vec3d position : {Vec3d(0, 0, 0), Vec3d(0, 0, 10), Vec3d(0, 0, 1e7)}) {
    s.camera.position = position;
    s.camera.target = position + Vec3d(0, 0, -1);
    s.camera.fov = position.z > 1e6 ? 1e-4 : 60;
    const Film film = run(cloud(), s).film;
    double alpha = 0;
    for (const PixelSums& p : film.pixels) {
      EXPECT_EQ(mean(p), Vec3d(1.0));
      alpha += p.alpha / p.samples / double(film.pixels.size());
    }
    EXPECT_GT(alpha, 0.5);
  }
}

TEST(Render, AnEmptyCloudShowsTheSky) {
  const test::Field empty =
      test::make_field("empty", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; });
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.25f)};
  using Lights = std::vector<Light>;
  for (const Lights& lights : {Lights{}, Lights{Sun{}}, Lights{PointLight{}, Sun{}}}) {
    s.lights = lights;
    for (const PixelSums& p : run(empty, s).film.pixels) {
      EXPECT_EQ(mean(p), Vec3d(0.25));
      EXPECT_EQ(p.alpha, 0);
    }
  }
}

/// Sums of samples keep far more digits than the samples.
TEST(Render, ManySamplesLoseNoDigits) {
  const test::Field empty =
      test::make_field("empty", {0, 0, 0}, {3, 3, 3}, [](Vec3i) { return 0.0; });
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.1f)};
  s.options.width = s.options.height = 2;
  s.options.samples = 100'000;
  for (const PixelSums& p : run(empty, s).film.pixels) {
    EXPECT_NEAR(mean(p).x / double(0.1f), 1, 1e-11);
    EXPECT_LE(variance_of_mean(p).x, 1e-16);
  }
}

TEST(Render, StoppingKeepsWhatIsDone) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 64;
  const Volume volume = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const RenderResult r =
      render(volume, s, [](std::uint64_t done, std::uint64_t total) { return done * 3 < total; });
  EXPECT_FALSE(r.complete);
  std::uint64_t samples = 0;
  for (const PixelSums& p : r.film.pixels) samples += p.samples;
  EXPECT_GT(samples, 0u);
  EXPECT_LT(samples, 64u * 64u * s.options.samples);
}

TEST(Render, OptionsOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    CloudScene s = cloud_scene();
    change(s);
    EXPECT_THROW((void)run(cloud(), s), Error);
  };
  refused([](CloudScene& s) { s.options.width = 0; });
  refused([](CloudScene& s) { s.options.crop_x = 12; });
  refused([](CloudScene& s) { s.options.crop_width = 13; });
  refused([](CloudScene& s) { s.options.samples = 0; });
  refused([](CloudScene& s) { s.camera.fov = 180; });
  refused([](CloudScene& s) { s.camera.target = s.camera.position; });
  refused([](CloudScene& s) { s.camera.up = s.camera.target - s.camera.position; });
  refused([](CloudScene& s) { s.medium.albedo.y = 1.01f; });
  refused([](CloudScene& s) { s.medium.albedo.z = std::nanf(""); });
  refused([](CloudScene& s) { s.medium.g = 1; });
  refused([](CloudScene& s) { s.medium.g = std::nan(""); });
  refused([](CloudScene& s) { s.medium.extinction = -1; });
  refused([](CloudScene& s) { s.medium.extinction = 1e39; });
  refused([](CloudScene& s) { s.medium.extinction = 2e12; });
  refused([](CloudScene& s) { s.medium.object_to_world = scaling({1, 0, 1}); });
  refused([](CloudScene& s) { s.medium.object_to_world.t.x = 1e14; });
  refused([](CloudScene& s) { s.medium.object_to_world = scaling(Vec3d(1e-39)); });
  refused([](CloudScene& s) { s.environment = ConstantSky{Rgb(-1.0f)}; });
  refused([](CloudScene& s) {
    s.environment = ImageSky{2, 2, std::vector<Rgb>(3, Rgb(1.0f)), Rgb(1.0f), 0};
  });
  refused([](CloudScene& s) {
    GradientSky sky;
    sky.up = Vec3d(0.0);
    s.environment = sky;
  });
  refused([](CloudScene& s) { std::get<Sun>(s.lights[0]).direction = Vec3d(0.0); });
  refused([](CloudScene& s) { std::get<Sun>(s.lights[0]).angle = 0.001; });
  refused([](CloudScene& s) { std::get<Sun>(s.lights[0]).irradiance = Rgb(-1.0f); });
}

TEST(Render, BoundsOfAnotherDensityAreRefused) {
  const test::Field denser = test::make_field("denser", cloud().origin, cloud().size,
                                              [](Vec3i p) { return 1.1 * double(cloud().at(p)); });
  const CloudScene s = cloud_scene();
  EXPECT_THROW((void)make_volume(denser.grid, build_pyramid(cloud().grid), s), Error);
}

TEST(Render, BoxesAndUniformCubesThatDoNotHoldAreRefused) {
  const CloudScene s = cloud_scene();
  Pyramid small = build_pyramid(cloud().grid);
  small.support_hi.x -= 1;
  EXPECT_THROW((void)make_volume(cloud().grid, small, s), Error);

  VoxelGrid tile;
  tile.tiles = {{{0, 0, 0}, 128, 1.0f}};
  Pyramid uniform = build_pyramid(tile);
  EXPECT_NO_THROW((void)make_volume(tile, uniform, s));
  for (std::size_t level = 1; level < uniform.levels.size(); ++level) {
    for (std::size_t i = 0; i < uniform.levels[level].size(); ++i) {
      if (is_uniform(uniform, level, i)) uniform.levels[level][i].hi = 0.5f;
    }
  }
  EXPECT_THROW((void)make_volume(tile, uniform, s), Error);
}

TEST(Render, SeveralVolumesAreSeenFromFarAsOneIs) {
  // At this distance the steps between float directions are some cells wide.
  CloudScene s = cloud_scene();
  s.camera.position = {0, 0, 1e8};
  s.camera.fov = 1.6e-5;
  s.options.samples = 16;
  s.options.kernel = KernelKind::scalar;  // which several volumes take
  const std::vector<Volume> volumes{make_volume(cloud().grid, build_pyramid(cloud().grid), s),
                                    make_volume(VoxelGrid{}, Pyramid{}, s)};
  const Film one = render(volumes.front(), s).film, two = render(volumes, s).film;
  // The share of a pixel that the cloud covers does not depend on what is sampled in the cloud.
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    EXPECT_EQ(one.pixels[i].alpha > 0, two.pixels[i].alpha > 0) << i;
  }
  EXPECT_EQ(render(volumes, s).counts, Counts{});
}

TEST(Render, AVolumeMadeForAnotherSceneIsRefused) {
  CloudScene s = cloud_scene();
  const Volume volume = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  CloudScene other = s;
  other.medium.extinction *= 2;
  EXPECT_THROW((void)render(volume, other), Error);
  other = s;
  other.options.tracker = Tracker::delta_global;
  EXPECT_THROW((void)render(volume, other), Error);
  other = s;
  other.options.look_up = LookUp::nearest;
  EXPECT_THROW((void)render(volume, other), Error);
}

TEST(Render, AFramedCameraSeesTheWholeBox) {
  for (const double aspect : {0.5, 1.0, 2.0}) {
    const Box box{{-3, 10, -50}, {5, 12, -20}};
    const Camera c = frame(box, aspect);
    const Vec3d forward = normalize(c.target - c.position);
    const Vec3d right = normalize(cross(forward, c.up)), up = cross(right, forward);
    const double half_height = std::tan(c.fov / 360 * pi);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p = Vec3d(corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                            corner & 4 ? box.hi.z : box.lo.z) -
                      c.position;
      EXPECT_LT(std::abs(dot(p, up)), half_height * dot(p, forward));
      EXPECT_LT(std::abs(dot(p, right)), aspect * half_height * dot(p, forward));
    }
  }
}

/// Samples of a pixel are numbered: parts of them add up to the whole picture, to rounding.
TEST(Render, PartsOfTheSamplesAddUpToTheWhole) {
  CloudScene s = cloud_scene();
  s.options.samples = 40;
  const Volume volume = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const Film whole = render(volume, s).film;
  Film parts;
  for (const std::uint32_t begin : {0u, 17u, 33u}) {
    s.options.first_sample = begin;
    s.options.samples = begin == 0 ? 17 : begin == 17 ? 16 : 7;
    const Film part = render(volume, s).film;
    if (begin == 0) {
      parts = part;
    } else {
      add_samples(parts, part);
    }
  }
  for (std::size_t i = 0; i < whole.pixels.size(); ++i) {
    const PixelSums &a = whole.pixels[i], &b = parts.pixels[i];
    ASSERT_EQ(a.samples, b.samples);
    ASSERT_EQ(a.alpha, b.alpha);
    ASSERT_LE(length(a.sum - b.sum), 1e-12 * length(a.sum));
    ASSERT_LE(length(a.sum_squares - b.sum_squares), 1e-12 * length(a.sum_squares));
  }
  s.options.first_sample = 4294967290u;
  EXPECT_THROW((void)render(volume, s), Error);
}

/// Scatters for ever, nearly: 10^8 free paths thick and without absorption.
CloudScene endless_scene() {
  CloudScene s = cloud_scene();
  s.medium.extinction = 1e7;
  s.medium.albedo = Rgb(1.0f);
  s.options.samples = 16;
  return s;
}

TEST(Render, StopsWithinAPath) {
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    CloudScene s = endless_scene();
    s.options.guide = guide;
    const Volume v = make_volume(cube_of_leaves().grid, build_pyramid(cube_of_leaves().grid), s);
    const RenderResult r = render(v, s, [](std::uint64_t, std::uint64_t) { return false; });
    EXPECT_FALSE(r.complete);
  }
}

/// Empty but for two voxels far from each other, under one majorant: a camera ray meets 10^14 null
/// collisions.
TEST(Render, StopsWithinAFlight) {
  const test::Field f = test::make_field("stray", {0, 0, 0}, {64, 64, 64}, [](Vec3i p) {
    return p == Vec3i(0) || p == Vec3i(63) ? 1.0 : 0.0;
  });
  for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
    CloudScene s = cloud_scene();
    s.camera = {.position = {32, 33, 200}, .target = {32, 33, 0}, .fov = 10};
    s.medium.extinction = 1e12;
    s.options.depth = 0;
    s.options.guide = guide;
    const Volume v = make_volume(f.grid, build_pyramid(f.grid), s);
    const RenderResult r = render(v, s, [](std::uint64_t, std::uint64_t) { return false; });
    EXPECT_FALSE(r.complete);
  }
}

TEST(Render, ThrowsWhatProgressThrowsHoweverLongPathsAre) {
  const CloudScene s = endless_scene();
  const Volume v = make_volume(cube_of_leaves().grid, build_pyramid(cube_of_leaves().grid), s);
  EXPECT_THROW((void)render(v, s, [](std::uint64_t, std::uint64_t) -> bool { throw Error("no"); }),
               Error);
}

TEST(Render, StoppedPictureHasSamplesEverywhere) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 64;
  const std::uint64_t pixels = 64 * 64;
  const RenderResult r = render(make_volume(cloud().grid, build_pyramid(cloud().grid), s), s,
                                [&](std::uint64_t done, std::uint64_t) { return done < pixels; });
  EXPECT_FALSE(r.complete);
  std::uint64_t samples = 0;
  for (const PixelSums& p : r.film.pixels) {
    EXPECT_GE(p.samples, 1u);
    samples += p.samples;
  }
  EXPECT_LT(samples, pixels * s.options.samples);
}

/// Resident memory of this process in bytes.
double resident_bytes() {
  std::ifstream in("/proc/self/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * double(sysconf(_SC_PAGESIZE));
}

/// As a service renders thumbnails: with progress, guided and not.
TEST(Render, ThousandsOfTinyRendersDoNotGrow) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 1;
  s.options.samples = 1;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  double early = 0;
  const int renders = proof::runs_all() ? 100'000 : 4000;
  for (int i = 0; i < renders; ++i) {
    if (i == renders / 5) early = resident_bytes();
    const bool cancellable = i % 8 == 0;
    const RenderResult r = cancellable
                               ? render(v, s, [](std::uint64_t, std::uint64_t) { return true; })
                               : render(v, s);
    ASSERT_EQ(r.film.pixels[0].samples, 1u);
  }
  EXPECT_LT(resident_bytes() - early, proof::runs_all() ? 4e6 : 8e5);
}

/// Between passes the film is whole: as many samples everywhere, those of a shorter render.
TEST(Render, HandsOutWholePictures) {
  CloudScene s = cloud_scene();
  s.options.guide = GuideUse::off;  // which else may depend on the number of samples
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  std::vector<Film> seen;
  Scene scene = s.scene();
  scene.options.kernel = test::kernel_for(std::span(&v, 1), scene);
  scene.options.seed = proof::seeded(scene.options.seed);
  const RenderPlan p = plan(std::span(&v, 1), scene, {.force = true, .forecast = false});
  const RenderResult whole = render(p, {}, [&](const Film& film) { seen.push_back(film); });
  ASSERT_GE(seen.size(), 2u);
  std::uint32_t last = 0;
  for (const Film& film : seen) {
    const std::uint32_t n = film.pixels.front().samples;
    EXPECT_GT(n, last);
    EXPECT_LT(n, s.options.samples) << "the last one is the result";
    last = n;
    CloudScene shorter = s;
    shorter.options.samples = n;
    const Film same = render(v, shorter).film;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      ASSERT_EQ(film.pixels[i].samples, n);
      ASSERT_EQ(film.pixels[i].sum, same.pixels[i].sum);
    }
  }
  EXPECT_THROW((void)render(p, {}, [](const Film&) { throw Error("enough"); }), Error);
}

}  // namespace render_test
}  // namespace pvol
