// The sums of a film that know no order: samples in any order, and parts of a film in any grouping,
// give the same bits (THEORY.md, T5.20).
#pragma once

#include <cstddef>
#include <vector>

#include "pvol/math/reproducible_sum.h"

namespace pvol {

/// Over the samples of a pixel.
struct ExactPixel {
  Sum3 light, squares;  ///< of radiance, and of its square by channel
  Sum1 alpha;           ///< of 1 - transmittance
  friend bool operator==(const ExactPixel&, const ExactPixel&) = default;
};

/// Of a layer's pixels, as in Layer; both empty where the layer has least values, which know no
/// order anyway.
struct ExactLayer {
  std::vector<Sum3> sums{};
  std::vector<Sum1> weights{};
  friend bool operator==(const ExactLayer&, const ExactLayer&) = default;
};

/// Those of a film; empty in films that nobody rendered.
struct FilmSums {
  std::vector<ExactPixel> pixels{};
  std::vector<ExactLayer> layers{};

  [[nodiscard]] bool empty() const { return pixels.empty(); }
  friend bool operator==(const FilmSums&, const FilmSums&) = default;
};

}  // namespace pvol
