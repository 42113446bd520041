// Boxes of the world in a tree: which of many a ray meets, near ones first.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/box.h"

namespace pvol::detail {

/// A bounding volume hierarchy whose items are the numbers of boxes.
///
/// Of our own, and not Embree's: what is met are volumes, for which Embree would call back for each
/// box and be told to go on; its boxes and distances are floats of the world, which clouds far from
/// the origin need in double; and pvol would depend on it for these lines. Here boxes are floats
/// relative to the middle of all, rounded outward, and rays are doubles: a box that a ray meets is
/// never missed, however far from the origin all lies. Boxes that fit into one leaf are no tree:
/// all of them are visited, in their order.
class BoxTree {
 public:
  static constexpr std::uint32_t kLeafItems = 4;

  BoxTree() = default;
  /// Empty boxes are left out. The items of a leaf, up to `most`, are visited without a test of
  /// their boxes: one, where visits take longer than that.
  explicit BoxTree(std::span<const Box> boxes, std::size_t most = kLeafItems);

  /// limit = visit(item, limit) for the items whose boxes the ray may meet before t = limit, that
  /// shrinks; nodes nearer to the ray's origin first. With others that it just misses.
  template <class Visit>
  void visit(const Ray& ray, double limit, const Visit& visit) const;

  /// visit(item) for the items whose boxes may hold the point.
  template <class Visit>
  void visit_at(Vec3d point, const Visit& visit) const {
    this->visit({point, {}}, 1, [&](std::uint32_t item, double limit) {
      visit(item);
      return limit;
    });
  }

  [[nodiscard]] std::size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + items_.capacity() * sizeof(items_[0]);
  }

 private:
  struct Node {
    Vec3f lo, hi;         ///< from `origin_`
    std::uint32_t first;  ///< of its items, or of its two children, side by side
    std::uint32_t items;  ///< 0: it has children
  };
  struct Builder;
  /// By halves below a depth of 32, so that no tree is deeper than that and the bits of a number.
  static constexpr int kDepth = 64;

  /// A ray that tests nodes.
  class Probe {
   public:
    explicit Probe(const Ray& ray, Vec3d origin)
        : o_(ray.o - origin), inverse_(1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z) {}

    /// Where it enters a node before the limit; above it where it does not. Differences to the
    /// exact interval and to that in the cells of a volume are some ulps of distances, far below
    /// what kWider leaves.
    [[nodiscard]] double enter(const Node& node, double limit) const {
      constexpr double kWider = 1 + 1e-12;
      double t0 = 0, t1 = limit;
      for (int axis = 0; axis < 3; ++axis) {
        const bool up = inverse_[axis] > 0;
        const double near = double((up ? node.lo : node.hi)[axis]) - o_[axis];
        const double far = double((up ? node.hi : node.lo)[axis]) - o_[axis];
        // On a face that the ray is parallel to, 0 * inf: min and max pass over what is no number.
        t0 = std::max(t0, near * inverse_[axis]);
        t1 = std::min(t1, far * inverse_[axis] * kWider);
      }
      return t0 <= t1 ? t0 : std::numeric_limits<double>::infinity();
    }

   private:
    Vec3d o_, inverse_;
  };

  Vec3d origin_;
  std::vector<Node> nodes_;  ///< the root first; none: there are no boxes
  std::vector<std::uint32_t> items_;
};

template <class Visit>
void BoxTree::visit(const Ray& ray, double limit, const Visit& visit) const {
  if (nodes_.empty()) return;
  if (nodes_.size() == 1) {  // few: their own tests are as good
    for (const std::uint32_t item : items_) limit = visit(item, limit);
    return;
  }
  struct Later {
    std::uint32_t node;
    double t;
  };
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::array<Later, kDepth> stack;
  std::size_t size = 0;
  const Probe probe(ray, origin_);
  std::uint32_t at = 0;
  if (probe.enter(nodes_[0], limit) == kNever) return;
  for (;;) {
    const Node& node = nodes_[at];
    if (node.items > 0) {
      for (std::uint32_t i = 0; i < node.items; ++i) limit = visit(items_[node.first + i], limit);
    } else {
      Later near{node.first, probe.enter(nodes_[node.first], limit)};
      Later far{node.first + 1, probe.enter(nodes_[node.first + 1], limit)};
      if (far.t < near.t) std::swap(near, far);
      if (far.t != kNever) stack[size++] = far;
      if (near.t != kNever) {
        at = near.node;
        continue;
      }
    }
    do {
      if (size == 0) return;
      --size;
    } while (!(stack[size].t < limit));
    at = stack[size].node;
  }
}

}  // namespace pvol::detail
