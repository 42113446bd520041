// Which pictures can be gone on with, and merged.
#pragma once

#include "pvol/math/names.h"

namespace pvol::cli {

/// Whether an .exr keeps exact sums, to go on with and to merge.
enum class KeepSums {
  automatic,  ///< where it is not the whole picture that the scene says
  on,
  off,
};
[[nodiscard]] constexpr auto names(KeepSums) {
  return std::to_array<Named<KeepSums>>(
      {{KeepSums::automatic, "auto"}, {KeepSums::on, "on"}, {KeepSums::off, "off"}});
}

}  // namespace pvol::cli
