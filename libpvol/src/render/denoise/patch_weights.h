// How alike the surroundings of two pixels are, noise considered: weights of non-local means.
// Based on: Rousselle et al. Adaptive Rendering with Non-Local Means Filtering. 2012.
#pragma once

#include "render/denoise/plane.h"

namespace pvol::detail {

/// Pictures are filtered in squares of this edge, whose order and number bear on no byte.
inline constexpr int kTile = 32;

struct Tile {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The tile of this number among those of a picture.
[[nodiscard]] Tile tile_of(std::size_t number, int width, int height);
[[nodiscard]] std::size_t tiles_in(int width, int height);

/// What patches are compared by: planes, and the variances of their noise.
struct Guide {
  Planes values, variances;
};

struct PatchOptions {
  int window = 0, patch = 0;
  float bandwidth = 1;
};

/// Margin that a guide's planes need.
[[nodiscard]] constexpr int margin_of(const PatchOptions& o) { return o.window + o.patch; }

/// Offsets in a window.
[[nodiscard]] constexpr int offsets_of(int window) { return (2 * window + 1) * (2 * window + 1); }

/// The weights of the pixels at all offsets from those of a tile, in the same picture or in another
/// of the same size.
class PatchWeights {
 public:
  /// `there` has the other pixels. `known` is 0 for those that count for nothing; null: none do.
  PatchWeights(const Guide& here, const Guide& there, const Plane* known, const Tile& tile,
               const PatchOptions& options);

  /// kTile numbers in [0, 1] for a row of the tile and the offset (dx, dy) within the window; 0
  /// where the other pixel lies outside the picture or is unknown, and beyond the tile's width.
  [[nodiscard]] const float* row(int dx, int dy, int y) const {
    const int offset = (dy + window_) * (2 * window_ + 1) + dx + window_;
    return weights_.data() + (std::size_t(offset) * kTile + std::size_t(y)) * kTile;
  }

 private:
  int window_;
  std::vector<float> weights_;
};

}  // namespace pvol::detail
