#include "render/scene/box_tree.h"

#include <cmath>

#include "render/scene/boxes.h"

namespace pvol::detail {
namespace {

/// Rounded outward by at least one float's step, which is far more than the differences of doubles
/// before it are off.
Vec3f below(Vec3d v) {
  const Vec3f f(v);
  constexpr float kLow = -std::numeric_limits<float>::infinity();
  return {std::nextafter(f.x, kLow), std::nextafter(f.y, kLow), std::nextafter(f.z, kLow)};
}
Vec3f above(Vec3d v) { return -below(-v); }

double surface(const Box& b) {
  const Vec3d e = b.extent();
  return b.empty() ? 0 : e.x * e.y + e.y * e.z + e.z * e.x;
}

}  // namespace

struct BoxTree::Builder {
  std::span<const Box> boxes;
  BoxTree& tree;
  std::size_t most;
  std::vector<double> right{};  ///< surfaces of what lies behind a cut

  using Item = std::vector<std::uint32_t>::iterator;

  [[nodiscard]] Box around(Item begin, Item end) const {
    Box all;
    for (Item i = begin; i != end; ++i) all = join(all, boxes[*i]);
    return all;
  }

  /// Orders items by their middles along the axis where these spread most.
  void sort(Item begin, Item end) const {
    Box middles;
    for (Item i = begin; i != end; ++i) middles = extend(middles, boxes[*i].centre());
    const int axis = longest_axis(middles);
    std::stable_sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
      return boxes[a].lo[axis] + boxes[a].hi[axis] < boxes[b].lo[axis] + boxes[b].hi[axis];
    });
  }

  /// How many of the ordered items go to the first child: where surface times number is least
  /// (Goldsmith, Salmon. Automatic creation of object hierarchies for ray tracing. 1987).
  [[nodiscard]] std::size_t cut(Item begin, Item end) {
    const auto n = std::size_t(end - begin);
    right.assign(n, 0);
    Box all;
    for (std::size_t i = n - 1; i > 0; --i) {
      all = join(all, boxes[begin[std::ptrdiff_t(i)]]);
      right[i] = surface(all);
    }
    all = {};
    std::size_t best = n / 2;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < n; ++i) {
      all = join(all, boxes[begin[std::ptrdiff_t(i - 1)]]);
      const double cost = surface(all) * double(i) + right[i] * double(n - i);
      if (cost < least) least = cost, best = i;
    }
    return best;
  }

  void build(std::size_t node, Item begin, Item end, int depth) {
    const Box box = around(begin, end);
    const auto n = std::uint32_t(end - begin);
    tree.nodes_[node] = {below(box.lo - tree.origin_), above(box.hi - tree.origin_),
                         std::uint32_t(begin - tree.items_.begin()), n};
    if (n <= most) return;
    sort(begin, end);
    const std::size_t first = depth < kDepth / 2 ? cut(begin, end) : n / 2;
    const std::size_t child = tree.nodes_.size();
    tree.nodes_[node].first = std::uint32_t(child);
    tree.nodes_[node].items = 0;
    tree.nodes_.resize(child + 2);
    const Item middle = begin + std::ptrdiff_t(first);
    build(child, begin, middle, depth + 1);
    build(child + 1, middle, end, depth + 1);
  }
};

BoxTree::BoxTree(std::span<const Box> boxes, std::size_t most) {
  Box all;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].empty()) continue;
    items_.push_back(i);
    all = join(all, boxes[i]);
  }
  if (items_.empty()) return;
  origin_ = all.centre();
  nodes_.resize(1);
  Builder{boxes, *this, most}.build(0, items_.begin(), items_.end(), 0);
  nodes_.shrink_to_fit();
}

}  // namespace pvol::detail
