// Where the samples of any cell are, without a search: for look-ups at points that no walk leads
// to.
#pragma once

#include <cstdint>
#include <memory>

#include "pvol/bounds/octree.h"
#include "pvol/math/pages.h"

namespace pvol {

/// The brick of each leaf of 8^3 cells in the box of an octree's support: what the octree's own
/// search from the root would find, by one read at a computed place.
struct LeafIndex {
  std::int64_t row = 0, slab = 0;  ///< leaves along z, and in a plane of y and z
  std::int64_t first = 0;          ///< x * slab + y * row + z of the first leaf
  /// Of leaf (x, y, z) at x * slab + y * row + z - first; 0, the brick of zeros, where there is
  /// nothing.
  PagedVector<std::uint32_t> brick;

  /// That of a cell of the support, in cells from the octree's origin.
  [[nodiscard]] std::uint32_t brick_at(Int4 cell) const {
    const std::int64_t x = cell[0] >> 3, y = cell[1] >> 3, z = cell[2] >> 3;
    return brick[std::size_t(x * slab + y * row + z - first)];
  }
  [[nodiscard]] std::size_t bytes() const { return brick.size() * sizeof(std::uint32_t); }
};

/// The index of a tree's leaves; null where it would take more bytes than these, and for an empty
/// tree.
[[nodiscard]] std::shared_ptr<const LeafIndex> index_leaves(const Octree& tree,
                                                            std::uint64_t most_bytes);

}  // namespace pvol
