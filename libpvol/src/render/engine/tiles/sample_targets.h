// How many samples the pixels of a film are to have.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pvol::detail {

/// Samples that pixels are to have after a pass, those that they have included.
struct SampleTargets {
  std::uint32_t all = 0;                 ///< every pixel, where `each` is empty
  std::vector<std::uint32_t> each = {};  ///< by number in the film

  [[nodiscard]] std::uint32_t of(std::size_t pixel) const {
    return each.empty() ? all : each[pixel];
  }
  [[nodiscard]] std::uint32_t most() const {
    return each.empty() ? all : *std::ranges::max_element(each);
  }
};

}  // namespace pvol::detail
