#include "pvol/bounds/integrals.h"

#include "bounds/octree_children.h"

namespace pvol {
namespace {

void add_node(const Octree& tree, const Octree::Node& node, Vec3i low, BoundIntegrals& sum) {
  detail::for_children(tree, node, low, [&](const Octree::Entry& e, Vec3i at, int edge) {
    if (e.log2 == 0) return add_node(tree, tree.nodes[e.link & ~Octree::kNodeBit], at, sum);
    // Of a group of eight children, each adds its own cube. Walks end at the support's box.
    const Vec3i end = min(at + Vec3i(edge), vec3(tree.support_hi));
    const Vec3d extent(max(end - max(at, vec3(tree.support_lo)), Vec3i(0)));
    const double cells = extent.x * extent.y * extent.z;
    sum.lo += double(e.lo) * cells;
    sum.hi += double(e.hi) * cells;
  });
}

}  // namespace

BoundIntegrals integrate_bounds(const Octree& octree) {
  BoundIntegrals sum;
  if (!octree.empty()) add_node(octree, octree.nodes[0], {0, 0, 0}, sum);
  return sum;
}

}  // namespace pvol
