// Colour as a linear function of features around each pixel, fitted to one half of the samples.
// Based on: Bitterli et al. Nonlinearly Weighted First-order Regression for Denoising Monte Carlo
// Renderings. 2016 (THEORY.md, T5.10).
#pragma once

#include "render/denoise/patch_weights.h"

namespace pvol::detail {

/// Features beside the constant: place in the picture (2), alpha, depth, normal (3), albedo (3).
inline constexpr std::size_t kMostFeatures = 10;

/// Planes of one frame, as the pixels of the frame that is filtered see them.
struct FrameInput {
  const Guide* guide = nullptr;  ///< for the weights
  std::vector<const Plane*> colours;
  const Planes* features = nullptr;
  const Plane* known = nullptr;  ///< 0 for pixels that count for nothing; null: none do
};

/// What is fitted: planes of colours, by features of about the same scale, with weights of the
/// guides, whose noise is not theirs.
struct RegressionInput {
  FrameInput own;
  std::vector<FrameInput> others;  ///< of frames before and after: further pixels of each window
  PatchOptions options;
};

/// What a pixel's window has of one plane, of the pixels that have a weight.
struct WindowValues {
  float mean = 0, least = 0, most = 0;  ///< the mean is weighted
};

/// What the fits around a tile's pixels say of all pixels in their windows: those of the tile and
/// around it.
struct Predictions {
  int edge = 0;                                    ///< pixels in a row of these
  std::vector<std::vector<float>> sums;            ///< of the planes of colours, times weights
  std::vector<float> weights;                      ///< their sums
  std::vector<std::vector<WindowValues>> windows;  ///< of the tile's pixels, in rows of kTile
};

/// Fits a plane to each colour for each pixel of the tile, with what its window has in all frames,
/// and predicts the window of its own frame by it.
[[nodiscard]] Predictions regress(const RegressionInput& in, const Tile& tile);

}  // namespace pvol::detail
