// Choosing where the walk stops, and laying the tree out for it.
#include "pvol/bounds/octree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

using Stops = std::vector<std::vector<char>>;  // by level and node: whether the walk stops there

/// How deep a walk may go in a pyramid.
struct Limit {
  std::size_t level = 0;  ///< walks stop here, if not above
  int parts = 2;          ///< levels below the leaves: 0, 1 (eights of them) or 2

  Limit(const Pyramid& p, std::optional<int> depth) {
    if (!depth) return;
    const int below_leaves = *depth - (int(p.levels.size()) - 1);
    level = std::size_t(std::max(0, -below_leaves));
    parts = std::clamp(below_leaves, 0, 2);
  }
};

Stops stops_at(const Pyramid& p, const Limit& limit) {
  Stops stops(p.levels.size());
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const auto& nodes = p.levels[level];
    auto& stop = stops[level];
    stop.assign(nodes.size(), char(level <= limit.level));
    for (std::size_t i = 0; level > limit.level && i < nodes.size(); ++i) {
      stop[i] = char(is_uniform(p, level, i));
    }
  }
  return stops;
}

/// Of the rays that cross a cube, those that cross one of its eight parts: its surface over theirs.
constexpr double kChildShare = 0.25;

/// What it costs to cross cubes of 2^log2 cells (THEORY.md, T2.1).
class CrossingCost {
 public:
  CrossingCost(double extinction, double cell_length, const WalkCosts& costs)
      : extinction_(float(extinction)), depth_(extinction * cell_length), costs_(costs) {}

  /// With these bounds, along the mean chord, 2/3 of the edge.
  [[nodiscard]] double stop(int log2, float lo, float hi) const {
    const double chord = 2.0 / 3.0 * std::ldexp(depth_, log2), gap = double(hi) - double(lo);
    return (log2 < 3 ? costs_.part : costs_.segment) +
           chord * (double(hi) * costs_.tentative + gap * costs_.lookup);
  }
  [[nodiscard]] double skip() const { return costs_.skip; }
  /// Whether walks meet a cube with this bound.
  [[nodiscard]] bool is_met(float hi) const { return extinction_ * hi > 0; }
  /// The least that the parts of a leaf may cost.
  [[nodiscard]] double least_of_parts(float lo) const {
    return stop(3, lo, lo) - costs_.segment + 2 * std::min(costs_.skip, costs_.part);
  }

 private:
  float extinction_;
  double depth_;
  const WalkCosts& costs_;
};

/// The parts of a leaf as walks meet them: by eights where that costs less.
struct LeafParts {
  PartBounds bounds;          ///< within those of the leaf; of eights all the same
  std::uint64_t grouped = 0;  ///< bit (i * 4 + j) * 4 + k: part (i, j, k) goes with its siblings
  double cost = 0;
  bool is_met = false;  ///< by walks, any of them
};

LeafParts choose_parts(const PyramidNode& leaf, PartBounds bounds, const CrossingCost& cost,
                       const Limit& limit) {
  LeafParts r{bounds};
  for (std::size_t group = 0; group < 8; ++group) {
    const std::size_t first = (group >> 2) * 32 + (group >> 1 & 1) * 8 + (group & 1) * 2;
    const auto part = [&](std::size_t k) {
      return first + (k >> 2) * 16 + (k >> 1 & 1) * 4 + (k & 1);
    };
    float lo = leaf.hi, hi = 0;
    double apart = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      float &l = r.bounds.lo[part(k)], &h = r.bounds.hi[part(k)];
      l = std::max(l, leaf.lo), h = std::min(h, leaf.hi);
      apart += kChildShare * (cost.is_met(h) ? cost.stop(1, l, h) : cost.skip());
      lo = std::min(lo, l), hi = std::max(hi, h);
    }
    r.is_met = r.is_met || cost.is_met(hi);
    const double together = cost.is_met(hi) ? cost.stop(2, lo, hi) : cost.skip();
    const bool divided = limit.parts == 2 && apart < together;
    r.cost += kChildShare * (divided ? apart : together);
    if (divided) continue;
    for (std::size_t k = 0; k < 8; ++k) {
      r.bounds.lo[part(k)] = lo, r.bounds.hi[part(k)] = hi;
      r.grouped |= std::uint64_t(cost.is_met(hi)) << part(k);
    }
  }
  return r;
}

/// The cheapest cut within the limit, bottom up (THEORY.md, T2.1). The cost of a node is that of a
/// ray that crosses it: along a mean chord if the walk stops, else each child's cost times the
/// share of crossing rays that cross the child. Walks that do not stop at a leaf go on into its
/// parts. A limit where the cheapest cut of all is deepest leaves that as it is: what walks do not
/// meet only gets dearer.
Stops stops_by_cost(const Pyramid& p, const CrossingCost& cost, const Limit& limit,
                    const std::vector<std::vector<std::uint32_t>>& brick_of,
                    const BoundParts& parts) {
  Stops stops(p.levels.size());
  std::vector<double> below, here;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const auto& nodes = p.levels[level];
    stops[level].resize(nodes.size());
    here.resize(nodes.size());
    parallel_parts(0, nodes.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        const PyramidNode& n = nodes[i];
        const double stop = cost.stop(3 + int(level), n.lo, n.hi);
        const NodeRange c = children(p, level, i);
        double descend = double(8 - (c.end - c.begin)) * kChildShare * cost.skip();
        for (std::size_t k = c.begin; k < c.end; ++k) descend += kChildShare * below[k];
        bool stops_here = level <= limit.level || c.empty() || stop <= descend;
        if (level == 0 && parts && cost.least_of_parts(n.lo) < stop) {
          const LeafParts chosen = choose_parts(n, parts(brick_of[0][i]), cost, limit);
          descend = chosen.cost;
          stops_here = stop <= descend || !chosen.is_met;
        }
        stops[level][i] = char(stops_here);
        here[i] = stops_here ? stop : descend;
      }
    });
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
         const std::vector<std::vector<std::uint32_t>>& brick_of, std::uint32_t zero_brick,
         const BoundParts& parts, const CrossingCost& cost, const Limit& limit)
      : p_(p),
        extinction_(extinction),
        stops_(stops),
        brick_of_(brick_of),
        zero_(zero_brick),
        parts_(parts),
        cost_(cost),
        limit_(limit) {}

  Octree run() {
    tree_.origin = p_.origin;
    tree_.support_lo = widen(Vec3i(p_.support_lo - p_.origin));
    tree_.support_hi = widen(Vec3i(p_.support_hi - p_.origin));
    if (p_.empty()) return std::move(tree_);
    count_terminals(p_, stops_, tree_);
    tree_.height = root_level() / 2 + 1;
    add_node(root_level() / 2, 0);
    return std::move(tree_);
  }

 private:
  const Pyramid& p_;
  float extinction_;
  const Stops& stops_;
  const std::vector<std::vector<std::uint32_t>>& brick_of_;
  std::uint32_t zero_;
  const BoundParts& parts_;
  const CrossingCost& cost_;
  const Limit& limit_;
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

  /// The node of height h + 1 whose cube has this code at level 2 h + 2.
  std::uint32_t add_node(int h, std::uint64_t code) {
    const auto id = std::uint32_t(tree_.nodes.size());
    tree_.nodes.push_back({0, 0, std::uint32_t(h + 1)});
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
    set_entries(id, entry, mask);
    return id;
  }

  /// The node of the parts of leaf i.
  std::uint32_t add_parts(std::size_t i) {
    const auto id = std::uint32_t(tree_.nodes.size());
    tree_.nodes.push_back({0, 0, 0});
    const std::uint32_t brick = brick_of_[0][i];
    const LeafParts parts = choose_parts(p_.levels[0][i], parts_(brick), cost_, limit_);
    std::array<Octree::Entry, 64> entry;
    std::uint64_t mask = 0;
    for (std::size_t k = 0; k < 64; ++k) {
      const auto grouped = std::uint16_t(parts.grouped >> k & 1);
      const float hi = extinction_ * parts.bounds.hi[k];
      entry[k] = {extinction_ * parts.bounds.lo[k], hi, brick, std::uint16_t(1 + grouped), grouped};
      mask |= std::uint64_t(hi > 0) << k;
    }
    tree_.terminals += std::uint64_t(std::popcount(mask & ~parts.grouped)) +
                       std::uint64_t(std::popcount(mask & parts.grouped)) / 8;
    const int deepest = (mask & ~parts.grouped) != 0 ? 2 : 1;
    tree_.depth = std::max(tree_.depth, root_level() + deepest);
    set_entries(id, entry, mask);
    return id;
  }

  void set_entries(std::uint32_t id, const std::array<Octree::Entry, 64>& entry,
                   std::uint64_t mask) {
    Octree::Node& node = tree_.nodes[id];
    node.mask = mask;
    node.first = std::uint32_t(tree_.entries.size());
    for (std::uint64_t left = mask; left != 0; left &= left - 1) {
      tree_.entries.push_back(entry[std::size_t(std::countr_zero(left))]);
    }
    if (tree_.entries.size() >= Octree::kNodeBit)
      throw Error("the octree has too many nodes; resample the volume to larger voxels");
  }

  /// A child whose code is known goes to its bit; entries without extinction are empty space.
  static void put(std::array<Octree::Entry, 64>& entry, std::uint64_t& mask, std::uint64_t child,
                  const Octree::Entry& e) {
    if (e.log2 != 0 && e.hi == 0) return;
    const Vec3i at(morton_decode(child & 63));
    const std::uint32_t bit = Octree::child_bit(widen(at), 0);
    entry[bit] = e;
    mask |= 1ull << bit;
  }

  /// Entry of node i of level 2 h: a terminal or a node to descend into.
  Octree::Entry make_entry(int h, std::size_t i) {
    const int level = 2 * h;
    if (!stops(level, i)) {
      const LeafHandle below = level == 0 ? Octree::kNodeBit | add_parts(i) : link(level, i);
      return {0, 0, below, 0, 0};
    }
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
                    std::uint32_t zero_brick, const BoundParts& bound_parts) {
  const CrossingCost cost(extinction, cell_length, cut.costs);
  // Parts of more leaves than these, of a kilobyte each, leave the caches, and steps cost more than
  // they save.
  constexpr std::size_t kMostLeaves = 4096;
  const bool few = !pyramid.empty() && pyramid.levels[0].size() <= kMostLeaves;
  const Limit limit(pyramid, cut.depth);
  const BoundParts parts = few && limit.parts > 0 ? bound_parts : BoundParts{};
  const Stops stops = cut.everywhere ? stops_at(pyramid, limit)
                                     : stops_by_cost(pyramid, cost, limit, brick_of, parts);
  return Layout(pyramid, float(extinction), stops, brick_of, zero_brick, parts, cost, limit).run();
}

}  // namespace pvol
