// How far a filtered picture is off, from its two halves (THEORY.md, T5.10).
#pragma once

#include <array>

#include "render/denoise/denoise_inputs.h"

namespace pvol::detail {

/// Errors of one channel: of the mean of both filtered halves.
struct Errors {
  Plane variance, mse;  ///< smoothed
  double mean_mse = 0;   ///< over the pixels that were filtered
  double deviation = 0;  ///< standard deviation of that estimate, were noise normal
};

/// Of channel c, by the filtered planes of either half.
[[nodiscard]] Errors find_errors(const Halves& halves, const std::array<Planes, 2>& filtered,
                                 std::size_t c);

}  // namespace pvol::detail
