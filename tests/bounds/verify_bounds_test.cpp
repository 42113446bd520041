#include "pvol/bounds/verify.h"

#include <gtest/gtest.h>

#include "pvol/error.h"
#include "pvol/volume/make_volume.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol {
namespace verify_bounds_test {

/// Noise without zeros in an odd place, so that leaves, faces and corners all matter.
test::Field noise() {
  return test::make_field("noise", {-13, 5, 9}, {40, 33, 29}, [](Vec3i p) {
    return 0.25 + 0.75 * to_uniform_double(mix64(std::uint64_t(p.x * 10007 + p.y * 101 + p.z)));
  });
}

std::size_t index_of_largest_below(const Pyramid& p, float limit) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < p.levels[0].size(); ++i) {
    if (p.levels[0][i].hi < limit && p.levels[0][i].hi > p.levels[0][best].hi) best = i;
  }
  return best;
}

Vec3l cell_of(const Pyramid& p, std::size_t level, std::size_t i) {
  return p.origin +
         Vec3l(morton_decode(p.levels[level][i].code)) * (std::int64_t(kLeafEdge) << level);
}

TEST(VerifyBounds, BoundsOfEveryFieldHold) {
  for (const test::Field& f : test::fields()) {
    const Pyramid p = build_pyramid(f.grid);
    const BoundsCheck c = verify_bounds(f.grid, p);
    EXPECT_TRUE(c.holds()) << f.name << ": " << c.wrong.size();
    EXPECT_EQ(c.leaves, p.levels.at(0).size());
  }
  EXPECT_TRUE(verify_bounds({}, {}).holds());
}

TEST(VerifyBounds, AMajorantTenPercentTooLowIsFound) {
  const test::Field f = noise();
  Pyramid p = build_pyramid(f.grid);
  const std::size_t i = index_of_largest_below(p, 0.9999f * p.scale);
  const float true_hi = p.levels[0][i].hi;
  p.levels[0][i].hi = 0.9f * true_hi;
  const BoundsCheck c = verify_bounds(f.grid, p);
  ASSERT_EQ(c.wrong.size(), 1u);
  const WrongBound& w = c.wrong[0];
  EXPECT_EQ(w.kind, WrongBound::Kind::leaf);
  EXPECT_EQ(w.depth, int(p.levels.size()) - 1);
  EXPECT_EQ(w.lo_cell, cell_of(p, 0, i));
  EXPECT_EQ(w.hi_cell, w.lo_cell + Vec3l(8));
  EXPECT_EQ(w.stored_hi, 0.9f * true_hi);
  EXPECT_LE(w.found_hi, true_hi);
  EXPECT_NEAR(w.off(), 0.1, 1e-3);
  EXPECT_FALSE(c.support);
}

TEST(VerifyBounds, AMinorantTooHighIsFoundAndTheWorstComesFirst) {
  const test::Field f = noise();
  Pyramid p = build_pyramid(f.grid);
  std::size_t full = 0;  // a leaf without zeros
  while (p.levels[0][full].lo == 0) ++full;
  p.levels[0][full].lo *= 1.25f;
  p.levels[0].back().hi *= 0.5f;
  const BoundsCheck c = verify_bounds(f.grid, p);
  ASSERT_EQ(c.wrong.size(), 2u);
  EXPECT_GT(c.wrong[0].off(), 0.4);
  EXPECT_EQ(c.wrong[1].lo_cell, cell_of(p, 0, full));
  EXPECT_NEAR(c.wrong[1].off(), 0.2, 1e-2);
}

TEST(VerifyBounds, EveryMissingLeafIsFound) {
  const test::Field f = noise();
  const Pyramid good = build_pyramid(f.grid);
  for (std::size_t i = 0; i < good.levels[0].size(); ++i) {
    Pyramid p = good;
    p.levels[0].erase(p.levels[0].begin() + std::ptrdiff_t(i));
    const BoundsCheck c = verify_bounds(f.grid, p);
    // Its parent may now look like a uniform cube, which is wrong as well.
    ASSERT_FALSE(c.holds()) << i;
    bool found = false;
    for (const WrongBound& w : c.wrong) {
      const Vec3l at = cell_of(good, 0, i);
      found =
          found || (min(w.lo_cell, at) == w.lo_cell && max(w.hi_cell, at + Vec3l(8)) == w.hi_cell);
    }
    EXPECT_TRUE(found) << i;
  }
}

/// A tile in a corner of another pyramid: uniform cubes above the leaves.
VoxelGrid tile(Vec3i origin, int edge) {
  VoxelGrid g;
  g.tiles.push_back({origin, edge, 0.5f});
  return g;
}

TEST(VerifyBounds, UniformCubesAreComparedWithTheirTiles) {
  const VoxelGrid g = tile({0, 0, 0}, 128);
  Pyramid p = build_pyramid(g);
  const BoundsCheck good = verify_bounds(g, p);
  EXPECT_TRUE(good.holds());
  EXPECT_GT(good.uniform, 0u);
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (!is_uniform(p, level, i)) continue;
      PyramidNode& n = p.levels[level][i];
      const PyramidNode before = n;
      n.lo = n.hi = 0.4f;
      const BoundsCheck c = verify_bounds(g, p);
      ASSERT_EQ(c.wrong.size(), 1u);
      EXPECT_EQ(c.wrong[0].kind, WrongBound::Kind::uniform);
      EXPECT_EQ(c.wrong[0].lo_cell, cell_of(p, level, i));
      n = before;
    }
  }
}

TEST(VerifyBounds, BoundsOfAnotherPlaceAreMissingThere) {
  const Pyramid p = build_pyramid(tile({0, 0, 0}, 128));
  const BoundsCheck c = verify_bounds(tile({128, 0, 0}, 128), p);
  EXPECT_FALSE(c.holds());
  ASSERT_TRUE(c.support);
  EXPECT_EQ(c.support->found_lo, Vec3l(127, -1, -1));
  EXPECT_EQ(c.support->found_hi, Vec3l(256, 128, 128));
}

/// Tiles, which a few bytes can describe, are limited by the leaves around them; bricks are not.
TEST(VerifyBounds, TheLimitOfLeavesIsOneOfTiles) {
  EXPECT_NO_THROW((void)build_pyramid(noise().grid, LookUp::trilinear, 0));
  const VoxelGrid g = tile({0, 0, 0}, 128);
  const std::size_t leaves = build_pyramid(g).levels[0].size();
  EXPECT_NO_THROW((void)build_pyramid(g, LookUp::trilinear, 2 * leaves));
  EXPECT_THROW((void)build_pyramid(g, LookUp::trilinear, leaves / 2), Error);
}

/// Pyramids have a limit of size, and cells around the samples must have 32-bit coordinates.
TEST(VerifyBounds, PlacesThatNoPyramidReachesAreRefused) {
  const auto refusal = [](const VoxelGrid& g, LookUp look_up) -> std::string {
    try {
      (void)build_pyramid(g, look_up);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  VoxelGrid far_apart = tile({0, 0, 0}, 8);
  far_apart.tiles.push_back({{1 << 24, 0, 0}, 8, 0.5f});
  const std::string too_far = refusal(far_apart, LookUp::trilinear);
  EXPECT_TRUE(says(too_far, "bounds.density_extends_over"));
  far_apart.tiles.back().origin.x -= 16;
  EXPECT_EQ(refusal(far_apart, LookUp::trilinear), "");
  const VoxelGrid last = tile({0, 2147483640, 0}, 8);
  EXPECT_TRUE(says(refusal(last, LookUp::trilinear), "bounds.voxels_lie_within"));
  EXPECT_TRUE(
      says(refusal(tile({0, 0, 0}, 8), LookUp::procedural), "bounds.samples_procedural_look"));
}

TEST(VerifyBounds, HugeCubesOverNothingTakeNoTime) {
  Pyramid p = build_pyramid(tile({0, 0, 0}, 4096));
  const VoxelGrid one = tile({0, 0, 0}, 8);
  const BoundsCheck c = verify_bounds(one, p);
  EXPECT_FALSE(c.holds());
  for (const WrongBound& w : c.wrong) EXPECT_EQ(w.found_lo, 0);
}

TEST(VerifyBounds, LeavesBelowATileAreMissed) {
  const VoxelGrid g = tile({0, 0, 0}, 128);
  const Pyramid good = build_pyramid(g);
  std::size_t below = 0;  // cells that only the tile's lowest samples reach
  for (std::size_t i = 0; i < good.levels[0].size(); ++i) {
    const Vec3l at = cell_of(good, 0, i);
    if (min(at, Vec3l(0)) != at || at.y >= 0 || at.z >= 0 || at.x >= 0) continue;
    ++below;
    Pyramid p = good;
    p.levels[0].erase(p.levels[0].begin() + std::ptrdiff_t(i));
    const BoundsCheck c = verify_bounds(g, p);
    ASSERT_EQ(c.wrong.size(), 1u);
    EXPECT_EQ(c.wrong[0].kind, WrongBound::Kind::missing);
    EXPECT_EQ(c.wrong[0].lo_cell, at);
    EXPECT_FALSE(verify_cover(g, p).holds());
  }
  EXPECT_GT(below, 0u);
}

/// Bounds made for trilinear interpolation and said to be for another one, and the other way round.
TEST(VerifyBounds, InterpolationsReadOtherSamples) {
  for (const test::Field& f : test::fields()) {
    const Pyramid cubic = build_pyramid(f.grid, LookUp::tricubic);
    EXPECT_TRUE(verify_bounds(f.grid, cubic).holds()) << f.name;
  }
  const test::Field f = noise();
  Pyramid p = build_pyramid(f.grid);
  p.look_up = LookUp::tricubic;
  EXPECT_FALSE(verify_bounds(f.grid, p).holds());
}

/// A tricubic look-up reads a sample before its own cell: the last one of a brick bounds the leaf
/// above, and gives it density.
TEST(VerifyBounds, TricubicLeavesReadTheSampleBeforeThem) {
  const Vec3i last(7, 4, 4);
  const auto leaf_above = [](const Pyramid& p) {
    std::size_t i = 0;
    while (cell_of(p, 0, i) != Vec3l(8, 0, 0)) ++i;
    return i;
  };
  const test::Field bump = test::make_field("bump", {0, 0, 0}, Vec3i(16),
                                            [&](Vec3i at) { return at == last ? 1.0 : 0.5; });
  Pyramid p = build_pyramid(bump.grid, LookUp::tricubic);
  p.levels[0][leaf_above(p)].hi = 0.75f;
  const BoundsCheck low = verify_bounds(bump.grid, p);
  ASSERT_EQ(low.wrong.size(), 1u);
  EXPECT_EQ(low.wrong[0].lo_cell, Vec3l(8, 0, 0));
  EXPECT_EQ(low.wrong[0].found_hi, 1);

  const test::Field one = test::make_field("one", {0, 0, 0}, Vec3i(8),
                                           [&](Vec3i at) { return at == last ? 1.0 : 0.0; });
  p = build_pyramid(one.grid, LookUp::tricubic);
  EXPECT_TRUE(verify_bounds(one.grid, p).holds());
  p.levels[0].erase(p.levels[0].begin() + std::ptrdiff_t(leaf_above(p)));
  const BoundsCheck lack = verify_bounds(one.grid, p);
  ASSERT_EQ(lack.wrong.size(), 1u);
  EXPECT_EQ(lack.wrong[0].kind, WrongBound::Kind::missing);
  EXPECT_EQ(lack.wrong[0].lo_cell, Vec3l(8, 0, 0));
  EXPECT_FALSE(verify_cover(one.grid, p).holds());
}

TEST(VerifyCover, VolumesAreNotMadeOfBoundsThatLackALeafOrHideOthers) {
  const auto refused = [](const VoxelGrid& g, const Pyramid& p, LookUp look_up) -> std::string {
    try {
      (void)make_volume(g, p, Medium{}, {.look_up = look_up});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const test::Field f = noise();
  for (const LookUp look_up : {LookUp::trilinear, LookUp::tricubic}) {
    const Pyramid good = build_pyramid(f.grid, look_up);
    EXPECT_EQ(refused(f.grid, good, look_up), "");
    for (std::size_t i = 0; i < good.levels[0].size(); ++i) {
      Pyramid p = good;
      p.levels[0].erase(p.levels[0].begin() + std::ptrdiff_t(i));
      EXPECT_TRUE(says(refused(f.grid, p, look_up), "bounds.density_outside_them")) << i;
    }
  }
  // Samples of one value but for one, under the bounds of a tile.
  const VoxelGrid one_value = tile({0, 0, 0}, 128);
  const test::Field nearly = test::make_field("nearly", {0, 0, 0}, Vec3i(128), [](Vec3i at) {
    return at == Vec3i(77, 85, 69) ? 0.25 : 0.5;
  });
  const Pyramid p = build_pyramid(one_value);
  EXPECT_EQ(refused(one_value, p, LookUp::trilinear), "");
  EXPECT_FALSE(verify_cover(nearly.grid, p).holds());
  EXPECT_TRUE(says(refused(nearly.grid, p, LookUp::trilinear), "bounds.claim_value_cube"));
}

}  // namespace verify_bounds_test
}  // namespace pvol
