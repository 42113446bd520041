#include "pvol/density/recipe.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <limits>
#include <random>
#include <unordered_map>

#include "pvol/density/cumulus.h"
#include "pvol/error.h"

namespace pvol {
namespace {

using Random = std::mt19937_64;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

FreeForm nested(int levels) {
  FreeForm form = ball({}, 1);
  if (levels > 0) form.perturbations = {{nested(levels - 1), 0.1}};
  return form;
}

Body stacked(int levels) {
  if (levels == 0) return ball({}, 1);
  return {BodyOp::join, {stacked(levels - 1), ball({}, 0.5)}};
}

/// Large smooth inside, bulge and dent, cut, noise of both kinds, one of them masked.
Recipe make_sample() {
  Recipe r;
  r.voxel = 0.05;
  r.density = 0.7;
  r.edge = 0.05;
  r.forms = {ball({0, 0, 0}, 1), ball({0.9, 0.2, 0.1}, 0.6), ball({-0.3, 1, -0.2}, 0.5)};
  r.forms[0].form.perturbations = {{{ellipsoid({0, 0, 1}, Vec3d(0.5)), {}}, 0.3},
                                   {{ellipsoid({0, 0, -1}, Vec3d(0.5)), {}}, -0.3}};
  r.cuts = {FreeForm{2.0 * half_space({0, -0.5, 0}, {0.1, 1, 0}), {}}};
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
  r.forms = {FreeForm{0.1 * ellipsoid({5, -3, 2}, {0.2, 0.9, 1.3}, turn), {}}};
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

/// Trees of bodies with nested perturbations, a profile that rises and falls, noise on the density,
/// and a solid in the cloud.
Recipe make_modelled(ProfileKind kind) {
  Recipe r;
  r.voxel = 0.06;
  r.edge = 0.1;
  r.profile.kind = kind;
  if (kind == ProfileKind::table) r.profile.points = {{-0.5, 0}, {1, 1}, {1.5, 0.2}, {4, 0.6}};
  FreeForm dented = ball({0, 0, 0}, 1);
  FreeForm bump{ellipsoid({0, 0.8, 0}, Vec3d(0.7)), {}};
  bump.perturbations = {{{ellipsoid({0, 1.2, 0}, Vec3d(0.4)), {}}, -2}};
  dented.perturbations = {{bump, 0.4}};
  const Body pair{BodyOp::join, {dented, ball({1.2, 0, 0}, 0.7)}};
  const Body holes{BodyOp::join, {ball({0, 0, 0.9}, 0.4), ball({1.2, 0, 0.6}, 0.3)}};
  r.forms = {{BodyOp::difference, {pair, holes}},
             {BodyOp::intersection, {ball({-1, 0, 0}, 0.8), ball({-1, 0.5, 0}, 0.8)}}};
  r.displacements = {{{1, 0.4, 3, 0.5, true}, 0.1}};
  r.modulations = {{{2, 0.3, 3, 0.5, false}, 1.5}, {{3, 1, 1, 0.5, true}, -0.5}};
  r.solids = {
      {Body{BodyOp::difference, {ball({0.2, 0, 0}, 0.5), ball({0.2, 0.4, 0}, 0.4)}}, 5, 0.05},
      {ball({1.2, 0, 0}, 0.2), 0.1, 0.2}};
  return r;
}

const Recipe kRecipes[] = {make_sample(),
                           make_plain(),
                           make_small_cumulus(),
                           make_modelled(ProfileKind::linear),
                           make_modelled(ProfileKind::smooth),
                           make_modelled(ProfileKind::table)};

/// Most that the density can be.
double most(const Recipe& r) {
  double factor = 1, solid = 0;
  for (const MaskedNoise& n : r.modulations) factor += std::max(0.0, n.amplitude);
  for (const Solid& s : r.solids) solid = std::max(solid, s.density);
  return std::max(r.density * largest(r.profile) * factor, solid) * (1 + 1e-12);
}

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
      EXPECT_LE(range.hi, most(r));
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
  r.forms = {FreeForm{half_space({}, {0, -1, 0}), {}}};
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
  for (Body& form : moved.forms) form = transform(map, form);
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

TEST(Recipe, ProfileIsWhatItSays) {
  const Profile smooth{ProfileKind::smooth, {}};
  const Profile table{ProfileKind::table, {{-1, 0}, {0, 0}, {1, 2}, {3, 1}}};
  EXPECT_EQ(value({}, 0.25), 0.25);
  EXPECT_EQ(value(smooth, 0.25), 0.15625);
  EXPECT_EQ(value(smooth, 7), 1);
  EXPECT_EQ(value(table, -0.5), 0);
  EXPECT_EQ(value(table, 0.5), 1);
  EXPECT_EQ(value(table, 2), 1.5);
  EXPECT_EQ(value(table, 9), 1);
  EXPECT_EQ(start(table), 0);
  EXPECT_EQ(largest(table), 2);
  EXPECT_EQ(range(table, {0.5, 2}), Interval(1, 2));
  EXPECT_EQ(range(table, {1.5, 9}), Interval(1, 1.75));
  EXPECT_EQ(range(table, {-kInfinity, kInfinity}), Interval(0, 2));
  EXPECT_EQ(range(smooth, {1, 5}), Interval(1, 1));
}

TEST(Recipe, ProfileRangeIsAttained) {
  Random random(5);
  for (int n = 0; n < 3000; ++n) {
    Profile profile{n % 2 ? ProfileKind::table : ProfileKind::smooth, {}};
    double at = uniform(random, -2, 0);
    for (int i = 0; i < 5; ++i) {
      profile.points.push_back({at, i == 0 ? 0 : uniform(random, 0, 3)});
      at += std::exp(uniform(random, -20, 1));
    }
    const double lo = uniform(random, -3, 3), width = std::exp(uniform(random, -30, 2));
    const Interval r = range(profile, {lo, lo + width});
    Interval found = hull(value(profile, lo), value(profile, lo + width));
    for (const ProfilePoint& p : profile.points) {
      if (lo <= p.depth && p.depth <= lo + width) found = hull(found, value(profile, p.depth));
    }
    for (int s = 0; s <= 50; ++s) {
      const double v = value(profile, std::min(lo + width, lo + width * s / 50));
      ASSERT_TRUE(r.contains(v)) << n;
      found = hull(found, v);
    }
    EXPECT_NEAR(r.lo, found.lo, 1e-14);
    EXPECT_NEAR(r.hi, found.hi, 1e-14);
  }
}

TEST(Recipe, ModulationMultipliesTheDensityAndNeverBelowZero) {
  Recipe r;
  r.forms = {ball({}, 1)};
  r.edge = 0.01;
  Recipe rough = r;
  rough.modulations = {{{1, 0.3, 2, 0.5, false}, 3}};
  Random random(6);
  int gaps = 0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3d p = point_in(random, {Vec3d(-0.5), Vec3d(0.5)});
    const double expected = std::max(0.0, 1 + 3 * fbm(rough.modulations[0].noise, p));
    EXPECT_DOUBLE_EQ(density(rough, p), expected * density(r, p));
    gaps += expected == 0;
  }
  EXPECT_GT(gaps, 10);
  EXPECT_EQ(density(rough, {2, 0, 0}), 0);
}

TEST(Recipe, SolidStandsInTheCloud) {
  Recipe r;
  r.forms = {ball({}, 1)};
  r.solids = {{ball({0.8, 0, 0}, 0.5), 20, 0.01}};
  EXPECT_EQ(density(r, {0.9, 0, 0}), 20);
  EXPECT_EQ(density(r, {1.2, 0, 0}), 20);  // also where it looks out of the cloud
  EXPECT_EQ(density(r, {-0.5, 0, 0}), 1);
  EXPECT_EQ(density(r, {0, 1.1, 0}), 0);
  EXPECT_EQ(density_range(r, {{0.8, -0.1, -0.1}, {0.9, 0.1, 0.1}}), Interval(20));
  r.forms.clear();  // alone
  EXPECT_EQ(density(r, {0.9, 0, 0}), 20);
  EXPECT_EQ(density(r, {-0.5, 0, 0}), 0);
  EXPECT_FALSE(make_grid(r).bricks.empty());
}

TEST(Recipe, WithoutACloudGivesAnEmptyGrid) {
  Recipe r;
  r.forms = {FreeForm{{{}, {}, {}, -1}, {}}};
  EXPECT_TRUE(support(r).empty());
  const VoxelGrid grid = make_grid(r);
  EXPECT_TRUE(grid.bricks.empty() && grid.tiles.empty());
  r.forms = {ball({}, 1)};
  r.cuts = {FreeForm{half_space({0, 5, 0}, {0, 1, 0}), {}}};
  EXPECT_TRUE(support(r).empty());
  EXPECT_TRUE(make_grid(r).bricks.empty());
}

TEST(Recipe, DeepestTreesAreValid) {
  Recipe r;
  r.forms = {stacked(kDeepestTree), nested(kDeepestTree)};
  EXPECT_NO_THROW(validate(r));
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
  refuses("form 2", [](Recipe& r) { r.forms[1].form.base.linear.y = kNan; });
  refuses("form 1", [](Recipe& r) { r.forms[0].form.perturbations[0].strength = kNan; });
  refuses("cut 1", [](Recipe& r) { r.cuts[0].form.base.constant = kNan; });
  refuses("infinity", [](Recipe& r) {
    r.forms.push_back(FreeForm{half_space({}, {1, 0, 0}), {}});
  });
  refuses("octaves", [](Recipe& r) { r.displacements[0].noise.octaves = 0; });
  refuses("octaves", [](Recipe& r) { r.displacements[0].noise.octaves = kMaxOctaves + 1; });
  refuses("gain", [](Recipe& r) { r.displacements[1].noise.gain = 0; });
  refuses("cell", [](Recipe& r) { r.displacements[1].noise.cell = -1; });
  refuses("amplitude", [](Recipe& r) { r.displacements[1].amplitude = kNan; });
  refuses("mask", [](Recipe& r) { r.displacements[1].mask.constant = kNan; });
  refuses("cells", [](Recipe& r) { r.displacements[0].noise.cell = 1e-14; });
  refuses("depth", [](Recipe& r) { r.forms[0] = stacked(kDeepestTree + 1); });
  refuses("depth", [](Recipe& r) { r.forms[0] = nested(kDeepestTree + 1); });
  refuses("form 1 has no parts", [](Recipe& r) { r.forms[0] = {BodyOp::join, {}}; });
  refuses("cut 1, part 2", [](Recipe& r) {
    r.cuts[0] = {BodyOp::join, {ball({}, 1), ball({}, kNan)}};
  });
  refuses("modulation 1 cell", [](Recipe& r) { r.modulations = {{{.cell = 0}, 1}}; });
  refuses("largest density", [](Recipe& r) { r.modulations = {{{}, 1e35}}; });
  refuses("solid 1 edge", [](Recipe& r) { r.solids = {{ball({}, 1), 1, 0}}; });
  refuses("solid 1 density", [](Recipe& r) { r.solids = {{ball({}, 1), kNan, 1}}; });
  refuses("solid 1 reaches to infinity", [](Recipe& r) {
    r.solids = {{FreeForm{half_space({}, {1, 0, 0}), {}}, 1, 1}};
  });
  const auto refuses_table = [&](const std::string& word, std::vector<ProfilePoint> points) {
    refuses(word, [&](Recipe& r) { r.profile = {ProfileKind::table, points}; });
  };
  refuses_table("points in the profile", {{0, 0}});
  refuses_table("point 2 depth", {{0, 0}, {0, 1}});
  refuses_table("point 1 density", {{0, -1}, {1, 1}});
  refuses_table("first density", {{0, 1}, {1, 1}});
  refuses_table("largest density", {{0, 0}, {1, 0}});
  refuses("origin", [](Recipe& r) {
    r = make_plain();
    r.forms = {ball({1e9, 0, 0}, 1)};
    r.voxel = 0.1;
  });
}

}  // namespace
}  // namespace pvol
