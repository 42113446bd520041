#include "pvol/shell/support.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <set>
#include <string>
#include <tuple>

#include "pvol/error.h"
#include "pvol/math/rng.h"
#include "support/effort.h"
#include "support/fields.h"

namespace pvol {
namespace support_test {

using Cells = std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>>;

/// Cells of the box around the samples, one wider, that have a corner above 0.
Cells occupied_by_definition(const test::Field& field) {
  Cells cells;
  for (int x = -2; x <= field.size.x; ++x) {
    for (int y = -2; y <= field.size.y; ++y) {
      for (int z = -2; z <= field.size.z; ++z) {
        const Vec3i at = field.origin + Vec3i(x, y, z);
        bool occupied = false;
        for (int c = 0; c < 8; ++c) occupied |= field.at(at + Vec3i(c & 1, c >> 1 & 1, c >> 2)) > 0;
        if (occupied) cells.insert({at.x, at.y, at.z});
      }
    }
  }
  return cells;
}

void collect(const Support& s, const SupportNode& node, Cells& cells, std::uint64_t& full_cells) {
  const std::int64_t edge = std::int64_t(1) << node.log2;
  if (node.full) full_cells += std::uint64_t(edge * edge * edge);
  if (node.log2 == 0) {
    EXPECT_TRUE(node.full);
    const bool added = cells.insert({node.lo.x, node.lo.y, node.lo.z}).second;
    EXPECT_TRUE(added) << "twice";
    return;
  }
  const SupportChildren c = children(s, node);
  EXPECT_GT(c.count, 0);
  EXPECT_TRUE(!node.full || c.count == 8);
  for (int i = 0; i < c.count; ++i) collect(s, c.node[std::size_t(i)], cells, full_cells);
}

Cells all_cells(const Support& s) {
  Cells cells;
  std::uint64_t full = 0;
  if (!s.empty()) collect(s, root(s), cells, full);
  return cells;
}

void expect_consistent(const Support& s) {
  for (std::size_t i = 0; i < s.blocks.size(); ++i) {
    const SupportBlock& b = s.blocks[i];
    ASSERT_EQ(b.code % (1ull << (3 * b.level)), 0u);
    if (i + 1 < s.blocks.size()) {
      ASSERT_LE(b.code + (1ull << (3 * b.level)), s.blocks[i + 1].code) << "overlap";
    }
  }
}

class SupportOfField : public testing::TestWithParam<test::Field> {};

TEST_P(SupportOfField, HasExactlyTheCellsWithACornerAboveZero) {
  const test::Field& field = GetParam();
  const Support s = make_support(field.grid, build_pyramid(field.grid));
  expect_consistent(s);
  const Cells expected = occupied_by_definition(field);
  EXPECT_EQ(all_cells(s), expected);
  EXPECT_EQ(s.cells, expected.size());
  Vec3l lo(1ll << 40), hi(-(1ll << 40));
  for (const auto& [x, y, z] : expected) {
    lo = min(lo, Vec3l(x, y, z));
    hi = max(hi, Vec3l(x + 1, y + 1, z + 1));
    EXPECT_TRUE(is_occupied(s, {x, y, z}));
  }
  EXPECT_EQ(s.lo, lo);
  EXPECT_EQ(s.hi, hi);
  Rng rng(1, 2, 3);
  for (int i = 0; i < 2000; ++i) {
    const auto draw = [&](int axis) {
      return s.lo[axis] - 2 + std::int64_t(rng.uniform() * float(s.hi[axis] - s.lo[axis] + 4));
    };
    const Vec3l cell{draw(0), draw(1), draw(2)};
    ASSERT_EQ(is_occupied(s, cell), expected.contains({cell.x, cell.y, cell.z}));
  }
}

INSTANTIATE_TEST_SUITE_P(Fields, SupportOfField, testing::ValuesIn(test::fields()),
                         [](const auto& test) {
                           std::string name = test.param.name;
                           for (char& c : name) c = std::isalnum(c) ? c : '_';
                           return name;
                         });

TEST(Support, MergesFullCubesUpToTheLargest) {
  const int edge = proof::runs_all() ? 4096 : 2048;
  VoxelGrid grid;
  grid.tiles = {{{0, 0, 0}, edge, 1.0f}};
  const Support s = make_support(grid, build_pyramid(grid));
  expect_consistent(s);
  const std::uint64_t cells = std::uint64_t(edge) + 1;
  EXPECT_EQ(s.cells, cells * cells * cells);
  std::uint32_t largest = 0;
  for (const SupportBlock& b : s.blocks) largest = std::max(largest, b.level);
  // The cells of the tile but for its first layers: cubes of half its edge.
  EXPECT_GE(8u << largest, std::uint32_t(edge) / 2);
  EXPECT_TRUE(is_occupied(s, {-1, edge - 1, 17}));
  EXPECT_FALSE(is_occupied(s, {-2, edge - 1, 17}));
  EXPECT_FALSE(is_occupied(s, {edge, edge - 1, 17}));
}

TEST(Support, OfSixtyFourFullBlocksIsOneCube) {
  std::vector<Vec3l> cells;
  for (int i = 0; i < 32 * 32 * 32; ++i) cells.push_back(Vec3l(i % 32, i / 32 % 32, i / 1024));
  const Support s = make_support(cells);
  ASSERT_EQ(s.blocks.size(), 1u);
  EXPECT_EQ(s.blocks[0].level, 2u);
  EXPECT_TRUE(root(s).full);
  EXPECT_EQ(all_cells(s).size(), cells.size());
}

TEST(Support, DoesNotMergeAcrossSmallerCubes) {
  // Seven blocks of eight full, the eighth with a hole.
  std::vector<Vec3l> cells;
  for (int i = 0; i < 16 * 16 * 16; ++i) {
    const Vec3l cell(i % 16, i / 16 % 16, i / 256);
    if (cell != Vec3l(9, 3, 12)) cells.push_back(cell);
  }
  const Support s = make_support(cells);
  EXPECT_EQ(s.blocks.size(), 8u);
  EXPECT_EQ(s.cells, 4095u);
  EXPECT_EQ(all_cells(s).size(), 4095u);
  EXPECT_FALSE(is_occupied(s, {9, 3, 12}));
}

TEST(Support, OfCellsFarApartIsSmall) {
  const Support s = make_support({{-8000000, 3, 5}, {8000000, 3, 5}, {8000000, 3, 5}});
  EXPECT_EQ(s.cells, 2u);
  EXPECT_EQ(s.blocks.size(), 2u);
  EXPECT_EQ(all_cells(s).size(), 2u);
  EXPECT_THROW(static_cast<void>(make_support({{0, 0, 0}, {1 << 24, 0, 0}})), Error);
}

TEST(Support, OfNothingIsEmpty) {
  EXPECT_TRUE(make_support(std::vector<Vec3l>{}).empty());
  EXPECT_TRUE(make_support(VoxelGrid{}, Pyramid{}).empty());
  EXPECT_FALSE(is_occupied(Support{}, {0, 0, 0}));
}

}  // namespace support_test
}  // namespace pvol
