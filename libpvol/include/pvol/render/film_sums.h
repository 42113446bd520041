// The sums of a film that know no order: samples in any order, and parts of a film in any grouping,
// give the same bits (THEORY.md, T5.20).
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/math/reproducible_sum.h"

namespace pvol {

/// Samples of a pixel whose sums are kept in less space than their digits take.
inline constexpr std::uint32_t kMostPacked = Sum1::kMostPacked;

/// Over the samples of a pixel, as they are added up.
struct ExactSums {
  struct OfLayer {
    Sum3 sum;
    Sum1 weight;
    friend bool operator==(const OfLayer&, const OfLayer&) = default;
  };

  Sum3 light, squares;  ///< of radiance, and of its square by channel
  Sum1 alpha;           ///< of 1 - transmittance
  Sum1 group;           ///< of luminance, over one group of them (PixelSums::group)
  /// As in Film::layers. All 0 for a layer of least values, which know no order anyway; the weights
  /// are 0 for a layer without weights.
  std::vector<OfLayer> layers{};

  /// Adds those of the same layers.
  void merge(const ExactSums& other);
  friend bool operator==(const ExactSums&, const ExactSums&) = default;
};

/// What a pixel's exact sums have beside its PixelSums, which are rounded from them. Of up to
/// kMostPacked samples.
struct PixelRemainders {
  Sum3::Remainder light, squares;
  Sum1::Remainder alpha, group;
  friend bool operator==(const PixelRemainders&, const PixelRemainders&) = default;
};

/// Likewise of a layer's pixels; both empty where the layer has least values.
struct LayerRemainders {
  std::vector<Sum3::Remainder> sums{};
  std::vector<Sum1::Remainder> weights{};
  friend bool operator==(const LayerRemainders&, const LayerRemainders&) = default;
};

/// What the exact sums of a film have beside its own; empty in films that nobody rendered.
struct FilmRemainders {
  std::vector<PixelRemainders> pixels{};
  std::vector<LayerRemainders> layers{};
  /// Instead of both, where a pixel has or soon has more samples: all sums of each pixel.
  std::vector<ExactSums> whole{};

  [[nodiscard]] bool empty() const { return pixels.empty() && whole.empty(); }
  friend bool operator==(const FilmRemainders&, const FilmRemainders&) = default;
};

}  // namespace pvol
