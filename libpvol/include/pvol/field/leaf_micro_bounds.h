// Micro-bounds by leaf of a pyramid, as files keep them: a field's bricks are an affair of memory.
#pragma once

#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"
#include "pvol/field/micro_bounds.h"

namespace pvol {

/// `scales` and `codes` of these have a leaf of the pyramid, in its order, where those of a field
/// have a brick. A leaf of one density has the scale {density, 0}.
struct LeafMicroBounds {
  MicroBounds by_leaf;
  friend bool operator==(const LeafMicroBounds&, const LeafMicroBounds&) = default;
};

/// Micro-bounds of cubes of edge^3 cells, edge 1 or 2, for every leaf.
[[nodiscard]] LeafMicroBounds build_leaf_micro_bounds(const VoxelGrid& grid, const Pyramid& pyramid,
                                                      int edge);

/// The same in the order of a field's bricks, where brick_of[0] is that of `build_field`, proven to
/// hold for the field. Throws Error, naming the leaf, where they do not, or are wrong in number.
[[nodiscard]] MicroBounds arrange(const LeafMicroBounds& bounds, const BrickField& field,
                                  const std::vector<std::vector<std::uint32_t>>& brick_of,
                                  const Pyramid& pyramid);

}  // namespace pvol
