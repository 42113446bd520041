// Places of samples around the middle of a pixel, as its filter weighs them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "pvol/render/options.h"

namespace pvol::detail {

/// Along one axis, for all filters here are products of one for each. Samples are taken in
/// proportion to the filter and all count alike, so that pixels share none and films add up. Based
/// on: Ernst, Stamminger, Greiner. Filter importance sampling. 2006.
class FilterOffsets {
 public:
  static constexpr std::size_t kSteps = 4096;

  FilterOffsets(PixelFilter filter, std::optional<double> width);

  /// In pixels, of u uniform in [0, 1).
  [[nodiscard]] float operator()(float u) const {
    if (is_box_) return (u - 0.5f) * width_;
    const float x = u * float(kSteps);
    const auto i = std::size_t(x);
    return at_[i] + (at_[i + 1] - at_[i]) * (x - float(i));
  }

 private:
  bool is_box_;
  float width_;
  std::array<float, kSteps + 1> at_{};  ///< below which i / kSteps of the filter lies
};

}  // namespace pvol::detail
