// Whole images: closed forms, agreement of trackers and estimators, determinism, extremes.
#include "pvol/render/render.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <string>

#include "pvol/error.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/statistics.h"

namespace pvol {
namespace {

using test::CloudScene;

using std::numbers::pi;

constexpr Tracker kTrackers[] = {Tracker::delta_global, Tracker::delta, Tracker::decomposition};
constexpr Transmittance kEstimators[] = {Transmittance::ratio, Transmittance::analog};

/// A blob of 20 voxels across with values between 0.05 and 1, in front of the camera.
const test::Field& cloud() {
  static const test::Field f =
      test::make_field("cloud", {-12, -12, -12}, {24, 24, 24}, [](Vec3i p) {
        const double r2 = dot(Vec3d(p), Vec3d(p)) / 100;
        const bool hole = (p.x >> 2 ^ p.y >> 2 ^ p.z >> 2) & 1;
        return r2 > 1 ? 0.0 : (hole ? 0.05 : 1.0) * (1 - 0.5 * r2);
      });
  return f;
}

/// 16^3 samples of density 1: with the nearest interpolation, a cube [-0.5, 15.5]^3 of mu =
/// extinction.
const test::Field& cube() {
  static const test::Field f =
      test::make_field("cube", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}

CloudScene cloud_scene() {
  CloudScene s;
  s.camera.position = {5, 8, 60};
  s.camera.target = {0, 0, 0};
  s.camera.fov = 24;
  s.medium.extinction = 0.6;
  s.medium.albedo = Rgb(0.9f, 0.95f, 0.99f);
  s.medium.g = 0.7;
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.options.width = 12;
  s.options.height = 12;
  s.options.samples = 64;
  s.options.threads = 2;
  return s;
}

RenderResult run(const test::Field& field, const CloudScene& scene) {
  return render(make_volume(field.grid, build_pyramid(field.grid), scene), scene);
}

/// Mean of a channel over the image, and its standard error squared.
struct Estimate {
  double mean = 0, variance = 0;
};

Estimate image_mean(const Film& film, int channel) {
  Estimate e;
  for (const PixelSums& p : film.pixels) {
    e.mean += mean(p)[channel];
    e.variance += variance_of_mean(p)[channel];
  }
  const double n = double(film.pixels.size());
  return {e.mean / n, e.variance / (n * n)};
}

/// The same of green over the 4 x 4 pixels from (x, y): enough samples for a normal distribution.
Estimate block_mean(const Film& film, int x, int y) {
  Estimate e;
  for (int k = 0; k < 16; ++k) {
    const PixelSums& p = film.at(x + k % 4, y + k / 4);
    e.mean += mean(p).y / 16;
    e.variance += variance_of_mean(p).y / 256;
  }
  return e;
}

double p_value(const Estimate& a, const Estimate& b) {
  return proof::normal_p_value((a.mean - b.mean) / std::sqrt(a.variance + b.variance));
}

double p_value(const Estimate& a, double expected) { return p_value(a, Estimate{expected, 0}); }

bool same_bytes(const Film& a, const Film& b) {
  if (a.pixels.size() != b.pixels.size()) return false;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const PixelSums &p = a.pixels[i], &q = b.pixels[i];
    for (int c = 0; c < 3; ++c) {
      if (std::bit_cast<std::uint64_t>(p.sum[c]) != std::bit_cast<std::uint64_t>(q.sum[c]) ||
          std::bit_cast<std::uint64_t>(p.sum_squares[c]) !=
              std::bit_cast<std::uint64_t>(q.sum_squares[c])) {
        return false;
      }
    }
    if (p.alpha != q.alpha || p.samples != q.samples) return false;
  }
  return true;
}

/// Every path in a cloud of albedo 1 ends in the sky with its throughput untouched.
TEST(Render, WhiteFurnaceIsExactInEveryPixel) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.environment = ConstantSky{Rgb(0.5f, 0.25f, 2.0f)};
  s.medium.albedo = Rgb(1.0f);
  s.options.samples = 8;
  for (const Tracker tracker : kTrackers) {
    for (const LookUp look_up : {LookUp::nearest, LookUp::trilinear}) {
      for (const double g : {-0.9999, 0.0, 0.9999}) {
        s.options.tracker = tracker;
        s.options.look_up = look_up;
        s.medium.g = g;
        for (const PixelSums& p : run(cloud(), s).film.pixels) {
          EXPECT_EQ(mean(p), Vec3d(0.5, 0.25, 2.0));
        }
      }
    }
  }
}

/// Two suns that fill a hemisphere each are a constant sky: next-event estimation and the balance
/// heuristic against a closed form, for forward, isotropic and backward phase functions.
TEST(Render, WhiteFurnaceOfTwoHemisphericalSuns) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.albedo = Rgb(1.0f);
  const double angle = 179.9;
  const double sine = std::sin(angle / 2 * pi / 180);
  const float irradiance = float(0.7 * pi * sine * sine);  // radiance 0.7
  s.lights = {Sun{{1, 2, 3}, Rgb(irradiance), angle}, Sun{{-1, -2, -3}, Rgb(irradiance), angle}};
  proof::Family family;
  for (const Transmittance estimator : kEstimators) {
    for (const double g : {-0.8, 0.0, 0.95}) {
      s.options.transmittance = estimator;
      s.medium.g = g;
      // The ring between the two discs is 0.1 degrees wide: 0.09 % of the sphere.
      const double expected = 0.7 * (1 - std::cos(angle / 2 * pi / 180));
      family.add("g = " + std::to_string(g),
                 p_value(image_mean(run(cloud(), s).film, 0), expected));
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A constant picture as sky is sampled by next-event estimation, too.
TEST(Render, WhiteFurnaceOfAPicture) {
  CloudScene s = cloud_scene();
  s.lights.clear();
  s.medium.albedo = Rgb(1.0f);
  s.environment = ImageSky{8, 4, std::vector<Rgb>(32, Rgb(0.8f)), Rgb(1.0f), 30};
  proof::Family family;
  for (const double g : {-0.5, 0.0, 0.9}) {
    s.medium.g = g;
    family.add("g = " + std::to_string(g),
               p_value(image_mean(run(cloud(), s).film, 1), double(0.8f)));
  }
  EXPECT_TRUE(family.passes());
}

/// A camera far away that sees the middle of the cube's front face, along -z.
CloudScene cube_scene(double extinction) {
  CloudScene s;
  s.camera.position = {7.5, 7.5, 4000};
  s.camera.target = {7.5, 7.5, 0};
  s.camera.fov = 0.02;
  s.environment = ConstantSky{Rgb(0.0f)};
  s.medium.extinction = extinction;
  s.medium.g = 0;
  s.options.width = s.options.height = 4;
  s.options.samples = 4000;
  s.options.look_up = LookUp::nearest;
  return s;
}

TEST(Render, AbsorptionFollowsBeerAndLambert) {
  proof::Family family;
  for (const double extinction : {1e-12, 0.001, 0.02, 0.3}) {
    CloudScene s = cube_scene(extinction);
    s.medium.albedo = Rgb(0.0f);
    s.environment = ConstantSky{Rgb(2.0f)};
    for (const Tracker tracker : kTrackers) {
      s.options.tracker = tracker;
      const Film film = run(cube(), s).film;
      const double transmittance = std::exp(-16 * extinction);
      const Estimate e = image_mean(film, 0);
      if (e.variance == 0) {  // no path collided
        EXPECT_NEAR(e.mean, 2 * transmittance, 1e-9);
      } else {
        family.add("extinction " + std::to_string(extinction), p_value(e, 2 * transmittance));
      }
      double alpha = 0;
      for (const PixelSums& p : film.pixels) alpha += p.alpha / p.samples / 16;
      EXPECT_NEAR(alpha, 1 - e.mean / 2, 1e-12);
    }
  }
  EXPECT_TRUE(family.passes());
}

/// L = albedo E / (4 pi) exp(-mu h) (1 - exp(-mu D)): light from above passes h = 8 of the cube to
/// reach the view ray, which is D = 16 long.
TEST(Render, SingleScatteringHasItsClosedForm) {
  proof::Family family;
  for (const double extinction : {0.01, 0.1, 0.4}) {
    CloudScene s = cube_scene(extinction);
    s.medium.albedo = Rgb(0.8f);
    s.lights = {Sun{{0, 1, 0}, Rgb(5.0f), 0}};
    s.options.max_bounces = 1;
    const double expected =
        double(0.8f) * 5 / (4 * pi) * std::exp(-8 * extinction) * (1 - std::exp(-16 * extinction));
    for (const Transmittance estimator : kEstimators) {
      s.options.transmittance = estimator;
      family.add("extinction " + std::to_string(extinction),
                 p_value(image_mean(run(cube(), s).film, 2), expected));
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(Render, TrackersAndEstimatorsAgree) {
  CloudScene s = cloud_scene();
  s.options.samples = 256;
  s.lights.push_back(Sun{{-1, 0.2, 0.1}, Rgb(2.0f, 1.0f, 0.5f), 25});
  std::vector<Film> films;
  for (const Tracker tracker : kTrackers) {
    for (const Transmittance estimator : kEstimators) {
      for (const std::optional<int> depth : {std::optional<int>(), std::optional<int>(1)}) {
        s.options.tracker = tracker;
        s.options.transmittance = estimator;
        s.options.depth = depth;
        ++s.options.seed;
        films.push_back(run(cloud(), s).film);
      }
    }
  }
  proof::Family family;
  for (std::size_t i = 1; i < films.size(); ++i) {
    family.add(std::to_string(i), p_value(image_mean(films[0], 0), image_mean(films[i], 0)));
    for (int block = 0; block < 9; ++block) {
      const int x = 4 * (block % 3), y = 4 * (block / 3);
      family.add("image " + std::to_string(i) + " block " + std::to_string(block),
                 p_value(block_mean(films[0], x, y), block_mean(films[i], x, y)));
    }
  }
  EXPECT_TRUE(family.passes());
}

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

/// Instances scaled, moved or mirrored with their camera and lights look the same; the optical
/// depth scales with the size unless the extinction is divided by it.
TEST(Render, PlacementInTheWorldChangesNothing) {
  const CloudScene s = cloud_scene();
  const Estimate reference = image_mean(run(cloud(), s).film, 1);
  proof::Family family;
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double mirror : {1.0, -1.0}) {
      Affine a = scaling(Vec3d(mirror * scale, scale, scale));
      a.t = Vec3d(7, -3, 11) * scale;
      CloudScene placed = s;
      placed.medium.object_to_world = a;
      placed.medium.extinction = s.medium.extinction / scale;
      placed.camera.position = a.point(s.camera.position);
      placed.camera.target = a.point(s.camera.target);
      std::get<Sun>(placed.lights[0]).direction = a.vector(std::get<Sun>(s.lights[0]).direction);
      placed.options.seed = 7;
      family.add("scale " + std::to_string(scale * mirror),
                 p_value(reference, image_mean(run(cloud(), placed).film, 1)));
    }
  }
  EXPECT_TRUE(family.passes());
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
        Case{cube(), 1e7}}) {
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
  s.lights.clear();
  s.environment = ConstantSky{Rgb(0.25f)};
  for (const PixelSums& p : run(empty, s).film.pixels) {
    EXPECT_EQ(mean(p), Vec3d(0.25));
    EXPECT_EQ(p.alpha, 0);
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

}  // namespace
}  // namespace pvol
