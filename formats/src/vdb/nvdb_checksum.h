// Checksums that .nvdb files carry: one of a grid's head, and in some files one of its nodes.
#pragma once

#include <array>

#include "vdb/nvdb_file.h"

namespace pvol::formats::detail {

/// Where a node lies in its grid.
struct NvdbNode {
  std::uint64_t offset = 0, size = 0;
  std::uint64_t fixed_size = 0;  ///< without the values of leaves whose size differs
};

/// The nodes of a tree by levels, in any order: upper, lower, leaves.
using NvdbLevels = std::array<std::vector<NvdbNode>, 3>;

/// Throws Error where the checksum of the head, of grid and tree, differs from what the file says;
/// `root_end` is where the root ends. Files without checksums pass.
void check_head(const NvdbMemory& memory, std::uint64_t root_end);

/// The same of the nodes.
void check_nodes(const NvdbMemory& memory, const NvdbLevels& levels);

}  // namespace pvol::formats::detail
