// The bounds of one cloud as the walk reads them: a tree of 4^3 nodes with its cut chosen.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "pvol/math/box.h"
#include "pvol/math/float4.h"

namespace pvol {

struct Pyramid;  // pyramid.h

/// A position in the lattice: an integer cell, counted from the octree's origin, and an offset in
/// [0, 1]^3 within it. Near any voxel its resolution is that of a float in [0, 1], however large
/// the cloud.
struct LatticePoint {
  Int4 cell{};
  Float4 frac{};
};

/// In cells from the octree's origin.
[[nodiscard]] inline Vec3d position(const LatticePoint& p) {
  return Vec3d(vec3(p.cell)) + Vec3d(vec3(p.frac));
}

/// Where the samples under a segment are: a brick, or a node of the octree to search from.
/// Opaque to trackers; fields and `Octree::brick_at` understand it.
using LeafHandle = std::uint32_t;

/// Wide octree: every node splits its cube into 4^3 children; the children of nodes of height h are
/// cubes of 2 << 2h cells: leaves where h is 1, and where it is 0 parts of a leaf, which share its
/// brick. A child is empty (its bit is clear), a terminal, where the walk stops
/// with bounds, or is descended into. Terminals may lie above the leaves: the cut. The tree below
/// them is kept, so that look-ups find their brick.
struct Octree {
  static constexpr int kMaxHeight = 12;
  static constexpr LeafHandle kNodeBit = 0x80000000u;  ///< marks a handle that names a node

  struct Node {
    std::uint64_t mask = 0;   ///< bit 16 x + 4 y + z: child (x, y, z) is not empty
    std::uint32_t first = 0;  ///< entry of the lowest set bit; the others follow in order
    std::uint32_t height = 0;
  };

  struct Entry {
    float lo = 0, hi = 0;    ///< bounds on mu_t over the terminal's cube [1/world length]
    LeafHandle link = 0;     ///< kNodeBit | child node, or a brick
    std::uint16_t log2 = 0;  ///< of the terminal's edge in cells; 0: descend
    std::uint16_t grouped =
        0;  ///< the terminal is a 2^3 group of children: this one and its siblings
  };

  Vec3l origin;                     ///< index-space cell at the low corner
  Int4 support_lo{}, support_hi{};  ///< tight box of the density, in cells from `origin`
  int height = 0;                   ///< of the root node; nodes[0] is the root
  int depth = 0;                ///< deepest octree level at which the walk stops (0: one terminal)
  std::uint64_t terminals = 0;  ///< at which a walk stops
  std::vector<Node> nodes;
  std::vector<Entry> entries;

  [[nodiscard]] bool empty() const { return nodes.empty(); }
  [[nodiscard]] std::size_t bytes() const {
    return nodes.size() * sizeof(Node) + entries.size() * sizeof(Entry);
  }
  [[nodiscard]] Box support() const { return {Vec3d(vec3(support_lo)), Vec3d(vec3(support_hi))}; }

  /// log2 of the edge in cells of the children of nodes of this height.
  [[nodiscard]] static constexpr int child_log2(int height) { return 1 + 2 * height; }

  [[nodiscard]] static std::uint32_t child_bit(Int4 cell, int shift) {
    const Int4 c = cell >> shift & 3;
    return std::uint32_t(c[0] << 4 | c[1] << 2 | c[2]);
  }

  [[nodiscard]] const Entry* child(const Node& node, std::uint32_t bit) const {
    if (!(node.mask >> bit & 1)) return nullptr;
    return &entries[node.first + std::uint32_t(std::popcount(node.mask & ((1ull << bit) - 1)))];
  }

  /// The brick that holds the samples of a cell, found from the handle of its segment. `zero_brick`
  /// stands for cells in empty children.
  [[nodiscard]] std::uint32_t brick_at(LeafHandle leaf, Int4 cell, std::uint32_t zero_brick) const {
    while (leaf & kNodeBit) {
      const Node& node = nodes[leaf & ~kNodeBit];
      const Entry* e = child(node, child_bit(cell, child_log2(int(node.height))));
      if (e == nullptr) return zero_brick;
      leaf = e->link;
    }
    return leaf;
  }
};

/// What one step of the walk, one tentative collision and one look-up cost, in any common unit: the
/// terms of the model that chooses where a walk stops (THEORY.md, T2.1). The defaults are
/// nanoseconds, solved from whole renders of one cloud at several depths and extinctions.
struct WalkCosts {
  double segment = 45;    ///< entering a terminal
  double part = 25;       ///< the same where it is a part of a leaf
  double skip = 15;       ///< crossing an empty cube
  double tentative = 20;  ///< distance, random numbers and bounds test
  double lookup = 20;     ///< finding and interpolating the density
};

/// Level of the parts of leaves in the largest cloud (kMaxRootLog2): no octree is deeper.
inline constexpr int kDeepestOctree = 23;

/// Which terminals the walk stops at: those of least cost down to a depth. With the depth that the
/// tree without a limit has (Octree::depth), they are the same as without.
struct Cut {
  /// Deepest octree level at which walks stop, 0 (root) to kDeepestOctree; the parts of leaves are
  /// the two levels below them. Without: no limit.
  std::optional<int> depth{};
  WalkCosts costs{};
  /// Walks go on to the depth, or to leaves above it, whatever that costs: not below leaves, and
  /// not into cubes of one density.
  bool everywhere = false;
};

/// Bounds of what look-ups compute in the parts of a leaf, of 2^3 cells each, part (i, j, k) at
/// (i * 4 + j) * 4 + k.
struct PartBounds {
  std::array<float, 64> lo, hi;
};
/// Those of the leaf with this brick; called from any thread.
using BoundParts = std::function<PartBounds(std::uint32_t brick)>;

/// Bounds in a pyramid times `extinction`, with links to bricks by `brick_of`: brick_of(level, i)
/// is the brick of node i of level `level`, asked for leaves and uniform cubes. `cell_length` is
/// the world length of a cell's edge (the geometric mean for skewed ones), for the cost model. With
/// `parts`, the walk of a cloud of at most 4096 leaves goes on into them where that costs less.
[[nodiscard]] Octree build_octree(const Pyramid& pyramid, double extinction, double cell_length,
                                  const Cut& cut,
                                  const std::vector<std::vector<std::uint32_t>>& brick_of,
                                  std::uint32_t zero_brick, const BoundParts& parts = {});

}  // namespace pvol
