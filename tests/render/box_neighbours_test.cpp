// Which boxes meet which, against all pairs.
#include "render/scene/box_neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/scene/boxes.h"

namespace pvol::detail {
namespace box_neighbours_test {

/// Boxes of many sizes, spread along the second axis; some of them are empty.
std::vector<Box> scattered(std::size_t count, double largest) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Box> boxes(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 17 == 3) continue;
    const Vec3d low(uniform(random), 5 * uniform(random), uniform(random));
    const Vec3d edges(uniform(random), uniform(random), uniform(random));
    boxes[i] = {low, low + edges * largest};
  }
  return boxes;
}

std::vector<std::uint32_t> in_order(std::span<const std::uint32_t> of) {
  std::vector<std::uint32_t> all(of.begin(), of.end());
  std::ranges::sort(all);
  return all;
}

TEST(BoxNeighbours, AreThoseThatMeet) {
  const std::vector<Box> boxes = scattered(300, 0.5);
  const BoxNeighbours found(boxes);
  std::size_t pairs = 0;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t k = 0; k < boxes.size(); ++k) {
      if (k != i && meet(boxes[i], boxes[k])) expected.push_back(k);
    }
    EXPECT_FALSE(found.crowded(i));
    EXPECT_EQ(in_order(found.of(i)), expected) << i;
    pairs += expected.size();
  }
  EXPECT_GT(pairs, boxes.size());
}

TEST(BoxNeighbours, OfMoreThanTheMostAreCrowded) {
  std::vector<Box> boxes;
  for (int i = 0; i < 200; ++i) boxes.push_back({Vec3d(i), Vec3d(i + 0.5)});
  boxes.push_back({Vec3d(0), Vec3d(double(BoxNeighbours::kMost) - 0.7)});  // meets as many
  boxes.push_back({Vec3d(100.4), Vec3d(200)});
  const BoxNeighbours found(boxes);
  EXPECT_FALSE(found.crowded(200));
  EXPECT_EQ(found.of(200).size(), BoxNeighbours::kMost);
  EXPECT_TRUE(found.crowded(201));
  for (std::uint32_t i = 0; i < 200; ++i) EXPECT_FALSE(found.crowded(i)) << i;
}

TEST(BoxNeighbours, AreNeverMissedWhereNoneIsCrowded) {
  // So many in one place that not all pairs are compared: what is not crowded knows all of its own.
  constexpr std::size_t kPiled = 3000;
  std::vector<Box> boxes(kPiled, Box{Vec3d(0), Vec3d(1, 4000, 1)});
  for (int i = 0; i < 2000; ++i) boxes.push_back({Vec3d(5, i, 0), Vec3d(6, i + 1.5, 1)});
  boxes.push_back({Vec3d(0, 3999, 0), Vec3d(6, 4001, 1)});
  const BoxNeighbours found(boxes);
  for (std::uint32_t i = 0; i < kPiled; ++i) EXPECT_TRUE(found.crowded(i)) << i;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (found.crowded(i)) continue;
    std::size_t expected = 0;
    for (std::uint32_t k = 0; k < boxes.size(); ++k) {
      expected += k != i && meet(boxes[i], boxes[k]) ? 1 : 0;
    }
    EXPECT_EQ(found.of(i).size(), expected) << i;
  }
}

}  // namespace box_neighbours_test
}  // namespace pvol::detail
