// Colour as a linear function of features around each pixel, fitted to one half of the samples.
// Based on: Bitterli et al. Nonlinearly Weighted First-order Regression for Denoising Monte Carlo
// Renderings. 2016.
#pragma once

#include <array>

#include "render/film/denoise/patch_weights.h"

namespace pvol::detail {

/// Features beside the constant: place in the picture (2), alpha, depth, normal (3), albedo (3).
inline constexpr std::size_t kMostFeatures = 10;

/// What is fitted: a colour of three planes by features of about the same scale, with weights of
/// the guide, whose noise is not the colour's.
struct RegressionInput {
  const Guide& guide;
  const Planes& colour;
  const Planes& features;
  PatchOptions options;
};

/// What the fits around a tile's pixels say of all pixels in their windows: those of the tile and
/// around it. Sums of weights, and of colours times weights.
struct Predictions {
  static constexpr std::size_t kColours = 3;
  int edge = 0;                                       ///< pixels in a row of these
  std::array<std::vector<float>, kColours + 1> sums;  ///< the last one is that of weights
};

/// Fits a plane for each pixel of the tile, and predicts its window by it.
[[nodiscard]] Predictions regress(const RegressionInput& in, const Tile& tile);

}  // namespace pvol::detail
