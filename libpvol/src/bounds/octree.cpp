// Choosing where the walk stops, and laying the tree out for it.
#include "pvol/bounds/octree.h"

#include <array>
#include <cmath>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"

namespace pvol {
namespace {

using Stops = std::vector<std::vector<char>>;  // by level and node: whether the walk stops there

Stops stops_at_depth(const Pyramid& p, int depth) {
  const int root = int(p.levels.size()) - 1;
  const int cut = std::max(0, root - depth);
  Stops stops(p.levels.size());
  for (int level = 0; level <= root; ++level) {
    const auto& nodes = p.levels[std::size_t(level)];
    auto& stop = stops[std::size_t(level)];
    stop.assign(nodes.size(), char(level <= cut));
    for (std::size_t i = 0; level > cut && i < nodes.size(); ++i) {
      stop[i] = char(is_uniform(p, std::size_t(level), i));
    }
  }
  return stops;
}

/// The cheapest cut, bottom up (THEORY.md, T2.1). The cost of a node is that of a ray that crosses
/// it: a mean chord of 2/3 of its edge if the walk stops, else each child's cost times the share of
/// crossing rays that cross the child, 1/4 (its surface over its parent's).
Stops stops_by_cost(const Pyramid& p, double extinction, double cell_length,
                    const WalkCosts& costs) {
  constexpr double kChordOverEdge = 2.0 / 3.0;
  constexpr double kChildShare = 0.25;
  Stops stops(p.levels.size());
  std::vector<double> below, here;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const auto& nodes = p.levels[level];
    const double chord = kChordOverEdge * cell_length * std::ldexp(double(kLeafEdge), int(level));
    stops[level].resize(nodes.size());
    here.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const PyramidNode& n = nodes[i];
      const double hi = extinction * double(n.hi), gap = extinction * double(n.hi - n.lo);
      const double stop = costs.segment + chord * (hi * costs.tentative + gap * costs.lookup);
      const NodeRange c = children(p, level, i);
      double descend = double(8 - (c.end - c.begin)) * kChildShare * costs.skip;
      for (std::size_t k = c.begin; k < c.end; ++k) descend += kChildShare * below[k];
      const bool stops_here = c.empty() || stop <= descend;
      stops[level][i] = char(stops_here);
      here[i] = stops_here ? stop : descend;
    }
    below.swap(here);
  }
  return stops;
}

/// The terminals that a walk from the root meets: how many, and the deepest.
void count_terminals(const Pyramid& p, const Stops& stops, Octree& tree) {
  const int root = int(p.levels.size()) - 1;
  std::vector<std::size_t> here(p.empty() ? 0 : 1);  // nodes of a level that are reached
  for (int level = root; level >= 0; --level) {
    std::vector<std::size_t> below;
    for (const std::size_t i : here) {
      if (stops[std::size_t(level)][i]) {
        ++tree.terminals;
        tree.depth = root - level;
        continue;
      }
      const NodeRange c = children(p, std::size_t(level), i);
      for (std::size_t k = c.begin; k < c.end; ++k) below.push_back(k);
    }
    here.swap(below);
  }
}

/// Lays out one node after the other, from the root.
class Layout {
 public:
  Layout(const Pyramid& p, float extinction, const Stops& stops,
         const std::vector<std::vector<std::uint32_t>>& brick_of, std::uint32_t zero_brick)
      : p_(p), extinction_(extinction), stops_(stops), brick_of_(brick_of), zero_(zero_brick) {}

  Octree run() {
    tree_.origin = p_.origin;
    tree_.support_lo = lanes(Vec3i(p_.support_lo - p_.origin));
    tree_.support_hi = lanes(Vec3i(p_.support_hi - p_.origin));
    if (p_.empty()) return std::move(tree_);
    count_terminals(p_, stops_, tree_);
    tree_.height = root_level() / 2;
    add_node(tree_.height, 0);
    return std::move(tree_);
  }

 private:
  const Pyramid& p_;
  float extinction_;
  const Stops& stops_;
  const std::vector<std::vector<std::uint32_t>>& brick_of_;
  std::uint32_t zero_;
  Octree tree_;

  [[nodiscard]] int root_level() const { return int(p_.levels.size()) - 1; }

  [[nodiscard]] std::optional<std::size_t> index_of(int level, std::uint64_t code) const {
    if (level > root_level()) return std::nullopt;
    return find(p_.levels[std::size_t(level)], code);
  }

  [[nodiscard]] bool stops(int level, std::size_t i) const {
    return stops_[std::size_t(level)][i] != 0;
  }

  [[nodiscard]] bool uniform(int level, std::size_t i) const {
    return is_uniform(p_, std::size_t(level), i);
  }

  /// The node of height h whose cube has this code at level 2 h + 2.
  std::uint32_t add_node(int h, std::uint64_t code) {
    const auto id = std::uint32_t(tree_.nodes.size());
    tree_.nodes.push_back({0, 0, std::uint32_t(h)});
    std::array<Octree::Entry, 64> entry;
    std::uint64_t mask = 0;
    for (std::uint64_t group = 0; group < 8; ++group) {
      const auto g = index_of(2 * h + 1, code * 8 + group);
      if (g && stops(2 * h + 1, *g)) {
        add_group(h, *g, entry, mask);
        continue;
      }
      if (!g && 2 * h + 1 <= root_level()) continue;  // empty
      for (std::uint64_t k = 0; k < 8; ++k) {
        const std::uint64_t child = (code * 8 + group) * 8 + k;
        if (const auto i = index_of(2 * h, child)) put(entry, mask, child, make_entry(h, *i));
      }
    }
    Octree::Node& node = tree_.nodes[id];
    node.mask = mask;
    node.first = std::uint32_t(tree_.entries.size());
    for (std::uint64_t left = mask; left != 0; left &= left - 1) {
      tree_.entries.push_back(entry[std::size_t(std::countr_zero(left))]);
    }
    if (tree_.entries.size() >= Octree::kNodeBit) throw Error("too many nodes in the octree");
    return id;
  }

  /// A child whose code is known goes to its bit; entries without extinction are empty space.
  static void put(std::array<Octree::Entry, 64>& entry, std::uint64_t& mask, std::uint64_t child,
                  const Octree::Entry& e) {
    if (e.log2 != 0 && e.hi == 0) return;
    const Vec3i at(morton_decode(child & 63));
    const std::uint32_t bit = Octree::child_bit(lanes(at), 0);
    entry[bit] = e;
    mask |= 1ull << bit;
  }

  /// Entry of node i of level 2 h: a terminal or a node to descend into.
  Octree::Entry make_entry(int h, std::size_t i) {
    const int level = 2 * h;
    if (!stops(level, i)) return {0, 0, link(level, i), 0, 0};
    return bounds(level, i, link(level, i));
  }

  /// All eight children of node g of level 2 h + 1 as one terminal.
  void add_group(int h, std::size_t g, std::array<Octree::Entry, 64>& entry, std::uint64_t& mask) {
    const int level = 2 * h + 1;
    const std::uint64_t code = p_.levels[std::size_t(level)][g].code;
    for (std::uint64_t k = 0; k < 8; ++k) {
      LeafHandle child_link = zero_;
      if (uniform(level, g)) {
        child_link = brick_of_[std::size_t(level)][g];
      } else if (const auto i = index_of(level - 1, code * 8 + k)) {
        child_link = link(level - 1, *i);
      }
      Octree::Entry e = bounds(level, g, child_link);
      e.grouped = 1;
      put(entry, mask, code * 8 + k, e);
    }
  }

  [[nodiscard]] Octree::Entry bounds(int level, std::size_t i, LeafHandle handle) const {
    const PyramidNode& n = p_.levels[std::size_t(level)][i];
    return {extinction_ * n.lo, extinction_ * n.hi, handle, std::uint16_t(3 + level), 0};
  }

  /// What holds the samples below node i of an even level: its brick, or a tree node.
  LeafHandle link(int level, std::size_t i) {
    if (level == 0 || uniform(level, i)) return brick_of_[std::size_t(level)][i];
    return Octree::kNodeBit | add_node(level / 2 - 1, p_.levels[std::size_t(level)][i].code);
  }
};

}  // namespace

Octree build_octree(const Pyramid& pyramid, double extinction, double cell_length, const Cut& cut,
                    const std::vector<std::vector<std::uint32_t>>& brick_of,
                    std::uint32_t zero_brick) {
  const Stops stops = cut.depth ? stops_at_depth(pyramid, *cut.depth)
                                : stops_by_cost(pyramid, extinction, cell_length, cut.costs);
  return Layout(pyramid, float(extinction), stops, brick_of, zero_brick).run();
}

}  // namespace pvol
