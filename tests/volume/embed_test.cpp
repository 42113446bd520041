// The calls that other renderers make, against exact optical depths of test fields.
#include "pvol/embed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <thread>

#include "pvol/bounds/pyramid.h"
#include "pvol/trackers.h"

#include "support/oracle.h"
#include "support/statistics.h"

namespace pvol::test {
namespace {

constexpr std::uint64_t kSeed = 20240607;
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr auto kTrilinear = LookUp::trilinear, kNearest = LookUp::nearest;

/// Cell edges of a map, about.
double cell_length(const Affine& to_world) { return std::cbrt(std::abs(determinant(to_world))); }

/// A placement of a field in the world.
struct Placement {
  std::string name;
  Affine to_world;
};

const std::vector<Placement>& placements() {
  Affine turned;
  turned.m = {Vec3d{0.36, 0.48, -0.8}, Vec3d{-0.8, 0.6, 0}, Vec3d{0.48, 0.64, 0.6}};
  turned.t = {3, -70, 11};
  Affine sheared;
  sheared.m = {Vec3d{1, 0.7, -0.2}, Vec3d{0, 0.5, 0.3}, Vec3d{0.1, 0, 2}};
  Affine mirrored = scaling({-1, 1, 3});
  static const std::vector<Placement> all{{"identity", {}},
                                          {"turned", turned},
                                          {"sheared", sheared},
                                          {"mirrored", mirrored},
                                          {"small", scaling(Vec3d(1e-3)) * turned},
                                          {"large", scaling(Vec3d(1e3)) * sheared}};
  return all;
}

/// A field as an embedding renderer hands it over, with its optical depth along rays of the world.
struct Cloud {
  const Field& field;
  Affine to_world;
  double extinction;
  VolumeOptions options;
  Volume volume;

  Cloud(const Field& f, const Affine& placement, double mu, const VolumeOptions& o = {})
      : field(f), to_world(placement), extinction(mu), options(o) {
    const VoxelGrid grid =
        make_grid({.values = f.samples.data(), .size = f.size, .origin = f.origin}, placement);
    volume = make_volume(grid, {.extinction = mu}, o);
  }

  [[nodiscard]] RayOracle oracle(const Ray& ray, double t_max = kFar) const {
    const Affine to_index = inverse(to_world);
    const Vec3d unit = normalize(ray.d);
    return {
        field, options.look_up, {to_index.point(ray.o), to_index.vector(unit)}, extinction, t_max};
  }

  /// A place of the world near density, or anywhere about the cloud.
  [[nodiscard]] Vec3d place_inside(Rng& rng) const {
    return to_world.point(random_point_near_density(field, rng));
  }
  [[nodiscard]] Vec3d place_outside(Rng& rng) const {
    const Vec3d size(field.size);
    const Vec3d centre = Vec3d(field.origin) + size * 0.5;
    return to_world.point(centre + random_direction(rng) * (2 * length(size)));
  }

  [[nodiscard]] static Vec3d random_direction(Rng& rng) {
    for (;;) {
      const auto [a, b] = rng.uniform2();
      const Vec3d d = Vec3d(double(a), double(b), double(rng.uniform())) * 2.0 - Vec3d(1);
      if (length(d) > 0.1 && length(d) < 1) return normalize(d);
    }
  }

  /// A ray of each kind: from outside through the density, from inside, along an axis of the
  /// lattice, and to a t_max inside from inside and from outside.
  struct Aimed {
    Ray ray;
    double t_max;
  };
  [[nodiscard]] Aimed aim(int kind, Rng& rng) const {
    const Vec3d inside = place_inside(rng);
    const Vec3d outside = place_outside(rng);
    switch (kind) {
      case 0:
        return {{outside, normalize(inside - outside)}, kFar};
      case 1:
        return {{inside, random_direction(rng)}, kFar};
      case 2: {
        Vec3d axis;
        axis[int(rng.block().lo % 3)] = rng.block().lo & 1 ? 1 : -1;
        const Vec3d d = normalize(to_world.vector(axis));
        return {{inside - d * (rng.uniform() < 0.5f ? 300 * cell_length(to_world) : 0), d}, kFar};
      }
      default:
        const Vec3d from = kind == 3 ? place_inside(rng) : outside;
        return {{from, normalize(inside - from)}, length(inside - from)};
    }
  }
};
constexpr int kKinds = 5;

/// Fields that take few bricks and differ in everything else.
const std::vector<std::string> kNames{
    "linear", "gaussian", "checkerboard", "contrast", "one_voxel_on_a_border", "sparse", "far"};

/// f(cloud, name) for each of these fields in each placement; its largest depth per voxel is 1/4.
void for_clouds(const std::function<void(const Cloud&, const std::string&)>& f,
                const VolumeOptions& options = {}) {
  for (const std::string& name : kNames) {
    for (const Placement& p : placements()) {
      const Cloud cloud(field(name), p.to_world, 0.25 / cell_length(p.to_world), options);
      f(cloud, name + ", " + p.name);
    }
  }
}

// Grids.

TEST(MakeGrid, HoldsTheSamplesOfADenseArray) {
  const Vec3i size(13, 7, 20), origin(-5, 17, -9);
  std::vector<float> values, x_first(13 * 7 * 20);
  Rng rng(kSeed, 1, 0);
  for (int i = 0; i < size.x; ++i) {
    for (int j = 0; j < size.y; ++j) {
      for (int k = 0; k < size.z; ++k) {
        values.push_back(i < 5 ? 0 : rng.uniform());
        x_first[std::size_t((k * size.y + j) * size.x + i)] = values.back();
      }
    }
  }
  const VoxelGrid grids[] = {make_grid({.values = values.data(), .size = size, .origin = origin}),
                             make_grid({.values = x_first.data(),
                                        .size = size,
                                        .origin = origin,
                                        .stride = Vec3l(1, size.x, size.x * size.y)})};
  for (const VoxelGrid& grid : grids) {
    int wrong = 0;
    for (int i = -4; i < size.x + 12; ++i) {
      for (int j = -12; j < size.y + 12; ++j) {
        for (int k = -12; k < size.z + 12; ++k) {
          const bool inside = i >= 0 && j >= 0 && k >= 0 && i < 13 && j < 7 && k < 20;
          const float expected = inside ? values[std::size_t((i * 7 + j) * 20 + k)] : 0;
          wrong += sample(grid, origin + Vec3i(i, j, k)) != expected;
        }
      }
    }
    EXPECT_EQ(wrong, 0);
    for (const Brick& b : grid.bricks) EXPECT_GE(b.origin.x, 0);
    EXPECT_FALSE(validate(build_pyramid(grid)));
  }
}

TEST(MakeGrid, AsksTheCallerForBricksAndDropsEmptyOnes) {
  const auto fill = [](Vec3i origin, float* values) {
    if (origin.x == 8) values[511] = float(origin.z + 100);
  };
  const VoxelGrid grid = make_grid({-3, 0, -8}, {17, 1, 9}, fill);
  ASSERT_EQ(grid.bricks.size(), 3u);
  for (const int z : {-8, 0, 8}) EXPECT_EQ(sample(grid, {15, 7, z + 7}), float(z + 100));
}

TEST(MakeGrid, RefusesWhatIsNoDensity) {
  std::vector<float> values(27, 1.0f);
  const DenseArray array{.values = values.data(), .size = {3, 3, 3}, .origin = {40, 0, 0}};
  EXPECT_EQ(make_grid(array).bricks.size(), 1u);
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF, -1e-30f}) {
    values[14] = bad;
    try {
      (void)make_grid(array);
      ADD_FAILURE() << bad;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("(41, 1, 2)"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW((void)make_grid({.values = nullptr, .size = {3, 3, 3}}), Error);
  EXPECT_THROW((void)make_grid({.values = values.data(), .size = {3, 0, 3}}), Error);
  EXPECT_THROW((void)make_grid({.values = values.data(), .size = {3, 3, -1}}), Error);
  EXPECT_THROW(
      (void)make_grid({.values = values.data(), .size = {3, 3, 3}, .origin = {0, 1 << 30, 0}}),
      Error);
  const FillBrick fails = [](Vec3i, float*) { throw std::out_of_range("the caller's own"); };
  EXPECT_THROW((void)make_grid({0, 0, 0}, {99, 9, 9}, fails), std::out_of_range);
}

// Rays.

TEST(Embed, RaysThatMissSeeThrough) {
  const Cloud cloud(field("gaussian"), placements()[1].to_world, 1);
  const Vec3d centre = cloud.volume.density.world_box.centre();
  const double radius = length(cloud.volume.density.world_box.extent());
  const Vec3d outside = centre + Vec3d(radius, 0, 0);
  const Field nothing = make_field("nothing", {0, 0, 0}, {9, 9, 9}, [](Vec3i) { return 0; });
  const Cloud empty(nothing, {}, 1);
  const auto expect_miss = [](const Volume& v, const Ray& ray, double t_max) {
    Rng rng(kSeed, 2, 0);
    EXPECT_FALSE(enter(v, ray, t_max));
    EXPECT_FALSE(sample_flight(v, ray, t_max, rng).collided);
    EXPECT_EQ(sample_flight(v, ray, t_max, rng).t, kFar);
    EXPECT_EQ(sample_transmittance(v, ray, t_max, rng), 1);
    EXPECT_EQ(exact_transmittance(v, ray, t_max), 1);
  };
  expect_miss(cloud.volume, {outside, {1, 0, 0}}, kFar);
  expect_miss(cloud.volume, {outside, {-0.0, 0, 1}}, kFar);
  expect_miss(cloud.volume, {outside, {-1, 0, 0}}, 0.1 * radius);
  expect_miss(cloud.volume, {centre, {-1, 0, 0}}, 0);
  expect_miss(cloud.volume, {centre, {-1, 0, 0}}, -1);
  expect_miss(empty.volume, {{4, 4, 4}, {0, 1, 0}}, kFar);
  EXPECT_EQ(density_at(empty.volume, {4, 4, 4}), 0);
}

TEST(Embed, RefusesRaysThatAreNone) {
  const Cloud cloud(field("gaussian"), {}, 1);
  const double nan = std::nan("");
  const Ray bad[] = {{{0, 0, 0}, {0, -0.0, 0}},
                     {{0, 0, 0}, {nan, 0, 1}},
                     {{0, 0, 0}, {kFar, 0, 0}},
                     {{nan, 0, 0}, {1, 0, 0}},
                     {{0, -kFar, 0}, {0, 1, 0}}};
  Rng rng(kSeed, 3, 0);
  for (const Ray& ray : bad) {
    EXPECT_THROW((void)enter(cloud.volume, ray), Error);
    EXPECT_THROW((void)sample_flight(cloud.volume, ray, 1, rng), Error);
  }
  EXPECT_THROW((void)enter(cloud.volume, {{0, 0, 0}, {1, 0, 0}}, nan), Error);
  const Cursor here = enter(cloud.volume, {{0, 0, 0}, {1, 0, 0}})->cursor_at(0);
  EXPECT_THROW((void)resume(cloud.volume, here, {0, 0, 0}), Error);
  EXPECT_THROW((void)sample_transmittance(cloud.volume, {{0, 0, 0}, {1, 0, 0}}, 1, rng,
                                          Transmittance::automatic),
               Error);
}

/// Positions are floats within cells: their error along a ray is some 1e-6 cells, in mu_t and thus
/// in the optical depth of the cells where they count.
constexpr double kRounding = 2e-5;

TEST(Embed, TransmittanceIsThatOfTheWorld) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    Rng rng(kSeed, 4, 0);
    for_clouds(
        [&](const Cloud& cloud, const std::string& name) {
          for (int i = 0; i < 10 * kKinds; ++i) {
            const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
            EXPECT_NEAR(exact_transmittance(cloud.volume, ray, t_max),
                        cloud.oracle(ray, t_max).transmittance(), 10 * kRounding)
                << name << ", ray " << i;
          }
        },
        {.look_up = look_up});
  }
}

TEST(Embed, SegmentsAreInOrderAndBoundTheExtinction) {
  Rng rng(kSeed, 5, 0);
  for_clouds([&](const Cloud& cloud, const std::string& name) {
    for (int i = 0; i < 5 * kKinds; ++i) {
      const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
      const RayOracle oracle = cloud.oracle(ray, t_max);
      auto walk = enter(cloud.volume, ray, t_max);
      ASSERT_TRUE(walk);
      double end = 0, depth = 0;
      while (const auto s = walk->next()) {
        ASSERT_TRUE(end <= s->t0 && s->t0 <= s->t1 && s->t1 <= t_max) << name;
        end = s->t1;
        depth += oracle.optical_depth(s->t1) - oracle.optical_depth(s->t0);
        for (const double x : {0.01, 0.5, 0.99}) {
          const double t = s->t0 + x * (s->t1 - s->t0);
          const double slack = 1e-4 * cloud.extinction;
          const double mu = double(extinction_at(cloud.volume, ray.at(t)));
          EXPECT_NEAR(mu, oracle.extinction(t), slack) << name;
          EXPECT_TRUE(double(s->lo) - slack <= mu && mu <= double(s->hi) + slack) << name;
          // The walk's own point is in the segment's cube, to the last bit.
          visit_field(cloud.volume, [&](const auto& field) {
            NoTally none;
            const float here = field.extinction(*s, walk->point(t), none);
            EXPECT_TRUE(s->lo <= here && here <= s->hi * (1 + 4 * FLT_EPSILON)) << name;
            EXPECT_NEAR(double(here), mu, slack) << name;
          });
        }
      }
      EXPECT_NEAR(depth, oracle.optical_depth(), kRounding * 20) << name;
    }
  });
}

TEST(Embed, LengthIsThatOfTheWorldWhateverThatOfTheDirection) {
  const Cloud cloud(field("gaussian"), placements()[2].to_world, 0.3);
  for (int i = 0; i < 100; ++i) {
    Rng rng(kSeed, 6, std::uint64_t(i));
    const Ray ray = cloud.aim(0, rng).ray;
    const double t_max = length(cloud.volume.density.world_box.centre() - ray.o);
    const double expected = exact_transmittance(cloud.volume, ray, t_max);
    for (const double scale : {1e-9, 0.5, 4096.0}) {
      const Ray longer{ray.o, ray.d * scale};
      EXPECT_NEAR(exact_transmittance(cloud.volume, longer, t_max), expected, 1e-5);
      Rng a = rng, b = rng;
      const Flight f = sample_flight(cloud.volume, longer, t_max, a);
      const Flight g = sample_flight(cloud.volume, ray, t_max, b);
      EXPECT_EQ(f.collided, g.collided);
      if (f.collided && g.collided) {
        EXPECT_NEAR(f.t, g.t, 1e-3);
        EXPECT_LE(f.t, t_max);
      }
    }
  }
}

/// Steps of 1e-6 cells, met from so far that an ulp of the way is longer: t is rounded, the flight
/// is not.
TEST(Embed, TheWayToTheVolumeCostsNoPrecision) {
  const Cloud cloud(field("constant"), {}, 1e6);
  const double away = 0x1p36;  // a direction along an axis moves exactly
  for (int i = 0; i < 2000; ++i) {
    Rng a(kSeed, 7, std::uint64_t(i)), b = a;
    const Flight f = sample_flight(cloud.volume, {{-1, 9.5, 9.5}, {1, 0, 0}}, kFar, a);
    const Flight g = sample_flight(cloud.volume, {{-1 - away, 9.5, 9.5}, {1, 0, 0}}, kFar, b);
    ASSERT_TRUE(f.collided && g.collided);
    ASSERT_EQ(a.block().lo, b.block().lo);  // as many numbers were drawn
    ASSERT_EQ(f.t + away, g.t);
  }
}

// Statistics.

TEST(Embed, FlightsFollowTheExtinction) {
  proof::Family family;
  std::uint64_t stream = 1000;
  for_clouds([&](const Cloud& cloud, const std::string& name) {
    proof::Histogram places(20);
    proof::Moments left;  // over the exact share of each ray
    for (int i = 0; i < 2000; ++i) {
      Rng rng(kSeed, stream, std::uint64_t(i));
      const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
      const RayOracle oracle = cloud.oracle(ray, t_max);
      const Flight f = sample_flight(cloud.volume, ray, t_max, rng);
      ASSERT_EQ(f.weight, 1) << name;
      const double t = oracle.transmittance();
      left.add((f.collided ? 0 : 1) - t);
      if (f.collided) {
        ASSERT_TRUE(f.t >= 0 && f.t <= t_max) << name;
        ASSERT_GT(extinction_at(cloud.volume, ray.at(f.t)) + 1e-5f * float(cloud.extinction), 0);
        places.add(std::clamp(oracle.cdf(f.t) / (1 - t), 0.0, 1.0));
      }
    }
    ++stream;
    family.add(name + ", places", places.uniform_p_value());
    family.add(name + ", left", proof::mean_p_value(left, 0, 1e-6));
  });
  EXPECT_TRUE(family.passes());
}

TEST(Embed, TransmittanceEstimatesFollowBeerAndLambert) {
  proof::Family family;
  std::uint64_t stream = 2000;
  for_clouds([&](const Cloud& cloud, const std::string& name) {
    using enum Transmittance;
    for (const Transmittance estimator : {analog, ratio, residual_ratio, regular}) {
      proof::Moments excess;  // over the exact value, of many rays
      for (int i = 0; i < 800; ++i) {
        Rng rng(kSeed, stream, std::uint64_t(i));
        const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
        const float t = sample_transmittance(cloud.volume, ray, t_max, rng, estimator);
        ASSERT_TRUE(t >= -1e-6f && t <= 1 + 1e-6f) << name;
        excess.add(double(t) - exact_transmittance(cloud.volume, ray, t_max));
      }
      ++stream;
      family.add(name + ", " + std::to_string(int(estimator)),
                 proof::mean_p_value(excess, 0, 1e-6));
    }
  });
  EXPECT_TRUE(family.passes());
}

// Paths.

TEST(Embed, PathsGoOnWhereTheyCollided) {
  proof::Family family;
  for_clouds([&](const Cloud& cloud, const std::string& name) {
    int collisions = 0;
    proof::Moments left;
    for (int i = 0; i < 400; ++i) {
      Rng rng(kSeed, 8, std::uint64_t(i));
      const Ray ray = cloud.aim(0, rng).ray;
      auto walk = enter(cloud.volume, ray);
      visit_field(cloud.volume, [&](const auto& field) {
        NoTally none;
        const Flight f = free_flight<Tracker::decomposition>(*walk, field, rng, none);
        if (!f.collided) return;
        ++collisions;
        const Vec3d on = Cloud::random_direction(rng);
        const double t_max = 10 * cell_length(cloud.to_world);
        const Cursor here = walk->cursor_at(f.t);
        RayWalk next = resume(cloud.volume, here, on, t_max);
        const double t = exact_transmittance(cloud.volume, {ray.at(f.t), on}, t_max);
        if constexpr (CellField<std::remove_cvref_t<decltype(field)>>) {
          EXPECT_NEAR(std::exp(-optical_depth(next, field, none)), t, 2 * kRounding) << name;
        }
        RayWalk again = resume(cloud.volume, here, on, t_max);
        const Flight g = free_flight<Tracker::delta>(again, field, rng, none);
        EXPECT_TRUE(!g.collided || g.t <= t_max);
        left.add((g.collided ? 0 : 1) - t);
      });
    }
    if (collisions > 20) family.add(name, proof::mean_p_value(left, 0, 1e-5));
  });
  EXPECT_TRUE(family.passes());
}

// Look-ups.

TEST(Embed, DensityAtAPointIsThatOfTheField) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    Rng rng(kSeed, 9, 0);
    for_clouds(
        [&](const Cloud& cloud, const std::string& name) {
          for (int i = 0; i < 300; ++i) {
            const Vec3d p = i & 1 ? random_point_near_density(cloud.field, rng)
                                  : Vec3d(cloud.field.origin) +
                                        Vec3d(double(rng.uniform()), double(rng.uniform()),
                                              double(rng.uniform())) *
                                            40.0 -
                                        Vec3d(5);
            // Nearest: off the faces between lattice points, where rounding decides.
            const Vec3d q = look_up == kTrilinear
                                ? p
                                : Vec3d(std::floor(p.x), std::floor(p.y), std::floor(p.z)) +
                                      Vec3d(0.3, 0.6, -0.2);
            const Vec3d world = cloud.to_world.point(q);
            const double expected = density_at(cloud.field, look_up, q);
            EXPECT_NEAR(double(density_at(cloud.volume, world)), expected, 3e-5) << name;
            EXPECT_NEAR(double(extinction_at(cloud.volume, world)), cloud.extinction * expected,
                        3e-5 * cloud.extinction)
                << name;
          }
        },
        {.look_up = look_up});
  }
}

/// The support ends where the octree's root does; beyond it there is nothing.
TEST(Embed, DensityIsZeroBeyondTheBox) {
  const Field cube = make_field("cube", {1, 1, 1}, {31, 31, 31}, [](Vec3i) { return 1; });
  const Cloud cloud(cube, {}, 2);
  EXPECT_EQ(cloud.volume.density.octree.support_hi[0], 32);
  EXPECT_EQ(density_at(cloud.volume, {31.5, 31, 31}), 0.5f);
  EXPECT_EQ(extinction_at(cloud.volume, {31.5, 31, 31}), 1.0f);
  for (const double far : {32.0, 33.0, 1e30, kFar, -kFar, double(std::nanf(""))}) {
    EXPECT_EQ(density_at(cloud.volume, {far, 16, 16}), 0) << far;
    EXPECT_EQ(density_at(cloud.volume, {16, 16, far}), 0) << far;
  }
}

// Options and threads.

/// The flights and transmittances of many rays.
std::vector<double> results(const Cloud& cloud, int begin, int end) {
  std::vector<double> r;
  for (int i = begin; i < end; ++i) {
    Rng rng(kSeed, 10, std::uint64_t(i));
    const auto [ray, t_max] = cloud.aim(i % kKinds, rng);
    r.push_back(sample_flight(cloud.volume, ray, t_max, rng).t);
    for (const auto estimator : {Transmittance::ratio, Transmittance::analog}) {
      r.push_back(double(sample_transmittance(cloud.volume, ray, t_max, rng, estimator)));
    }
    r.push_back(exact_transmittance(cloud.volume, ray, t_max));
  }
  return r;
}

TEST(Embed, MicroBoundsChangeNothing) {
  for (const std::string name : {"gaussian", "contrast", "sparse"}) {
    const auto with = [&](MicroBoundsUse use, int edge) {
      const Cloud cloud(field(name), placements()[1].to_world, 0.5, {.micro_bounds = use});
      EXPECT_EQ(cloud.volume.density.micro.edge, edge);
      return results(cloud, 0, 2000);
    };
    const auto plain = with(MicroBoundsUse::none, 0);
    EXPECT_EQ(with(MicroBoundsUse::cells_8, 2), plain);
    EXPECT_EQ(with(MicroBoundsUse::cells_1, 1), plain);
  }
}

TEST(Embed, DepthIsAnOption) {
  for (const int depth : {0, 1, 16}) {
    const Cloud cloud(field("gaussian"), {}, 0.5, {.depth = depth});
    EXPECT_EQ(cloud.volume.density.octree.depth == 0, depth == 0);
    EXPECT_LE(cloud.volume.density.octree.depth, depth);
  }
}

TEST(Embed, ThreadsShareAVolume) {
  const Cloud cloud(field("sparse"), placements()[1].to_world, 0.5);
  constexpr int kThreads = 4, kEach = 2000;
  std::vector<double> alone = results(cloud, 0, kThreads * kEach), together;
  std::vector<std::vector<double>> parts(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back(
          [&, i] { parts[std::size_t(i)] = results(cloud, i * kEach, (i + 1) * kEach); });
    }
  }
  for (const auto& part : parts) together.insert(together.end(), part.begin(), part.end());
  EXPECT_EQ(together, alone);
}

}  // namespace
}  // namespace pvol::test
