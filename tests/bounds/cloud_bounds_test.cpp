// The bounds of every shared cloud against all of its samples, and the field that look-ups read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <filesystem>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/field/micro_range.h"
#include "pvol/formats/cloud.h"
#include "pvol/math/rng.h"
#include "support/effort.h"

namespace pvol {
namespace cloud_bounds_test {

namespace fs = std::filesystem;

const fs::path kShared = PVOL_SHARED_DATA;

/// All of them; on each commit without the largest.
std::vector<fs::path> clouds() {
  std::vector<fs::path> files;
  if (!fs::exists(kShared)) return files;
  for (const char* folder : {"", "odd"}) {
    for (const auto& entry : fs::directory_iterator(kShared / folder)) {
      const auto ending = entry.path().extension();
      if (ending != ".vdb" && ending != ".nvdb") continue;
      if (!proof::runs_all() && entry.path().stem() == "wdas_x4_detail") continue;
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The only grid, "density", or failing both the first that EmberGen writes.
formats::LoadedGrid load(const fs::path& file) {
  formats::GridOptions options;
  const std::string name = file.filename().string();
  if (name == "embergen_fire_a_60.vdb" || name == "embergen_fire_a_75.vdb") {
    options.grid = "temperature";
  } else if (name == "three_grids_named_density.vdb") {
    options.grid = "density[1]";
  }
  return formats::load_grid(file, options);
}

class CloudBounds : public testing::TestWithParam<fs::path> {};

/// How many leaves have other bounds than the tightest that 16 bits hold, and how many look-ups in
/// them, on corners, faces and inside, leave those bounds.
std::size_t count_wrong(const Pyramid& p, const FieldWithLinks& f) {
  Rng rng(1, 2, 3);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < p.levels[0].size(); ++i) {
    const PyramidNode& leaf = p.levels[0][i];
    const float* s = f.field.brick(f.brick_of[0][i]);
    const auto [least, most] = std::minmax_element(s, s + kFieldSamples);
    wrong += leaf.lo != decode(encode_down(*least, p.scale), p.scale) ||
             leaf.hi != decode(encode_up(*most, p.scale), p.scale);
    for (int k = 0; k < 64; ++k) {
      Vec3i cell;
      Vec3f frac;
      for (int axis = 0; axis < 3; ++axis) {
        const auto [place, offset] = rng.uniform2();
        cell[axis] = int(place * 8);
        frac[axis] = offset < 0.25f ? 0.0f : offset > 0.75f ? 1.0f : offset;
      }
      const LatticePoint at{widen(cell), widen(frac)};
      const float v = density_in_brick<LookUp::trilinear>(s, at);
      const float nearest = density_in_brick<LookUp::nearest>(s, at);
      const float slack = 3 * FLT_EPSILON * leaf.hi;
      wrong += v < leaf.lo - slack || v > leaf.hi + slack || nearest < leaf.lo || nearest > leaf.hi;
    }
  }
  return wrong;
}

/// Whether the cell is in a leaf, or in a node of one density.
bool is_covered(const Pyramid& p, Vec3l cell) {
  const Vec3l at = cell - p.origin;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const int shift = 3 + int(level);
    const Vec3<std::uint32_t> cube(Vec3l(at.x >> shift, at.y >> shift, at.z >> shift));
    const auto i = find(p.levels[level], morton_encode(cube));
    if (!i) continue;
    if (level == 0) return true;
    if (is_uniform(p, level, *i)) return true;
  }
  return false;
}

/// The cells around what is not 0 in a grid: how many of them the bounds leave out, and their box.
struct Cover {
  std::size_t uncovered = 0;
  Vec3l lo, hi;
};

Cover cover(const VoxelGrid& grid, const Pyramid& p) {
  Cover c{0, p.support_hi, p.support_lo};
  for (const Brick& b : grid.bricks) {
    for (int v = 0; v < kBrickSamples; ++v) {
      if (b.values[v] == 0) continue;
      const Vec3l at = Vec3l(b.origin) + Vec3l(v >> 6, v >> 3 & 7, v & 7);
      c.lo = min(c.lo, at - Vec3l(1));
      c.hi = max(c.hi, at + Vec3l(1));
      const bool edge = (v & 7) % 7 == 0 || (v >> 3 & 7) % 7 == 0 || (v >> 6) % 7 == 0;
      for (int k = 0; k < (edge ? 8 : 1); ++k) {
        c.uncovered += !is_covered(p, at - Vec3l(k & 1, k >> 1 & 1, k >> 2));
      }
    }
  }
  for (const Tile& t : grid.tiles) {
    c.lo = min(c.lo, Vec3l(t.origin) - Vec3l(1));
    c.hi = max(c.hi, Vec3l(t.origin) + Vec3l(t.edge));
    for (int k = 0; k < 64; ++k) {  // corners of the tile and one cell below them
      const auto at = [&](int axis, int shift) {
        const int pick = k >> shift & 3;
        return std::int64_t(t.origin[axis]) + (pick & 1 ? t.edge - 1 : 0) - (pick >> 1);
      };
      c.uncovered += !is_covered(p, {at(0, 0), at(1, 2), at(2, 4)});
    }
  }
  return c;
}

/// Every sample that any interpolation kernel in a leaf can read lies within the leaf's bounds, the
/// bounds are the tightest that 16 bits hold, and what lies in no leaf is empty: every non-zero
/// sample is in the leaves of all eight cells around it.
TEST_P(CloudBounds, HoldForEverySampleAndAreTight) {
  const formats::LoadedGrid loaded = load(GetParam());
  const Pyramid p = build_pyramid(loaded.grid);
  ASSERT_FALSE(p.empty());
  EXPECT_EQ(validate(p), std::nullopt);
  EXPECT_EQ(count_wrong(p, build_field(loaded.grid, p)), 0u);
  const Cover c = cover(loaded.grid, p);
  EXPECT_EQ(c.uncovered, 0u);
  EXPECT_EQ(c.lo, p.support_lo);
  EXPECT_EQ(c.hi, p.support_hi);
}

/// Tricubic look-ups keep the bounds of their leaf, and to the last bit those of the cubes of cells
/// around them.
TEST_P(CloudBounds, HoldForTricubicLookups) {
  constexpr auto kTricubic = LookUp::tricubic;
  const formats::LoadedGrid loaded = load(GetParam());
  const Pyramid p = build_pyramid(loaded.grid, kTricubic);
  EXPECT_EQ(validate(p), std::nullopt);
  FieldWithLinks f = build_field(loaded.grid, p, {.look_up = kTricubic});
  constexpr std::size_t kLeaves = 400;  // spread over the cloud, in a field of their own
  BrickField some;
  some.look_up = kTricubic;
  std::vector<PyramidNode> nodes;
  const std::size_t step = 1 + p.levels[0].size() / kLeaves;
  for (std::size_t i = 0; i < p.levels[0].size(); i += step) {
    const float* s = f.field.brick<kTricubic>(f.brick_of[0][i]);
    some.samples.insert(some.samples.end(), s, s + field_samples(kTricubic));
    nodes.push_back(p.levels[0][i]);
  }
  const MicroBounds one = build_micro_bounds(some, 1), two = build_micro_bounds(some, 2);
  Rng rng(4, 5, 6);
  std::size_t wrong = 0;
  for (std::uint32_t b = 0; b < nodes.size(); ++b) {
    for (int k = 0; k < 2000; ++k) {
      const LatticePoint at{Int4{k & 7, k >> 3 & 7, k >> 6 & 7, 0},
                            Float4{rng.uniform(), rng.uniform(), k & 1 ? 1 : rng.uniform(), 0}};
      const float v = density_in_brick<kTricubic>(some.brick<kTricubic>(b), at);
      const float slack = 6 * FLT_EPSILON * nodes[b].hi;
      wrong += v < nodes[b].lo - slack || v > nodes[b].hi + slack;
      for (const DensityRange r : {micro_range(one, b, at.cell), micro_range(two, b, at.cell)}) {
        wrong += !(r.lo <= v && v <= r.hi);
      }
    }
  }
  EXPECT_EQ(wrong, 0u);
}

std::string test_name(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.stem().string();
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CloudBounds);
INSTANTIATE_TEST_SUITE_P(SharedClouds, CloudBounds, testing::ValuesIn(clouds()), test_name);

/// Says aloud that the clouds are missing, instead of passing in silence.
TEST(CloudBoundsFolder, IsPresent) {
  if (clouds().empty()) GTEST_SKIP() << "no shared test clouds in " << kShared;
  EXPECT_GE(clouds().size(), 10u);
}

}  // namespace cloud_bounds_test
}  // namespace pvol
