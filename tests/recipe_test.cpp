#include "pvol/medium/recipe.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <random>
#include <unordered_map>

#include "pvol/error.h"
#include "pvol/medium/cumulus.h"

namespace pvol {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
Vec3d point_in(Random& random, const Box& b) {
  return {uniform(random, b.lo.x, b.hi.x), uniform(random, b.lo.y, b.hi.y),
          uniform(random, b.lo.z, b.hi.z)};
}

FreeForm ball(Vec3d centre, double radius) {
  return {0.5 * radius * ellipsoid(centre, Vec3d(radius)), {}};
}

/// Large smooth inside, bulge and dent, cut, noise of both kinds, one of them masked.
Recipe make_sample() {
  Recipe r;
  r.voxel = 0.05;
  r.density = 0.7;
  r.edge = 0.05;
  r.forms = {ball({0, 0, 0}, 1), ball({0.9, 0.2, 0.1}, 0.6), ball({-0.3, 1, -0.2}, 0.5)};
  r.forms[0].perturbations = {{ellipsoid({0, 0, 1}, Vec3d(0.5)), 0.3},
                              {ellipsoid({0, 0, -1}, Vec3d(0.5)), -0.3}};
  r.cuts = {{2.0 * half_space({0, -0.5, 0}, {0.1, 1, 0}), {}}};
  r.displacements = {{{1, 0.3, 4, 0.5, true}, 0.1},
                     {{2, 0.4, 3, 0.5, false}, 0.1, half_space({0, 0.5, 0}, {0, -1, 0})}};
  return r;
}

/// One form with a mixed term, no noise.
Recipe make_plain() {
  Recipe r;
  r.voxel = 0.04;
  Affine turn;
  turn.m = {Vec3d{0.6, -0.8, 0}, Vec3d{0.8, 0.6, 0}, Vec3d{0, 0, 1}};
  r.forms = {{0.1 * ellipsoid({5, -3, 2}, {0.2, 0.9, 1.3}, turn), {}}};
  return r;
}

Recipe make_small_cumulus() {
  Cumulus c;
  c.towers = 3;
  c.generations = 2;
  Recipe r = make_recipe(c);
  r.voxel = voxel_for(r, 60);
  return r;
}

const Recipe kRecipes[] = {make_sample(), make_plain(), make_small_cumulus()};

std::uint64_t key(Vec3i at) {
  const auto bits = [](std::int32_t v) { return std::uint64_t(v + (1 << 20)); };
  return bits(at.x) << 42 | bits(at.y) << 21 | bits(at.z);
}

/// All samples of a grid that are not 0; a sample given twice is a failure.
std::unordered_map<std::uint64_t, float> samples_of(const VoxelGrid& grid) {
  std::unordered_map<std::uint64_t, float> samples;
  const auto put = [&](Vec3i at, float v) {
    if (v != 0) {
      EXPECT_TRUE(samples.emplace(key(at), v).second);
    }
  };
  for (const Brick& b : grid.bricks) {
    for (int n = 0; n < kBrickSamples; ++n) {
      put(b.origin + Vec3i{n / 64, n / 8 % 8, n % 8}, b.values[n]);
    }
  }
  for (const Tile& t : grid.tiles) {
    for (int n = 0; n < t.edge * t.edge * t.edge; ++n) {
      put(t.origin + Vec3i{n / t.edge / t.edge, n / t.edge % t.edge, n % t.edge}, t.value);
    }
  }
  return samples;
}

TEST(Recipe, GridHoldsExactlyTheSamplesOfTheDensity) {
  for (const Recipe& r : kRecipes) {
    const VoxelGrid grid = make_grid(r);
    auto samples = samples_of(grid);
    ASSERT_GT(samples.size(), 1000u);
    const Box b = support(r);
    const auto first = [&](double x) { return int(std::floor(x / r.voxel)) - 4; };
    const auto last = [&](double x) { return int(std::ceil(x / r.voxel)) + 4; };
    std::size_t wrong = 0;
    for (int i = first(b.lo.x); i <= last(b.hi.x); ++i) {
      for (int j = first(b.lo.y); j <= last(b.hi.y); ++j) {
        for (int k = first(b.lo.z); k <= last(b.hi.z); ++k) {
          const auto found = samples.find(key({i, j, k}));
          const float in_grid = found == samples.end() ? 0 : found->second;
          wrong += in_grid != float(density(r, Vec3d(i, j, k) * r.voxel));
          if (found != samples.end()) samples.erase(found);
        }
      }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_TRUE(samples.empty());  // nothing outside the support
  }
}

TEST(Recipe, GridHasNoEmptyBrickAndIsSorted) {
  for (const Recipe& r : kRecipes) {
    VoxelGrid grid = make_grid(r);
    for (const Brick& b : grid.bricks) {
      EXPECT_EQ(b.origin.x % 8 | b.origin.y % 8 | b.origin.z % 8, 0);
      EXPECT_TRUE(std::any_of(b.values, b.values + kBrickSamples, [](float v) { return v > 0; }));
    }
    const VoxelGrid before = grid;
    sort(grid);
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
      EXPECT_EQ(grid.bricks[i].origin, before.bricks[i].origin);
    }
    EXPECT_EQ(grid.index_to_world, scaling(Vec3d(r.voxel)));
    EXPECT_EQ(grid.name, "density");
  }
}

TEST(Recipe, GridIsTheSameForAnyNumberOfThreads) {
  const Recipe r = make_sample();
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
    VoxelGrid grid;
    tbb::task_arena(threads).execute([&] { grid = make_grid(r); });
    return grid;
  };
  const VoxelGrid one = with_threads(1), seven = with_threads(7);
  ASSERT_EQ(one.bricks.size(), seven.bricks.size());
  ASSERT_EQ(one.tiles.size(), seven.tiles.size());
  for (std::size_t i = 0; i < one.bricks.size(); ++i) {
    ASSERT_EQ(one.bricks[i].origin, seven.bricks[i].origin);
    ASSERT_TRUE(std::equal(one.bricks[i].values, one.bricks[i].values + kBrickSamples,
                           seven.bricks[i].values));
  }
  for (std::size_t i = 0; i < one.tiles.size(); ++i) {
    EXPECT_EQ(one.tiles[i].origin, seven.tiles[i].origin);
  }
}

TEST(Recipe, UniformInsideBecomesTiles) {
  Recipe r;
  r.voxel = 0.004;  // 500 samples across
  r.forms = {ball({}, 1)};
  r.density = 2;
  const VoxelGrid grid = make_grid(r);
  std::size_t large = 0;
  double volume = 0;
  for (const Tile& t : grid.tiles) {
    EXPECT_EQ(t.value, 2);
    large += t.edge == 128;
    volume += std::pow(t.edge * r.voxel, 3);
  }
  EXPECT_GE(large, 8u);
  EXPECT_GT(volume, 0.8 * 4.18879);
}

TEST(Recipe, DensityRangeHoldsTheDensityAtEveryPointOfTheBox) {
  Random random(1);
  for (const Recipe& r : kRecipes) {
    const Box all = support(r);
    for (int n = 0; n < 1000; ++n) {
      const Vec3d centre = point_in(random, all);
      const Vec3d half = Vec3d(std::exp(uniform(random, -8, 0)));
      const Box b{centre - half, centre + half};
      const Interval range = density_range(r, b);
      EXPECT_GE(range.lo, 0);
      EXPECT_LE(range.hi, r.density);
      for (int s = 0; s < 50; ++s) {
        ASSERT_TRUE(range.contains(density(r, point_in(random, b))));
      }
    }
  }
}

TEST(Recipe, DensityIsZeroOutsideTheSupport) {
  Random random(2);
  for (const Recipe& r : kRecipes) {
    const Box b = support(r);
    ASSERT_FALSE(b.empty());
    const Box around{b.lo - b.extent() * 0.2, b.hi + b.extent() * 0.2};
    int inside = 0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3d p = point_in(random, around);
      if (b.contains(p)) {
        inside += density(r, p) > 0;
      } else {
        ASSERT_EQ(density(r, p), 0);
      }
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(Recipe, DensityRisesOverTheEdge) {
  Recipe r;
  r.forms = {{half_space({}, {0, -1, 0}), {}}};
  r.cuts = {ball({}, 100)};
  r.edge = 0.5;
  r.density = 3;
  EXPECT_EQ(density(r, {0, 0.1, 0}), 0);
  EXPECT_DOUBLE_EQ(density(r, {0, -0.25, 0}), 1.5);
  EXPECT_EQ(density(r, {0, -0.6, 0}), 3);
}

TEST(Recipe, MovedFormsMakeTheMovedCloud) {
  const Recipe r = make_plain();
  Recipe moved = r;
  Affine map = translation({1, 2, 3}) * scaling({2, 2, 2});
  map.m = {Vec3d{0, -2, 0}, Vec3d{2, 0, 0}, Vec3d{0, 0, 2}};  // a quarter turn
  for (FreeForm& form : moved.forms) form = transform(map, form);
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p = point_in(random, support(r));
    EXPECT_NEAR(density(moved, map.point(p)), density(r, p), 1e-10);
  }
}

TEST(Recipe, MaskLimitsADisplacement) {
  Recipe r;
  r.forms = {ball({}, 1)};
  Recipe rough = r;
  rough.displacements = {{{1, 0.3, 3, 0.5, true}, 0.3, 1e6 * half_space({}, {0, 1, 0})}};
  Random random(4);
  int different = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p = point_in(random, {Vec3d(-1.2), Vec3d(1.2)});
    if (p.y < 0) {
      EXPECT_EQ(density(rough, p), density(r, p));
    } else {
      different += density(rough, p) != density(r, p);
    }
  }
  EXPECT_GT(different, 100);
}

TEST(Recipe, WithoutACloudGivesAnEmptyGrid) {
  Recipe r;
  r.forms = {{{{}, {}, {}, -1}, {}}};
  EXPECT_TRUE(support(r).empty());
  const VoxelGrid grid = make_grid(r);
  EXPECT_TRUE(grid.bricks.empty() && grid.tiles.empty());
  r.forms = {ball({}, 1)};
  r.cuts = {{half_space({0, 5, 0}, {0, 1, 0}), {}}};
  EXPECT_TRUE(support(r).empty());
  EXPECT_TRUE(make_grid(r).bricks.empty());
}

std::string refusal(const Recipe& r) {
  try {
    static_cast<void>(make_grid(r));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Recipe, RefusesWhatIsOutOfRangeByName) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [](const std::string& word, auto change) {
    Recipe r = make_sample();
    change(r);
    EXPECT_NE(refusal(r).find(word), std::string::npos) << word << ": " << refusal(r);
  };
  refuses("voxel", [](Recipe& r) { r.voxel = 0; });
  refuses("voxel", [](Recipe& r) { r.voxel = kNan; });
  refuses("voxel", [](Recipe& r) { r.voxel = 1e-7; });  // 2e7 samples on a side
  refuses("density", [](Recipe& r) { r.density = -1; });
  refuses("edge", [](Recipe& r) { r.edge = 0; });
  refuses("no form", [](Recipe& r) { r.forms.clear(); });
  refuses("form 2", [](Recipe& r) { r.forms[1].base.linear.y = kNan; });
  refuses("form 1", [](Recipe& r) { r.forms[0].perturbations[0].strength = kNan; });
  refuses("cut 1", [](Recipe& r) { r.cuts[0].base.constant = kNan; });
  refuses("infinity", [](Recipe& r) { r.forms.push_back({half_space({}, {1, 0, 0}), {}}); });
  refuses("octaves", [](Recipe& r) { r.displacements[0].noise.octaves = 0; });
  refuses("octaves", [](Recipe& r) { r.displacements[0].noise.octaves = kMaxOctaves + 1; });
  refuses("gain", [](Recipe& r) { r.displacements[1].noise.gain = 0; });
  refuses("cell", [](Recipe& r) { r.displacements[1].noise.cell = -1; });
  refuses("amplitude", [](Recipe& r) { r.displacements[1].amplitude = kNan; });
  refuses("mask", [](Recipe& r) { r.displacements[1].mask.constant = kNan; });
  refuses("cells", [](Recipe& r) { r.displacements[0].noise.cell = 1e-14; });
  refuses("origin", [](Recipe& r) {
    r = make_plain();
    r.forms = {ball({1e9, 0, 0}, 1)};
    r.voxel = 0.1;
  });
}

}  // namespace
}  // namespace pvol
