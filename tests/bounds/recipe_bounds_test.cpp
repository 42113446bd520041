#include "pvol/bounds/recipe_bounds.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <random>

#include "pvol/density/cumulus.h"
#include "pvol/error.h"
#include "pvol/shell/recipe_support.h"

namespace pvol {
namespace recipe_bounds_test {

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

/// Every kind of part, off the origin.
Recipe make_modelled() {
  Recipe r;
  r.edge = 0.1;
  r.density = 3;
  r.profile = {ProfileKind::table, {{0, 0}, {1, 1}, {2, 0.4}}};
  FreeForm bumped = ball({5, -3, 2}, 1);
  FreeForm bump{ellipsoid({5, -2.2, 2}, Vec3d(0.7)), {}};
  bump.perturbations = {{{ellipsoid({5, -1.8, 2}, Vec3d(0.4)), {}}, -2}};
  bumped.perturbations = {{bump, 0.4}};
  r.forms = {{BodyOp::difference, {bumped, ball({5.5, -3, 2.5}, 0.6)}}};
  r.displacements = {{{1, 0.4, 4, 0.5, false}, 0.15}};
  r.modulations = {{{2, 0.5, 2, 0.5, false}, 0.8}};
  r.solids = {{ball({4.8, -3.2, 1.8}, 0.4), 20, 0.05}};
  r.voxel = voxel_for(r, 64);
  return r;
}

/// One density almost everywhere: uniform cubes.
Recipe make_plateau() {
  Recipe r;
  r.forms = {ball({0.3, 0.1, -0.2}, 1)};
  r.density = 0.7;
  r.voxel = voxel_for(r, 200);
  return r;
}

Recipe make_small_cumulus() {
  Recipe r = make_recipe(Cumulus{.towers = 3, .generations = 1});
  r.voxel = voxel_for(r, 60);
  return r;
}

const Recipe kRecipes[] = {make_modelled(), make_plateau(), make_small_cumulus()};

/// The node that holds the leaf of cells from `at` up, or null.
const PyramidNode* node_at(const Pyramid& p, Vec3l at) {
  const Vec3l d = at - p.origin;
  if (min_component(d) < 0 || max_component(d) >> p.root_log2() != 0) return nullptr;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const auto shift = int(level) + 3;
    const Vec3<std::uint32_t> cube(Vec3l(d.x >> shift, d.y >> shift, d.z >> shift));
    const auto i = find(p.levels[level], morton_encode(cube));
    if (i && (level == 0 || is_uniform(p, level, *i))) return &p.levels[level][*i];
  }
  return nullptr;
}

Vec3l corner_of(const Pyramid& p, std::uint64_t code, std::size_t level) {
  return p.origin + Vec3l(morton_decode(code)) * (std::int64_t(kLeafEdge) << level);
}

TEST(RecipeBounds, PyramidIsValidAtEveryRefinement) {
  for (const Recipe& r : kRecipes) {
    for (int refine = 0; refine <= 2; ++refine) {
      const Pyramid p = build_pyramid(r, refine);
      const auto wrong = validate(p);
      EXPECT_FALSE(wrong.has_value()) << *wrong;
      // The root is hardly larger than it must be.
      const Vec3l size = p.support_hi - p.support_lo;
      EXPECT_LE(std::int64_t(1) << p.root_log2(), 4 * max_component(size));
    }
  }
}

TEST(RecipeBounds, PyramidEnclosesThatOfTheSamplesLeafByLeaf) {
  for (const Recipe& r : kRecipes) {
    const Pyramid exact = build_pyramid(make_grid(r));
    const Pyramid bounds = build_pyramid(r);
    EXPECT_EQ(min(bounds.support_lo, exact.support_lo), bounds.support_lo);
    EXPECT_EQ(max(bounds.support_hi, exact.support_hi), bounds.support_hi);
    std::size_t compared = 0;
    for (std::size_t level = 0; level < exact.levels.size(); ++level) {
      for (std::size_t i = 0; i < exact.levels[level].size(); ++i) {
        if (level > 0 && !is_uniform(exact, level, i)) continue;
        const PyramidNode& node = exact.levels[level][i];
        const PyramidNode* around = node_at(bounds, corner_of(exact, node.code, level));
        ASSERT_NE(around, nullptr);
        // Both are rounded outward, each to the codes of its own scale.
        const float step = 1.001f;
        EXPECT_LE(around->lo, node.lo * step);
        EXPECT_GE(around->hi * step, node.hi);
        ++compared;
      }
    }
    EXPECT_GT(compared, 50u);
  }
}

TEST(RecipeBounds, LeavesHoldTheDensityAtEveryPoint) {
  Random random(1);
  for (const Recipe& r : kRecipes) {
    const Pyramid p = build_pyramid(r);
    const Box all = support(r);
    const Box around{all.lo - Vec3d(0.1), all.hi + Vec3d(0.1)};
    int inside = 0;
    for (int n = 0; n < 30000; ++n) {
      const Vec3d at = point_in(random, around);
      const Vec3d cell = at / r.voxel;
      const auto leaf = [](double x) { return std::int64_t(std::floor(x / 8)) * 8; };
      const PyramidNode* node = node_at(p, {leaf(cell.x), leaf(cell.y), leaf(cell.z)});
      const auto rho = static_cast<float>(density(r, at));
      inside += rho > 0;
      if (node == nullptr) {
        ASSERT_EQ(rho, 0);
      } else {
        ASSERT_LE(node->lo, rho);
        ASSERT_GE(node->hi, rho);
        // The box of the support cuts nothing off.
        ASSERT_TRUE(rho == 0 || p.support().contains(cell));
      }
    }
    EXPECT_GT(inside, 1000);
  }
}

/// Rounding goes outward, though densities rounded to float would stay inside without.
TEST(RecipeBounds, NodesHoldTheRangesOfTheirCubes) {
  for (const Recipe& r : kRecipes) {
    const Pyramid p = build_pyramid(r, 0);
    std::size_t varying = 0;
    double most = 0;
    for (const PyramidNode& n : p.levels[0]) {
      const Vec3d lo(corner_of(p, n.code, 0));
      const Interval range = density_range(r, {lo * r.voxel, (lo + Vec3d(8)) * r.voxel});
      if (range.lo == range.hi) continue;
      ++varying;
      most = std::max(most, range.hi);
      EXPECT_LE(double(n.lo), range.lo);
      EXPECT_GE(double(n.hi), range.hi);
    }
    EXPECT_GT(varying, 20u);
    EXPECT_GE(double(p.scale), most);
  }
}

TEST(RecipeBounds, RefinementTightens) {
  const auto sum_of = [](const Pyramid& p, float PyramidNode::*bound) {
    double sum = 0;
    for (const PyramidNode& n : p.levels[0]) sum += double(n.*bound);
    return sum;
  };
  for (const Recipe& r : {make_modelled(), make_small_cumulus()}) {
    const double coarse = sum_of(build_pyramid(r, 0), &PyramidNode::hi),
                 fine = sum_of(build_pyramid(r, 2), &PyramidNode::hi);
    EXPECT_LT(fine, 0.95 * coarse);
    EXPECT_GE(fine, sum_of(build_pyramid(make_grid(r)), &PyramidNode::hi));
  }
  // With minorants above 0, which noise of such strength as above does not leave.
  Recipe r = make_modelled();
  r.modulations.clear();
  const double coarse = sum_of(build_pyramid(r, 0), &PyramidNode::lo),
               fine = sum_of(build_pyramid(r, 2), &PyramidNode::lo);
  EXPECT_GT(fine, 1.2 * coarse);
  EXPECT_LE(fine, sum_of(build_pyramid(make_grid(r)), &PyramidNode::lo));
}

TEST(RecipeBounds, ConstantInsideBecomesUniformCubes) {
  const Pyramid p = build_pyramid(make_plateau());
  std::size_t uniform = 0;
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (!is_uniform(p, level, i)) continue;
      ++uniform;
      EXPECT_NEAR(p.levels[level][i].hi, 0.7, 0.001);
    }
  }
  EXPECT_GT(uniform, 20u);
}

TEST(RecipeBounds, AwayFromTheOriginHoldTheWholeCloud) {
  for (const double side : {-1.0, 1.0}) {
    Recipe r;
    r.forms = {ball(Vec3d(6, 7, 8) * side, 1)};
    r.voxel = 0.05;
    const Pyramid bounds = build_pyramid(r, 0), exact = build_pyramid(make_grid(r));
    ASSERT_FALSE(bounds.empty());
    EXPECT_EQ(min(bounds.support_lo, exact.support_lo), bounds.support_lo);
    EXPECT_EQ(max(bounds.support_hi, exact.support_hi), bounds.support_hi);
  }
}

/// Larger ones than what is divided in parallel.
TEST(RecipeBounds, OfAHugeBallHoldHugeUniformCubes) {
  Recipe r = make_plateau();
  r.voxel = voxel_for(r, 600);
  const Pyramid p = build_pyramid(r, 0);
  EXPECT_EQ(validate(p), std::nullopt);
  constexpr std::size_t kLevel = 4;  // 128^3 voxels
  std::size_t uniform = 0;
  for (std::size_t i = 0; i < p.levels.at(kLevel).size(); ++i) uniform += is_uniform(p, kLevel, i);
  EXPECT_GE(uniform, 8u);
}

TEST(RecipeBounds, SupportEnclosesTheExactOne) {
  for (const Recipe& r : kRecipes) {
    const VoxelGrid grid = make_grid(r);
    const Pyramid pyramid = build_pyramid(grid);
    const Support exact = make_support(grid, pyramid);
    std::uint64_t cells = exact.cells;
    for (int log2 = 0; log2 <= 3; ++log2) {
      const Support s = make_support(r, log2);
      EXPECT_GE(s.cells, cells);
      cells = s.cells;
      std::size_t missing = 0;
      for (std::int64_t x = exact.lo.x; x < exact.hi.x; ++x) {
        for (std::int64_t y = exact.lo.y; y < exact.hi.y; ++y) {
          for (std::int64_t z = exact.lo.z; z < exact.hi.z; ++z) {
            missing += is_occupied(exact, {x, y, z}) && !is_occupied(s, {x, y, z});
          }
        }
      }
      EXPECT_EQ(missing, 0u) << log2;
    }
  }
}

TEST(RecipeBounds, SupportOfAPlainFormIsThatOfItsSamples) {
  const Recipe r = make_plateau();
  const VoxelGrid grid = make_grid(r);
  const Support exact = make_support(grid, build_pyramid(grid)), s = make_support(r, 0);
  EXPECT_LT(double(s.cells), 1.001 * double(exact.cells));
  EXPECT_EQ(s.lo, exact.lo);
  EXPECT_EQ(s.hi, exact.hi);
}

TEST(RecipeBounds, AreTheSameForAnyNumberOfThreads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
  const Recipe r = make_modelled();
  const auto bounds = [&](int threads) {
    Pyramid p;
    tbb::task_arena(threads).execute([&] { p = build_pyramid(r); });
    return p;
  };
  const auto cells = [&](int threads) {
    Support s;
    tbb::task_arena(threads).execute([&] { s = make_support(r); });
    return s;
  };
  EXPECT_EQ(bounds(1), bounds(7));
  const Support one = cells(1), seven = cells(7);
  EXPECT_EQ(one.masks, seven.masks);
  ASSERT_EQ(one.blocks.size(), seven.blocks.size());
  for (std::size_t i = 0; i < one.blocks.size(); ++i) {
    EXPECT_EQ(one.blocks[i].code, seven.blocks[i].code);
    EXPECT_EQ(one.blocks[i].level, seven.blocks[i].level);
  }
}

TEST(RecipeBounds, OfNoCloudAreEmpty) {
  Recipe r;
  r.forms = {FreeForm{{{}, {}, {}, -1}, {}}};
  EXPECT_TRUE(build_pyramid(r).empty());
  EXPECT_TRUE(make_support(r).empty());
  r.forms = {ball({}, 1)};
  r.cuts = {ball({1.5, 1.5, 0}, 1)};  // their boxes meet, they do not
  r.voxel = 0.05;
  EXPECT_EQ(validate(build_pyramid(r, 2)), std::nullopt);
  EXPECT_TRUE(make_support(r, 0).empty());
}

TEST(RecipeBounds, TheLimitOfLeavesIsWhatTheyMayTake) {
  const Recipe r = make_plateau();
  const Pyramid p = build_pyramid(r);
  std::uint64_t leaves = p.levels[0].size();  // and uniform cubes, which count as one each
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) leaves += is_uniform(p, level, i);
  }
  EXPECT_NO_THROW(static_cast<void>(build_pyramid(r, 1, leaves)));
  EXPECT_THROW(static_cast<void>(build_pyramid(r, 1, leaves - 1)), Error);
}

TEST(RecipeBounds, RefuseWhatIsOutOfRange) {
  const Recipe r = make_modelled();
  EXPECT_THROW(static_cast<void>(build_pyramid(r, 4)), Error);
  EXPECT_THROW(static_cast<void>(build_pyramid(r, -1)), Error);
  EXPECT_THROW(static_cast<void>(build_pyramid(r, 1, 50)), Error);
  EXPECT_THROW(static_cast<void>(make_support(r, 4)), Error);
  Recipe broken = r;
  broken.voxel = 0;
  EXPECT_THROW(static_cast<void>(build_pyramid(broken)), Error);
}

}  // namespace recipe_bounds_test
}  // namespace pvol
