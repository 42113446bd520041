#include "render/scene/box_neighbours.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "render/scene/boxes.h"

namespace pvol::detail {
namespace {

constexpr std::size_t kMostTests = 400'000'000;  // of two boxes

/// The box around the middles of boxes.
Box around_middles(std::span<const Box> boxes) {
  Box middles;
  for (const Box& b : boxes) {
    if (!b.empty()) middles = extend(middles, b.centre());
  }
  return middles;
}

}  // namespace

BoxNeighbours::BoxNeighbours(std::span<const Box> boxes)
    : of_(boxes.size()), crowded_(boxes.size()) {
  const int axis = longest_axis(around_middles(boxes));
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return boxes[i].lo[axis]; });
  const auto tested_each = std::max<std::size_t>(1000, kMostTests / (boxes.size() + 1));
  // Boxes that were compared with too many, and the first of the order that they were not.
  std::vector<std::pair<std::uint32_t, std::size_t>> wide;
  double crowded_to = -std::numeric_limits<double>::infinity();  // once these are too many
  for (std::size_t a = 0; a < order.size(); ++a) {
    const std::uint32_t i = order[a];
    if (boxes[i].lo[axis] <= crowded_to) crowded_[i] = 1;
    for (const auto& [other, rest] : wide) {
      if (a >= rest && meet(boxes[i], boxes[other])) add(i, other);
    }
    const auto reaches = [&](std::size_t b) {
      return b < order.size() && boxes[order[b]].lo[axis] <= boxes[i].hi[axis];
    };
    std::size_t b = a + 1;
    for (; reaches(b) && b - a <= tested_each && of_[i].size() <= kMost; ++b) {
      if (meet(boxes[i], boxes[order[b]])) add(i, order[b]), add(order[b], i);
    }
    if (!reaches(b)) continue;
    crowded_[i] = 1;
    if (wide.size() < kMost) {
      wide.emplace_back(i, b);
    } else {
      crowded_to = std::max(crowded_to, boxes[i].hi[axis]);
    }
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) crowded_[i] |= of_[i].size() > kMost;
}

void BoxNeighbours::add(std::uint32_t box, std::uint32_t other) {
  if (of_[box].size() <= kMost) of_[box].push_back(other);
}

}  // namespace pvol::detail
