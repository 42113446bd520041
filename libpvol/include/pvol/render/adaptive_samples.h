// Adaptive samples: what a pilot of each pixel shows about its neighbours (THEORY.md, T5.8).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace pvol {

/// Samples that every pixel gets before those that need more get more: forty pixels' together show
/// a variance to some 10 %, where it is not a matter of rare events.
inline constexpr std::uint32_t kPilot = 16;

/// What the pixels of a film need. Each pixel's figures follow from samples of pixels of the other
/// colour of a checkerboard alone, so that its mean stays unbiased.
struct AdaptiveSamples {
  /// Of each pixel: its samples, in proportion; 1 on average over the pixels of either colour.
  std::vector<float> share;
  /// Samples of a pixel of either colour, on average, for a picture of the wanted noise.
  std::array<double, 2> samples{};
};

}  // namespace pvol
