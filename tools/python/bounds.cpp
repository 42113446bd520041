#include "python/bounds.h"

#include <string>

#include "pvol/error.h"

namespace pvol::python {
namespace {

BoundRow row_of(Vec3l lo, std::int64_t edge, double minorant, double majorant) {
  return {{lo.x, lo.y, lo.z}, edge, minorant, majorant};
}

/// Adds the terminals below a node whose cube begins at `lo`.
void add_terminals(const Octree& tree, std::uint32_t id, Vec3l lo, std::vector<BoundRow>& rows) {
  const Octree::Node& node = tree.nodes[id];
  const std::int64_t edge = std::int64_t(1) << Octree::child_log2(int(node.height));
  std::uint64_t seen = 0;  // groups: bit 4 x + 2 y + z of the children's halves
  for (std::uint32_t bit = 0; bit < 64; ++bit) {
    const Octree::Entry* e = tree.child(node, bit);
    if (e == nullptr) continue;
    const Vec3l at(bit >> 4, bit >> 2 & 3, bit & 3);
    if (e->log2 == 0) {
      add_terminals(tree, e->link & ~Octree::kNodeBit, lo + at * edge, rows);
      continue;
    }
    Vec3l corner = at;
    if (e->grouped) {
      const Vec3l group(at.x / 2, at.y / 2, at.z / 2);
      const std::uint64_t mark = 1ull << (4 * group.x + 2 * group.y + group.z);
      if (seen & mark) continue;
      seen |= mark;
      corner = group * std::int64_t(2);
    }
    rows.push_back(
        row_of(lo + corner * edge, std::int64_t(1) << e->log2, double(e->lo), double(e->hi)));
  }
}

}  // namespace

std::vector<BoundRow> nodes_of(const Pyramid& pyramid, std::int64_t level, double extinction) {
  if (level < 0 || level >= std::int64_t(pyramid.levels.size())) {
    throw Error("level: found " + std::to_string(level) + ", expected one of the pyramid's " +
                std::to_string(pyramid.levels.size()) + ", from 0, the leaves, on");
  }
  const std::int64_t edge = std::int64_t(kLeafEdge) << level;
  std::vector<BoundRow> rows;
  rows.reserve(pyramid.levels[std::size_t(level)].size());
  for (const PyramidNode& n : pyramid.levels[std::size_t(level)]) {
    const Vec3l at(morton_decode(n.code));
    rows.push_back(row_of(pyramid.origin + at * edge, edge, extinction * double(n.lo),
                          extinction * double(n.hi)));
  }
  return rows;
}

std::vector<BoundRow> terminals_of(const Octree& tree) {
  std::vector<BoundRow> rows;
  rows.reserve(tree.terminals);
  if (!tree.empty()) add_terminals(tree, 0, tree.origin, rows);
  return rows;
}

}  // namespace pvol::python
