// Bounds of every small cube, which lanes read, against the look-ups in them.
#include "volume/dense_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/embed.h"
#include "pvol/math/field_map.h"
#include "pvol/volume/make_volume.h"
#include "support/effort.h"
#include "support/fields.h"
#include "support/nasty_offset.h"
#include "support/recipes.h"

namespace pvol::test {
namespace dense_bounds_test {

using detail::DenseBounds;
using detail::make_dense_bounds;

struct Found {
  std::uint32_t word;
  Vec3i cube;
};
[[nodiscard]] Found find(const DenseBounds& b, Vec3i cell) {
  const Vec3i from_border = cell + Vec3i(DenseBounds::kBorder);
  const auto down = [&](int v) { return v >> b.shift; };
  const Vec3i cube(down(from_border.x), down(from_border.y), down(from_border.z));
  const auto at =
      (std::size_t(cube.x) * std::size_t(b.size.y) + std::size_t(cube.y)) * std::size_t(b.size.z) +
      std::size_t(cube.z);
  return {b.word.at(at), cube};
}

/// Of a place in cells from the octree's origin: its bounds hold what is there, and what is said to
/// be empty or outside is.
void check_place(const Volume& v, const DenseBounds& b, Vec3d cells) {
  const auto cell =
      Vec3i(int(std::floor(cells.x)), int(std::floor(cells.y)), int(std::floor(cells.z)));
  const std::uint32_t word = find(b, cell).word;
  const float mu = extinction_at(v, inverse(v.density.world_to_cells).point(cells));
  if (word >= DenseBounds::kFirstSolid) {
    ASSERT_LE(detail::minorant(word), mu);
    ASSERT_GE(detail::majorant(word), mu);
    return;
  }
  ASSERT_EQ(mu, 0);
  if (word == DenseBounds::kOutside) {
    const Vec3i lo = vec3(v.density.octree.support_lo), hi = vec3(v.density.octree.support_hi);
    ASSERT_FALSE(min(lo, cell) == lo && max(cell, hi - Vec3i(1)) == hi - Vec3i(1));
    return;
  }
  ASSERT_GE(word, std::uint32_t(b.shift));
  ASSERT_LE(word, std::uint32_t(DenseBounds::kLargestEmpty));
  // The aligned cube around it, from corner to corner.
  const int edge = 1 << word;
  const auto low = [&](int c) {
    return ((c + DenseBounds::kBorder) & -edge) - DenseBounds::kBorder;
  };
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i far(corner >> 2, corner >> 1 & 1, corner & 1);
    const Vec3i at = Vec3i(low(cell.x), low(cell.y), low(cell.z)) + far * (edge - 1);
    const std::uint32_t there = find(b, at).word;
    ASSERT_TRUE(there == word || there == DenseBounds::kOutside);
  }
}

TEST(DenseBounds, HoldAllThatIsInTheirCubes) {
  for (const Field& f : fields()) {
    const Volume v = make_test_volume(f, 7, std::nullopt);
    const Vec3d box = Vec3d(vec3(v.density.octree.support_hi));
    for (const int shift : {1, 2, 3, 4, 5}) {
      SCOPED_TRACE(f.name + ", cubes of " + std::to_string(1 << shift));
      const DenseBounds b = make_dense_bounds(v.density, shift);
      ASSERT_EQ(b.shift, shift);
      Rng rng(5, 77, std::uint64_t(shift));
      for (int i = 0; i < 40'000 && !::testing::Test::HasFatalFailure(); ++i) {
        const auto along = [&](double end) {
          const double whole = std::floor(double(rng.uniform()) * (end + 60) - 30);
          return whole + double(nasty_offset(rng)) * (1 - 0x1p-20);
        };
        check_place(v, b, {along(box.x), along(box.y), along(box.z)});
      }
    }
  }
}

/// Volumes of every kind of look-up that is not made in lanes.
std::vector<std::pair<std::string, Volume>> looked_up_otherwise() {
  std::vector<std::pair<std::string, Volume>> all;
  const Medium medium{.extinction = 7};
  const auto map = std::make_shared<const FieldMap>(
      FieldMap{.ramp = {{{0, 0}, {0.2f, 1.5f}, {0.5f, 0}, {1, 0.7f}}, true}});
  for (const Field& f : fields()) {
    const auto add = [&](const std::string& what, const VolumeOptions& o) {
      all.emplace_back(f.name + ", " + what, make_volume(f.grid, medium, o));
    };
    add("tricubic", {.look_up = LookUp::tricubic});
    add("mapped", {.map = map});
    add("mapped, nearest", {.look_up = LookUp::nearest, .map = map});
    add("shared", {.samples = SampleStorage::shared});
  }
  const auto recipe = std::make_shared<const Recipe>(make_sample());
  const Pyramid pyramid = build_pyramid(*recipe);
  all.emplace_back("recipe", make_volume(recipe, pyramid, medium, {}));
  return all;
}

TEST(DenseBounds, HoldForEveryKindOfLookUp) {
  std::size_t turn = 0;
  for (const auto& [name, v] : looked_up_otherwise()) {
    ++turn;  // one begins with even edges, the next with odd ones
    SCOPED_TRACE(name);
    const Vec3d box = Vec3d(vec3(v.density.octree.support_hi));
    for (const std::optional<int> shift : {std::optional<int>{}, {1}, {2}, {3}, {4}, {5}}) {
      if (!proof::has_turn(turn + std::size_t(shift.value_or(0)))) continue;
      const DenseBounds b = make_dense_bounds(v.density, shift);
      Rng rng(6, 78, std::uint64_t(b.shift));
      for (int i = 0; i < 10'000 && !::testing::Test::HasFatalFailure(); ++i) {
        const auto along = [&](double end) {
          const double whole = std::floor(double(rng.uniform()) * (end + 60) - 30);
          return whole + double(nasty_offset(rng)) * (1 - 0x1p-20);
        };
        check_place(v, b, {along(box.x), along(box.y), along(box.z)});
      }
    }
  }
}

/// Smaller cubes have tighter bounds: those of a cube hold those of all parts of it.
TEST(DenseBounds, OfPartsAreTighter) {
  const Volume v = make_test_volume(field("gaussian"), 7, std::nullopt);
  const DenseBounds fine = make_dense_bounds(v.density, 1),
                    coarse = make_dense_bounds(v.density, 3),
                    coarsest = make_dense_bounds(v.density, 5);
  double sums[3] = {0, 0, 0};
  const Vec3i end = vec3(v.density.octree.support_hi);
  for (Vec3i p; p.x < end.x; ++p.x) {
    for (p.y = 0; p.y < end.y; ++p.y) {
      for (p.z = 0; p.z < end.z; ++p.z) {
        const std::uint32_t small = find(fine, p).word, large = find(coarse, p).word,
                            huge = find(coarsest, p).word;
        if (small < DenseBounds::kFirstSolid) continue;
        ASSERT_GE(large, DenseBounds::kFirstSolid);
        ASSERT_LE(detail::majorant(small), detail::majorant(large));
        ASSERT_LE(detail::majorant(large), detail::majorant(huge));
        sums[0] += double(detail::majorant(small)), sums[1] += double(detail::majorant(large));
        sums[2] += double(detail::majorant(huge));
      }
    }
  }
  EXPECT_LT(sums[0], 0.8 * sums[1]);
  EXPECT_LT(sums[1], 0.8 * sums[2]);
}

/// The thicker a cloud, the smaller the cubes that pay; of a thin one they are larger than leaves.
TEST(DenseBounds, ChooseTheirCubesByCost) {
  int last = DenseBounds::kLargestEmpty + 1;
  for (const double extinction : {0.01, 5.0, 100.0}) {
    const Volume v = make_test_volume(field("gaussian"), extinction, std::nullopt);
    const int shift = make_dense_bounds(v.density).shift;
    EXPECT_LT(shift, last) << extinction;
    if (extinction < 1) {
      EXPECT_GT(shift, 3);
    }
    last = shift;
  }
  EXPECT_EQ(last, 1);
}

/// A wide box has room for large cubes alone.
TEST(DenseBounds, OfWideBoxesKeepToTheirMemory) {
  const Field wide = make_field("wide", {0, 0, 0}, {3000, 16, 16},
                                [](Vec3i p) { return p.x % 2990 < 8 ? 1.0 : 0.0; });
  const Field wider = make_field("wider", {0, 0, 0}, {1000, 1000, 8}, [](Vec3i p) {
    return (p.x % 990 < 8 && p.y % 990 < 8) ? 0.2 * (1 + (p.x + p.y + p.z) % 5) : 0.0;
  });
  for (const Field* f : {&wide, &wider}) {
    const DenseBounds b = make_dense_bounds(make_test_volume(*f, 100, std::nullopt).density);
    EXPECT_LE(b.word.size(), std::size_t(1) << 21) << f->name;
  }
}

}  // namespace dense_bounds_test
}  // namespace pvol::test
