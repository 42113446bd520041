// Finds many nodes of a large level by their codes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pvol/bounds/pyramid.h"

namespace pvol {

/// Where about as many equal parts of a level's codes begin as it has nodes: a search in a part
/// takes a step or two, one among millions of nodes twenty. Keeps a reference to the level.
class NodeIndex {
 public:
  explicit NodeIndex(std::span<const PyramidNode> level);
  /// Of the leaves.
  explicit NodeIndex(const Pyramid& pyramid);

  /// Index of the node with this code in the level, if present.
  [[nodiscard]] std::optional<std::size_t> find(std::uint64_t code) const;

 private:
  std::span<const PyramidNode> level_;
  int shift_ = 0;                     // of codes to the numbers of their parts
  std::vector<std::uint32_t> begin_;  // of each part, and the end of the last
};

}  // namespace pvol
