// The tree of boxes against a look at each of them.
#include "render/scene/box_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace pvol::detail {
namespace box_tree_test {

constexpr double kEndless = std::numeric_limits<double>::infinity();

struct World {
  std::mt19937_64 bits{5};
  std::vector<Box> boxes;
  Vec3d middle;
  double size;

  double uniform(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(bits); }
  Vec3d point(double reach) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
  }

  /// Boxes of sizes from 1/1000 to 1/3 of the world's, some as large as that, some of them flat,
  /// some mere lines, some empty, some twice.
  World(int count, Vec3d middle_, double size_) : middle(middle_), size(size_) {
    for (int i = 0; i < count; ++i) {
      const double most = i % 23 == 4 ? 2 : 0.3;
      const double reach = size * std::exp(uniform(std::log(1e-3), std::log(most)));
      const Vec3d at = middle + point(size);
      Box b;
      b = extend(extend(b, at), at + point(reach));
      if (i % 11 == 3) b.hi.x = b.lo.x;
      if (i % 13 == 5) b.hi.y = b.lo.y, b.hi.z = b.lo.z;
      if (i % 17 == 7) b = {};
      if (i % 19 == 8) b = boxes[std::size_t(bits() % boxes.size())];
      boxes.push_back(b);
    }
  }

  /// From outside, from inside, along axes, on faces, and from and to where nothing is.
  Ray ray(int i) {
    Vec3d from = middle + point(i % 3 == 0 ? 4 * size : size);
    const Box& some = boxes[std::size_t(bits() % boxes.size())];
    if (i % 5 == 1 && !some.empty()) from = some.lo;
    if (i % 5 == 2 && !some.empty()) from.x = some.hi.x;
    Vec3d d = normalize(point(1));
    if (i % 4 == 1) d = {i % 8 == 1 ? 1.0 : -1.0, 0, -0.0};
    if (i % 4 == 2) d.y = i % 8 == 2 ? 0.0 : -0.0;
    if (i % 7 == 3 && !some.empty()) d = normalize(some.centre() - from + Vec3d(1e-3 * size));
    return {from, d};
  }
};

const std::pair<Vec3d, double> kWorlds[] = {
    {{0, 0, 0}, 1}, {{1e6, -1e6, 1e6}, 1}, {{-3, 2, 1e9}, 1e-3}, {{0, 1e-4, 0}, 1e9}};

TEST(BoxTree, MissesNoBoxThatARayMeets) {
  for (const auto& [middle, size] : kWorlds) {
    for (const int count : {1, 4, 5, 9, 300}) {
      World world(count, middle, size);
      const BoxTree full(world.boxes), single(world.boxes, 1);  // leaves
      for (int i = 0; i < 2000; ++i) {
        const BoxTree& tree = world.bits() % 2 ? single : full;
        const Ray ray = world.ray(i);
        const double limit = i % 2 ? kEndless : world.uniform(0, 3 * size);
        std::vector<int> visits(world.boxes.size());
        tree.visit(ray, limit, [&](std::uint32_t item, double t) {
          ++visits[item];
          return t;
        });
        for (std::size_t k = 0; k < visits.size(); ++k) {
          ASSERT_LE(visits[k], 1);
          if (intersect(world.boxes[k], ray, 0, limit)) {
            ASSERT_EQ(visits[k], 1) << "ray " << i << ", box " << k << " of " << count;
          }
          if (world.boxes[k].empty()) {
            ASSERT_EQ(visits[k], 0);
          }
        }
      }
    }
  }
}

TEST(BoxTree, ALimitThatShrinksFindsTheNearest) {
  for (const auto& [middle, size] : kWorlds) {
    World world(400, middle, size);
    const BoxTree tree(world.boxes);
    // What lies in a box begins anywhere in it.
    std::vector<double> within;
    for (std::size_t k = 0; k < world.boxes.size(); ++k) within.push_back(world.uniform(0, 1));
    const auto begin_of = [&](std::size_t k, const Ray& ray) {
      const auto span = intersect(world.boxes[k], ray, 0, kEndless);
      return span ? span->t0 + within[k] * (span->t1 - span->t0) : kEndless;
    };
    std::uint64_t visits = 0, all = 0;
    for (int i = 0; i < 4000; ++i) {
      const Ray ray = world.ray(i);
      double nearest = kEndless, found = kEndless;
      for (std::size_t k = 0; k < world.boxes.size(); ++k) {
        nearest = std::min(nearest, begin_of(k, ray));
      }
      tree.visit(ray, kEndless, [&](std::uint32_t item, double limit) {
        ++visits;
        found = std::min(found, begin_of(item, ray));
        return std::min(found, limit);
      });
      ASSERT_EQ(found, nearest) << i;
      all += world.boxes.size();
    }
    EXPECT_LT(visits, all / 10) << "a tree saves work";
  }
}

TEST(BoxTree, EndsWhereTheLimitIsZero) {
  World world(300, {}, 1);
  const BoxTree tree(world.boxes);
  for (int i = 0; i < 500; ++i) {
    int after = 0;
    bool ended = false;
    tree.visit(world.ray(i), kEndless, [&](std::uint32_t, double) {
      after += ended;
      ended = true;
      return 0.0;
    });
    // The rest of a leaf may still be told the limit.
    ASSERT_LT(after, int(BoxTree::kLeafItems));
  }
}

TEST(BoxTree, OfLeavesOfOneEndsAtOnce) {
  World world(300, {}, 1);
  for (const std::size_t boxes : {std::size_t(1), std::size_t(2), world.boxes.size()}) {
    const BoxTree tree(std::span(world.boxes).first(boxes), 1);
    for (int i = 0; i < 500; ++i) {
      int visits = 0;
      tree.visit(world.ray(i), kEndless, [&](std::uint32_t item, double) {
        EXPECT_LT(item, boxes);
        ++visits;
        return 0.0;
      });
      ASSERT_LE(visits, 1);
    }
  }
}

TEST(BoxTree, FindsWhatHoldsAPoint) {
  for (const auto& [middle, size] : kWorlds) {
    World world(300, middle, size);
    const BoxTree tree(world.boxes);
    std::uint64_t visits = 0;
    constexpr int kPoints = 2000;
    for (int i = 0; i < kPoints; ++i) {
      const Box& some = world.boxes[std::size_t(world.bits() % world.boxes.size())];
      const Vec3d p = i % 3 == 0 && !some.empty() ? some.hi : middle + world.point(size);
      std::vector<bool> visited(world.boxes.size());
      tree.visit_at(p, [&](std::uint32_t item) { visited[item] = true, ++visits; });
      for (std::size_t k = 0; k < visited.size(); ++k) {
        if (world.boxes[k].contains(p)) {
          ASSERT_TRUE(visited[k]);
        }
      }
    }
    EXPECT_LT(visits, kPoints * world.boxes.size() / 10);
  }
}

TEST(BoxTree, FewBoxesAreVisitedInTheirOrder) {
  std::vector<Box> boxes;
  for (const double x : {9.0, 0.0, 6.0, 3.0}) boxes.push_back({Vec3d(x, 0, 0), Vec3d(x + 1, 1, 1)});
  const BoxTree tree(boxes);
  std::vector<std::uint32_t> order;
  tree.visit({{-5, 0.5, 0.5}, {1, 0, 0}}, kEndless, [&](std::uint32_t item, double limit) {
    order.push_back(item);
    return limit;
  });
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 1, 2, 3}));
}

TEST(BoxTree, OfNothingVisitsNothing) {
  const std::vector<Box> empty(7);
  for (const auto& tree : {BoxTree(), BoxTree(empty), BoxTree(std::span<const Box>())}) {
    tree.visit({{0, 0, 0}, {1, 0, 0}}, kEndless, [&](std::uint32_t, double limit) {
      ADD_FAILURE();
      return limit;
    });
  }
}

/// Middles in one place leave nothing to order by.
TEST(BoxTree, ThousandsInOnePlaceStayShallow) {
  std::vector<Box> boxes;
  for (int i = 0; i < 20'000; ++i) boxes.push_back({Vec3d(-1.0 - i), Vec3d(1.0 + i)});
  const BoxTree tree(boxes);
  std::size_t visits = 0;
  tree.visit({{0.1, 0.2, -1e6}, {0, 0, 1}}, kEndless, [&](std::uint32_t, double limit) {
    ++visits;
    return limit;
  });
  EXPECT_EQ(visits, boxes.size());
  EXPECT_LT(tree.bytes(), boxes.size() * 64);
}

}  // namespace box_tree_test
}  // namespace pvol::detail
