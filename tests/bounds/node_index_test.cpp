#include "pvol/bounds/node_index.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <span>
#include <vector>

namespace pvol {
namespace node_index_test {

std::vector<PyramidNode> level_of(const std::set<std::uint64_t>& codes) {
  std::vector<PyramidNode> level;
  for (const std::uint64_t code : codes) level.push_back({code, 0, 1});
  return level;
}

/// Codes that are spread evenly, in clusters with large gaps between them, and far apart.
TEST(NodeIndex, FindsWhatASearchOfTheLevelFinds) {
  std::mt19937_64 random(1);
  for (const std::uint64_t most : {8u, 4096u, 1u << 20}) {
    for (const std::uint64_t cluster : {1u, 7u, 100u}) {
      std::set<std::uint64_t> codes;
      for (int i = 0; i < 300; ++i) {
        const std::uint64_t first = random() % most * most;
        for (std::uint64_t k = 0; k < cluster; ++k) codes.insert(first + k);
      }
      const std::vector<PyramidNode> level = level_of(codes);
      const NodeIndex index(level);
      for (const std::uint64_t code : codes) {
        for (const std::uint64_t near : {code - 1, code, code + 1, random() % (most * most)}) {
          EXPECT_EQ(index.find(near), find(level, near)) << near;
        }
      }
      EXPECT_FALSE(index.find(~std::uint64_t(0)));
    }
  }
}

TEST(NodeIndex, OfFewNodesWorks) {
  EXPECT_FALSE(NodeIndex(std::span<const PyramidNode>()).find(0));
  EXPECT_FALSE(NodeIndex(Pyramid()).find(0));
  for (const std::uint64_t code : {std::uint64_t(0), std::uint64_t(1), ~std::uint64_t(0)}) {
    const std::vector<PyramidNode> level = level_of({code});
    const NodeIndex index(level);
    EXPECT_EQ(index.find(code), 0u);
    EXPECT_FALSE(index.find(code ^ 1));
  }
}

/// Levels of damaged files are indexed before they are found to be wrong.
TEST(NodeIndex, OfCodesOutOfOrderStaysInThem) {
  std::mt19937_64 random(2);
  std::vector<PyramidNode> level;
  for (int i = 0; i < 1000; ++i) level.push_back({random() >> (random() % 64), 0, 1});
  const NodeIndex index(level);
  for (const PyramidNode& n : level) {
    const auto found = index.find(n.code);
    if (found) {
      EXPECT_EQ(level.at(*found).code, n.code);
    }
  }
}

}  // namespace node_index_test
}  // namespace pvol
