// The occupied cells of a cloud: what a shell must contain, to the last cell.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/voxel_grid.h"

namespace pvol {

/// Occupied cells of a block of 8^3: bit 8 y + z of word x is cell (x, y, z) of the block.
using CellMask = std::array<std::uint64_t, 8>;

/// A cube of cells, some or all of them occupied.
struct SupportBlock {
  std::uint64_t code = 0;  ///< Morton code of its low corner, in blocks of 8^3 from the origin
  std::uint32_t level =
      0;                   ///< 0: 8^3 cells, of which a mask tells; L > 0: (8 << L)^3, all occupied
  std::uint32_t mask = 0;  ///< of a block of level 0: its index among the masks
};

/// A sparse set of cells. Cell (i, j, k) is the cube [i, i+1] x [j, j+1] x [k, k+1] of index space.
/// Blocks are disjoint and ascend by code; eight full cubes that make a larger one are merged, from
/// level 0 up; a block of level 0 has at least one cell.
struct Support {
  Vec3l origin;             ///< low corner of the cube that holds all blocks; a multiple of 8
  int root_log2 = 3;        ///< of that cube's edge in cells
  Vec3l lo, hi;             ///< tight box of the occupied cells: [lo, hi)
  std::uint64_t cells = 0;  ///< occupied ones
  std::vector<SupportBlock> blocks;
  std::vector<CellMask> masks;

  [[nodiscard]] bool empty() const { return blocks.empty(); }
};

/// The cells with a corner whose sample is above 0: outside them the trilinear interpolant is 0,
/// and so is the nearest one. For bounds of the tricubic one, the cells that read such a sample.
/// The pyramid is that of the grid. In parallel; the same for any number of threads.
[[nodiscard]] Support make_support(const VoxelGrid& grid, const Pyramid& pyramid);

/// From occupied cells in any order, with repetitions. Throws Error where they span more than 2^24
/// cells.
[[nodiscard]] Support make_support(const std::vector<Vec3l>& cells);

/// A block of 8^3 cells by its code, as in SupportBlock.
struct MaskedBlock {
  std::uint64_t code = 0;
  CellMask mask{};
};

/// From disjoint parts in any order: blocks of single cells, empty ones left out, and full cubes of
/// level 1 and more (their `mask` is ignored). root_log2 is 3 to kMaxRootLog2, and all codes lie in
/// the root.
[[nodiscard]] Support make_support(Vec3l origin, int root_log2, std::vector<MaskedBlock> parts,
                                   std::vector<SupportBlock> full = {});

[[nodiscard]] bool is_occupied(const Support& support, Vec3l cell);

/// A cube of cells that holds at least one occupied cell: a step of a descent through a support.
struct SupportNode {
  Vec3l lo;                        ///< its low corner, index space
  int log2 = 0;                    ///< of its edge in cells
  std::size_t begin = 0, end = 0;  ///< its blocks; for log2 < 3 the one that it is part of
  bool full = false;               ///< all its cells are occupied
};

[[nodiscard]] SupportNode root(const Support& support);

/// The occupied ones among the eight halves of a node with log2 > 0, in order of their codes.
struct SupportChildren {
  std::array<SupportNode, 8> node;
  int count = 0;
};
[[nodiscard]] SupportChildren children(const Support& support, const SupportNode& node);

}  // namespace pvol
