#include "pvol/bounds/leaf_index.h"

#include <algorithm>

#include "bounds/octree_children.h"

namespace pvol {
namespace {

/// Writes the bricks below a node of the tree whose low corner this is.
void add_node(const Octree& tree, const Octree::Node& node, Vec3i corner, LeafIndex& out) {
  // A leaf, or a uniform cube, as far as it lies in the support.
  const auto add_cube = [&](Vec3i low, int edge, std::uint32_t brick) {
    const Vec3i begin = max(low, vec3(tree.support_lo & -8));
    const Vec3i end = min(low + Vec3i(edge), vec3(tree.support_hi));
    for (int x = begin.x; x < end.x; x += 8) {
      for (int y = begin.y; y < end.y; y += 8) {
        const std::int64_t row = (x >> 3) * out.slab + (y >> 3) * out.row - out.first;
        for (int z = begin.z; z < end.z; z += 8) out.brick[std::size_t(row + (z >> 3))] = brick;
      }
    }
  };
  detail::for_children(tree, node, corner, [&](const Octree::Entry& e, Vec3i low, int edge) {
    if (e.link & Octree::kNodeBit) {
      add_node(tree, tree.nodes[e.link & ~Octree::kNodeBit], low, out);
    } else {
      add_cube(low, edge, e.link);
    }
  });
}

}  // namespace

std::shared_ptr<const LeafIndex> index_leaves(const Octree& tree, std::uint64_t most_bytes) {
  if (tree.empty()) return nullptr;
  const Vec3l first(vec3(tree.support_lo >> 3));
  const Vec3l size = Vec3l(vec3((tree.support_hi - 1) >> 3)) + Vec3l(1) - first;
  // In double, since the box may have more leaves than there are integers.
  const double leaves = double(size.x) * double(size.y) * double(size.z);
  if (leaves * sizeof(std::uint32_t) > double(most_bytes)) return nullptr;
  LeafIndex index;
  index.row = size.z;
  index.slab = size.y * size.z;
  index.first = first.x * index.slab + first.y * index.row + first.z;
  index.brick.assign(std::size_t(leaves), 0);
  add_node(tree, tree.nodes[0], {0, 0, 0}, index);
  return std::make_shared<const LeafIndex>(std::move(index));
}

}  // namespace pvol
