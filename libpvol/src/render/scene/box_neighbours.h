// Which of many boxes meet which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pvol/math/box.h"

namespace pvol::detail {

/// Of each of some boxes, the others that it meets, at most kMost: by a sweep along the axis on
/// which they are spread farthest, of limited time and memory however many of them lie in one
/// place.
class BoxNeighbours {
 public:
  static constexpr std::size_t kMost = 64;

  explicit BoxNeighbours(std::span<const Box> boxes);

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t box) const { return of_[box]; }
  /// Whether a box has more than kMost, or not all of them are known.
  [[nodiscard]] bool crowded(std::size_t box) const { return crowded_[box] != 0; }

 private:
  std::vector<std::vector<std::uint32_t>> of_;
  std::vector<std::uint8_t> crowded_;

  void add(std::uint32_t box, std::uint32_t other);
};

}  // namespace pvol::detail
