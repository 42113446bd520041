// The children of a node of the octree with their cubes, for what looks at all of a tree.
#pragma once

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

/// Calls visit(low, edge, brick) for every leaf and uniform cube below a node whose low corner is
/// `at`, whatever the cut: its cube is low + [0, edge)^3.
template <class Visit>
void for_bricks(const Octree& tree, const Octree::Node& node, Vec3i at, const Visit& visit) {
  for_children(tree, node, at, [&](const Octree::Entry& e, Vec3i low, int edge) {
    if ((e.link & Octree::kNodeBit) == 0) return visit(low, edge, e.link);
    const Octree::Node& below = tree.nodes[e.link & ~Octree::kNodeBit];
    if (below.height > 0) return for_bricks(tree, below, low, visit);
    visit(low, edge, tree.entries[below.first].link);  // parts of a leaf
  });
}

}  // namespace pvol::detail
