// The calls that other renderers make, against exact optical depths of test fields.
#include "pvol/embed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/trackers.h"
#include "support/messages.h"
#include "support/placed_clouds.h"

namespace pvol::test {
namespace embed_test {

// Rays.

TEST(Embed, RaysThatMissSeeThrough) {
  const PlacedCloud cloud(field("gaussian"), placements()[1].to_world, 1);
  const Vec3d centre = cloud.volume.density.world_box.centre();
  const double radius = length(cloud.volume.density.world_box.extent());
  const Vec3d outside = centre + Vec3d(radius, 0, 0);
  const Field nothing = make_field("nothing", {0, 0, 0}, {9, 9, 9}, [](Vec3i) { return 0; });
  const PlacedCloud empty(nothing, {}, 1);
  const auto expect_miss = [](const Volume& v, const Ray& ray, double t_max) {
    Rng rng(kPlacedSeed, 2, 0);
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

TEST(Embed, RefusesGridsThatAreNoDensity) {
  std::array<float, kBrickSamples> ones, odd;
  ones.fill(1);
  odd.fill(1);
  const auto refused = [](const char* key, const VoxelGrid& grid) {
    try {
      (void)make_volume(grid, {.extinction = 1});
      ADD_FAILURE() << key << ": no error";
    } catch (const Error& e) {
      EXPECT_TRUE(says(e.what(), key));
    }
  };
  const auto of = [](std::vector<Brick> bricks, std::vector<Tile> tiles = {}) {
    VoxelGrid grid;
    grid.bricks = std::move(bricks), grid.tiles = std::move(tiles);
    return grid;
  };
  const float nan = std::nanf("");
  refused("grids.leaf_without_samples", of({{{0, 0, 0}, nullptr}}));
  refused("grids.leaf_between", of({{{0, 4, 0}, ones.data()}}));
  odd[8] = nan;
  refused("grids.sample_nan", of({{{8, 0, 0}, odd.data()}}));
  odd[8] = -1;
  refused("grids.sample_negative", of({{{8, 0, 0}, odd.data()}}));
  refused("grids.tile_nan", of({}, {{{0, 0, 0}, 8, nan}}));
  refused("grids.tile_negative", of({}, {{{0, 0, 0}, 8, -1}}));
  refused("grids.tile_edge", of({}, {{{0, 0, 0}, 9, 1}}));
  refused("grids.tile_between", of({}, {{{0, 0, 8}, 128, 1}}));
  const Brick brick{{8, 8, 0}, ones.data()};
  refused("grids.cubes_overlap", of({brick, {{0, 0, 0}, ones.data()}, brick}));
  refused("grids.cube_in_tile", of({brick}, {{{0, 0, 0}, 128, 1}}));
  refused("grids.tile_in_tile", of({}, {{{8, 0, 0}, 8, 1}, {{0, 0, 0}, 128, 1}}));
}

/// GCC 12 ends where a default of a member is a list of structs and a template makes the member.
TEST(Embed, TemplatesMakeMediaAndVolumes) {
  const auto make = [](auto medium, auto volume) {
    medium = decltype(medium){}, volume = decltype(volume){};
    return medium.components.size() + volume.medium.components.size();
  };
  EXPECT_EQ(make(Medium{}, Volume{}), 2u);
}

TEST(Embed, RefusesRaysThatAreNone) {
  const PlacedCloud cloud(field("gaussian"), {}, 1);
  const double nan = std::nan("");
  const Ray bad[] = {{{0, 0, 0}, {0, -0.0, 0}},
                     {{0, 0, 0}, {nan, 0, 1}},
                     {{0, 0, 0}, {kFar, 0, 0}},
                     {{nan, 0, 0}, {1, 0, 0}},
                     {{0, -kFar, 0}, {0, 1, 0}}};
  Rng rng(kPlacedSeed, 3, 0);
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

TEST(Embed, TransmittanceIsThatOfTheWorld) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    Rng rng(kPlacedSeed, 4, 0);
    for_clouds(
        [&](const PlacedCloud& cloud, const std::string& name) {
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

/// Rays enter as `intersect` and `make_cursor` say, to the last bit, by whatever shorter way.
TEST(Embed, RaysEnterWhereTheBoxIs) {
  for (int place = 0; place < 2; ++place) {
    const PlacedCloud cloud(field("gaussian"), placements()[std::size_t(place)].to_world, 0.5);
    const VolumeField& f = cloud.volume.density;
    const Affine to_world = inverse(f.world_to_cells);
    Rng rng(kPlacedSeed, 8, 0);
    int entered = 0;
    for (int i = 0; i < 4000; ++i) {
      auto [ray, t_max] = cloud.aim(i % kKinds, rng);
      if (i % 7 == 0) ray.d[i % 3] = i & 1 ? 0.0 : -0.0;
      if (i % 11 == 0) ray.o = to_world.point(f.octree.support().lo + Vec3d(i % 2, i % 5, 0));
      if (length(ray.d) == 0) continue;
      const Ray cells{f.world_to_cells.point(ray.o),
                      f.world_to_cells.vector(ray.d / length(ray.d))};
      const auto span = intersect(f.octree.support(), cells, 0, t_max);
      auto walk = enter(cloud.volume, ray, t_max);
      ASSERT_EQ(walk.has_value(), span.has_value());
      if (!span) continue;
      RayWalk expected(f.octree, make_cursor(f.octree, cells.at(span->t0)), cells.d, *span);
      while (const auto s = expected.next()) {
        const auto t = walk->next();
        ASSERT_TRUE(t);
        ASSERT_TRUE(s->t0 == t->t0 && s->t1 == t->t1 && s->hi == t->hi && s->leaf == t->leaf);
        const double middle = 0.5 * (s->t0 + s->t1);
        ASSERT_EQ(position(expected.point(middle)), position(walk->point(middle)));
      }
      ASSERT_FALSE(walk->next());
      ++entered;
    }
    EXPECT_GT(entered, 2000);
  }
}

TEST(Embed, SegmentsAreInOrderAndBoundTheExtinction) {
  Rng rng(kPlacedSeed, 5, 0);
  for_clouds([&](const PlacedCloud& cloud, const std::string& name) {
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
  const PlacedCloud cloud(field("gaussian"), placements()[2].to_world, 0.3);
  for (int i = 0; i < 100; ++i) {
    Rng rng(kPlacedSeed, 6, std::uint64_t(i));
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
  const PlacedCloud cloud(field("constant"), {}, 1e6);
  const double away = 0x1p36;  // a direction along an axis moves exactly
  for (int i = 0; i < 2000; ++i) {
    Rng a(kPlacedSeed, 7, std::uint64_t(i)), b = a;
    const Flight f = sample_flight(cloud.volume, {{-1, 9.5, 9.5}, {1, 0, 0}}, kFar, a);
    const Flight g = sample_flight(cloud.volume, {{-1 - away, 9.5, 9.5}, {1, 0, 0}}, kFar, b);
    ASSERT_TRUE(f.collided && g.collided);
    ASSERT_EQ(a.block().lo, b.block().lo);  // as many numbers were drawn
    ASSERT_EQ(f.t + away, g.t);
  }
}

// Look-ups.

TEST(Embed, DensityAtAPointIsThatOfTheField) {
  for (const LookUp look_up : {kTrilinear, kNearest}) {
    Rng rng(kPlacedSeed, 9, 0);
    for_clouds(
        [&](const PlacedCloud& cloud, const std::string& name) {
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
  const PlacedCloud cloud(cube, {}, 2);
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
std::vector<double> results(const PlacedCloud& cloud, int begin, int end) {
  std::vector<double> r;
  for (int i = begin; i < end; ++i) {
    Rng rng(kPlacedSeed, 10, std::uint64_t(i));
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
      const PlacedCloud cloud(field(name), placements()[1].to_world, 0.5, {.micro_bounds = use});
      EXPECT_EQ(cloud.volume.density.micro.edge, edge);
      return results(cloud, 0, 2000);
    };
    const auto plain = with(MicroBoundsUse::none, 0);
    EXPECT_EQ(with(MicroBoundsUse::edge_2, 2), plain);
    EXPECT_EQ(with(MicroBoundsUse::edge_1, 1), plain);
    EXPECT_EQ(with(MicroBoundsUse::codes, 0), plain);
  }
}

TEST(Embed, DepthIsAnOption) {
  for (const int depth : {0, 1, 16}) {
    const PlacedCloud cloud(field("gaussian"), {}, 0.5, {.depth = depth});
    EXPECT_EQ(cloud.volume.density.octree.depth == 0, depth == 0);
    EXPECT_LE(cloud.volume.density.octree.depth, depth);
  }
}

TEST(Embed, ThreadsShareAVolume) {
  const PlacedCloud cloud(field("sparse"), placements()[1].to_world, 0.5);
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

}  // namespace embed_test
}  // namespace pvol::test
