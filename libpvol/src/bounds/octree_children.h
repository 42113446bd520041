// The children of a node of the octree with their cubes, for what looks at all of a tree.
#pragma once

#include <algorithm>
#include <bit>
#include <span>

#include "pvol/bounds/octree.h"

namespace pvol::detail {

/// Calls visit(entry, at, edge) for every child of `node` that is not empty: its cube is at + [0,
/// edge)^3, in cells from the octree's origin, as `low` is the low corner of the node's.
template <class Visit>
void for_children(const Octree& tree, const Octree::Node& node, Vec3i low, const Visit& visit) {
  const int edge = 1 << Octree::child_log2(int(node.height));
  for (std::uint32_t bit = 0; bit < 64; ++bit) {
    const Octree::Entry* e = tree.child(node, bit);
    if (e == nullptr) continue;
    visit(*e, low + Vec3i(int(bit >> 4), int(bit >> 2 & 3), int(bit & 3)) * edge, edge);
  }
}

/// The brick of the leaf or uniform cube that holds a cell, whatever the cut, where `brick_at` has
/// none for cells in empty parts of a leaf; `zero_brick` for cells in none of them.
[[nodiscard]] inline std::uint32_t brick_of_leaf(const Octree& tree, Int4 cell,
                                                 std::uint32_t zero_brick) {
  LeafHandle at = Octree::kNodeBit;
  while (at & Octree::kNodeBit) {
    const Octree::Node& node = tree.nodes[at & ~Octree::kNodeBit];
    const std::uint32_t bit = Octree::child_bit(cell, Octree::child_log2(int(node.height)));
    const Octree::Entry* e = node.height == 0 ? &tree.entries[node.first] : tree.child(node, bit);
    if (e == nullptr) return zero_brick;
    at = e->link;
  }
  return at;
}

/// Calls visit(low, edge, entry) for every leaf and uniform cube below a node whose low corner is
/// `at`, whatever the cut: its cube is low + [0, edge)^3, and the entry has its brick and bounds.
template <class Visit>
void for_leaves(const Octree& tree, const Octree::Node& node, Vec3i at, const Visit& visit) {
  for_children(tree, node, at, [&](const Octree::Entry& e, Vec3i low, int edge) {
    if ((e.link & Octree::kNodeBit) == 0) return visit(low, edge, e);
    const Octree::Node& below = tree.nodes[e.link & ~Octree::kNodeBit];
    if (below.height > 0) return for_leaves(tree, below, low, visit);
    // Parts of a leaf; nothing is in those that are not there.
    constexpr std::size_t kAll = 64;
    const std::span parts(&tree.entries[below.first], std::size_t(std::popcount(below.mask)));
    Octree::Entry leaf = parts.front();
    if (parts.size() < kAll) leaf.lo = 0;
    for (const Octree::Entry& part : parts) {
      leaf.lo = std::min(leaf.lo, part.lo), leaf.hi = std::max(leaf.hi, part.hi);
    }
    visit(low, edge, leaf);
  });
}

/// Calls visit(low, edge, brick) for the same.
template <class Visit>
void for_bricks(const Octree& tree, const Octree::Node& node, Vec3i at, const Visit& visit) {
  for_leaves(tree, node, at,
             [&](Vec3i low, int edge, const Octree::Entry& e) { visit(low, edge, e.link); });
}

}  // namespace pvol::detail
