#include "pvol/bounds/leaf_index.h"

#include <algorithm>

#include "bounds/octree_children.h"

namespace pvol {
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
  // Leaves and uniform cubes, as far as they lie in the support.
  detail::for_bricks(tree, tree.nodes[0], {}, [&](Vec3i low, int edge, std::uint32_t brick) {
    const Vec3i begin = max(low, vec3(tree.support_lo & -8));
    const Vec3i end = min(low + Vec3i(edge), vec3(tree.support_hi));
    for (int x = begin.x; x < end.x; x += 8) {
      for (int y = begin.y; y < end.y; y += 8) {
        const std::int64_t row = (x >> 3) * index.slab + (y >> 3) * index.row - index.first;
        for (int z = begin.z; z < end.z; z += 8) index.brick[std::size_t(row + (z >> 3))] = brick;
      }
    }
  });
  return std::make_shared<const LeafIndex>(std::move(index));
}

}  // namespace pvol
