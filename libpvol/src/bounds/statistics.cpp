#include "pvol/bounds/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "bounds/box_volume.h"
#include "bounds/octree_children.h"
#include "density/lattice_index.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using detail::volume_in_box;

double cube_volume(std::size_t level) {
  return std::ldexp(double(kLeafEdge) * kLeafEdge * kLeafEdge, 3 * int(level));
}

/// What the samples in a leaf's reach add up to.
struct LeafSums {
  double mass = 0;
  float lo = std::numeric_limits<float>::infinity(), hi = 0;
};

/// The integral over a leaf, along one axis, of the kernel of sample i, which counts from the
/// leaf's first cell. Trilinear: a sample on a face is shared with the leaf beyond. Tricubic: a
/// cell integrates its four samples with weights 1/24, 11/24, 11/24, 1/24.
double kernel_share(LookUp look_up, int i) {
  const int inward = std::min(i, kLeafEdge - i);  // of the nearer face; -1 outside
  if (look_up != LookUp::tricubic) return inward == 0 ? 0.5 : 1;
  constexpr double kShares[] = {1.0 / 24, 12.0 / 24, 23.0 / 24, 1};
  return kShares[std::min(inward + 1, 3)];
}

LeafSums sum_leaf(const detail::BlockFinder& blocks, Vec3i origin, LookUp look_up) {
  const auto share = [&](int i) { return kernel_share(look_up, i); };
  LeafSums s;
  const auto add = [&](const detail::BlockSource& b, Vec3i from, Vec3i count, Vec3i to) {
    for (int i = 0; i < count.x; ++i) {
      for (int j = 0; j < count.y; ++j) {
        double line = 0;
        for (int k = 0; k < count.z; ++k) {
          const int at = ((from.x + i) * 8 + from.y + j) * 8 + from.z + k;
          const float v = b.values ? b.values[at] : b.constant;
          line += share(to.z + k) * double(v);
          s.lo = std::min(s.lo, v);
          s.hi = std::max(s.hi, v);
        }
        s.mass += share(to.x + i) * share(to.y + j) * line;
      }
    }
  };
  detail::for_blocks_in_extent(blocks, origin, extent_of(look_up), add);
  return s;
}

/// A bound summed over volume, and over volume weighted with the mean density.
struct BoundSums {
  double even = 0, dense = 0;

  void add(double bound, double volume, double mass) {
    even += bound * volume;
    dense += bound * mass;
  }
};

/// The same sums of the density itself, over leaves: what a perfect bound would give.
BoundSums perfect(const Pyramid& p, const PyramidContent& content) {
  BoundSums s;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < content[level].size(); ++i) {
      const NodeContent& n = content[level][i];
      if (!n.leaf) continue;
      const double volume = volume_in_box(p, level, p.levels[level][i].code);
      s.add(n.mass / volume, volume, n.mass);
    }
  }
  return s;
}

CollisionCost operator/(const BoundSums& bound, const BoundSums& density) {
  return {bound.even / density.even, bound.dense / density.dense};
}

DepthStatistics measure_depth(const Pyramid& p, const PyramidContent& content, std::size_t level,
                              const BoundSums& density) {
  DepthStatistics d;
  d.depth = int(p.levels.size() - 1 - level);
  d.edge = std::int64_t(kLeafEdge) << level;
  d.nodes = p.levels[level].size();
  BoundSums hi, gap;
  for (std::size_t l = level; l < p.levels.size(); ++l) {
    for (std::size_t i = 0; i < p.levels[l].size(); ++i) {
      const PyramidNode& n = p.levels[l][i];
      const NodeContent& c = content[l][i];
      const double volume = volume_in_box(p, l, n.code);
      if (l == level) {
        const double mean = c.mass / volume;
        d.mean_hi += double(n.hi) / mean / double(d.nodes);
        d.mean_lo += double(n.lo) / mean / double(d.nodes);
        d.leaves += c.leaf ? 1 : 0;
      } else if (!c.leaf) {
        continue;
      }
      hi.add(double(n.hi), volume, c.mass);
      gap.add(double(n.hi) - double(n.lo), volume, c.mass);
    }
  }
  d.tightness = {hi / density, gap / density};
  return d;
}

/// Masses of the level below into their parents, which stand in the same order.
void add_children(const Pyramid& p, std::size_t level, PyramidContent& content) {
  std::size_t parent = 0;
  for (std::size_t i = 0; i < content[level - 1].size(); ++i) {
    while (p.levels[level][parent].code != p.levels[level - 1][i].code / 8) ++parent;
    content[level][parent].mass += content[level - 1][i].mass;
    content[level][parent].leaf = false;
  }
}

/// Calls visit(entry, share) for the terminals of the leaf that begins at a cell, counted from the
/// tree's origin, with their shares of its mass: for parts of a leaf, about as the middles of their
/// bounds.
template <class Visit>
void visit_terminals_of_leaf(const Octree& tree, Vec3i cell, const Visit& visit) {
  const Octree::Node* n = &tree.nodes[0];
  while (n->height > 0) {
    const Octree::Entry* e =
        tree.child(*n, Octree::child_bit(widen(cell), Octree::child_log2(int(n->height))));
    if (e == nullptr) return;
    if (e->log2 != 0) return visit(*e, 1.0);
    n = &tree.nodes[e->link & ~Octree::kNodeBit];
  }
  double sum = 0;
  const auto middle = [](const Octree::Entry& e) { return double(e.lo) + double(e.hi); };
  detail::for_children(tree, *n, {}, [&](const Octree::Entry& e, Vec3i, int) { sum += middle(e); });
  detail::for_children(tree, *n, {},
                       [&](const Octree::Entry& e, Vec3i, int) { visit(e, middle(e) / sum); });
}

/// Calls `visit(entry, origin, edge)` for every terminal below a node at `origin`, in cells; one
/// that is a group of eight children comes child by child. The tree below terminals serves look-ups
/// only.
template <class Visit>
void for_each_terminal(const Octree& tree, const Octree::Node& node, Vec3l origin,
                       const Visit& visit) {
  const std::int64_t edge = std::int64_t(1) << Octree::child_log2(int(node.height));
  std::uint64_t left = node.mask;
  for (std::uint32_t k = 0; left != 0; ++k, left &= left - 1) {
    const int bit = std::countr_zero(left);
    const Octree::Entry& e = tree.entries[node.first + k];
    const Vec3l at = origin + Vec3l(bit >> 4, bit >> 2 & 3, bit & 3) * edge;
    if (e.log2 != 0) {
      visit(e, at, edge);
    } else {
      for_each_terminal(tree, tree.nodes[e.link & ~Octree::kNodeBit], at, visit);
    }
  }
}

}  // namespace

PyramidContent measure_content(const VoxelGrid& grid, const Pyramid& pyramid) {
  const detail::BlockFinder blocks(grid);
  PyramidContent content(pyramid.levels.size());
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    const auto& nodes = pyramid.levels[level];
    content[level].assign(nodes.size(), {0, true, false});
    if (level > 0) add_children(pyramid, level, content);
    parallel_parts(0, nodes.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        if (!content[level][i].leaf) continue;
        // A leaf above the finest level is uniform: any 8^3 cells of it tell its density.
        const Vec3l at = Vec3l(morton_decode(nodes[i].code)) * (std::int64_t(kLeafEdge) << level);
        const LeafSums s = sum_leaf(blocks, Vec3i(pyramid.origin + at), pyramid.look_up);
        content[level][i] = {s.mass * (cube_volume(level) / cube_volume(0)), true, s.lo == s.hi};
      }
    });
  }
  return content;
}

BoundsStatistics measure_bounds(const Pyramid& pyramid, const PyramidContent& content) {
  BoundsStatistics s;
  if (pyramid.empty()) return s;
  const BoundSums density = perfect(pyramid, content);
  s.mass = density.even;
  s.root_volume = cube_volume(pyramid.levels.size() - 1);
  for (std::size_t level = pyramid.levels.size(); level-- > 0;) {
    s.depths.push_back(measure_depth(pyramid, content, level, density));
    for (const NodeContent& n : content[level]) {
      if (!n.leaf) continue;
      ClassStatistics& kind = n.uniform ? s.uniform : s.mixed;
      ++kind.leaves;
      kind.volume += cube_volume(level);
      kind.mass += n.mass;
    }
  }
  s.empty.volume = s.root_volume - s.uniform.volume - s.mixed.volume;
  const Vec3d box = pyramid.support().extent();
  BoundSums global;
  global.add(double(pyramid.levels.back()[0].hi), box.x * box.y * box.z, s.mass);
  s.global_majorant = global / density;
  return s;
}

Tightness measure_cut(const Pyramid& pyramid, const PyramidContent& content, const Octree& tree,
                      double extinction) {
  BoundSums hi, gap;
  // Over volume: every terminal, also where it covers leaves that hold nothing.
  if (!tree.empty()) {
    const auto add = [&](const Octree::Entry& e, Vec3l origin, std::int64_t edge) {
      const double volume = volume_in_box(pyramid, origin, edge);
      hi.even += double(e.hi) / extinction * volume;
      gap.even += (double(e.hi) - double(e.lo)) / extinction * volume;
    };
    for_each_terminal(tree, tree.nodes[0], pyramid.origin, add);
  }
  // Over mass: leaf by leaf, with the bounds of the terminal above it.
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      const NodeContent& c = content[level][i];
      if (!c.leaf) continue;
      const Vec3i cell = Vec3i(morton_decode(pyramid.levels[level][i].code)) * (kLeafEdge << level);
      visit_terminals_of_leaf(tree, cell, [&](const Octree::Entry& e, double share) {
        hi.dense += double(e.hi) / extinction * c.mass * share;
        gap.dense += (double(e.hi) - double(e.lo)) / extinction * c.mass * share;
      });
    }
  }
  const BoundSums density = perfect(pyramid, content);
  return {hi / density, gap / density};
}

}  // namespace pvol
