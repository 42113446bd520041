// Bricks of a density of which some samples changed: the rest stays.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "capi/samples.h"
#include "pvol/field/micro_range.h"
#include "volume/linked_bricks.h"

namespace pvol::detail {

/// A density in bricks with its bounds.
struct BoundedBricks {
  Pyramid pyramid;
  LinkedBricks bricks;
  std::vector<DensityRange> ranges{};    ///< of the samples of each brick, where updates need them
  std::vector<std::uint32_t> spare{};    ///< bricks that no leaf has
  std::vector<std::uint32_t> changed{};  ///< those that the last update wrote
};

/// Whether bricks can be updated: trilinear ones that are not shared, without cubes of one value
/// above leaves.
[[nodiscard]] bool can_update(const BoundedBricks& before);

/// Samples of the lattice points lo <= p < hi, whatever lies elsewhere.
using ReadBox = std::function<VoxelGrid(const LatticeBox&)>;

/// The density whose samples in `boxes` are those that `read` returns, and else those of before; as
/// if it were bounded anew, but for which brick a leaf has. Writes into spare and new bricks of the
/// same field where there is room for them, so that what was before stays as it was and nobody may
/// update it again. The work is that of the leaves that change, and a few steps for each other one.
[[nodiscard]] BoundedBricks update_bricks(const BoundedBricks& before,
                                          std::span<const LatticeBox> boxes, const ReadBox& read);

}  // namespace pvol::detail
