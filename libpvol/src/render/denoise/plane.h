// Pictures of one component, as filters walk over them.
#pragma once

#include <cstddef>
#include <vector>

namespace pvol::detail {

/// A picture of floats with a margin, in which the pixels at its edges are repeated: look-ups
/// beside the picture need no test.
class Plane {
 public:
  Plane() = default;
  Plane(int width, int height, int margin)
      : width_(width),
        height_(height),
        margin_(margin),
        stride_(width + 2 * margin),
        values_(std::size_t(stride_) * std::size_t(height + 2 * margin)) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// Pixel 0 of a row; rows and pixels reach into the margin on both sides.
  [[nodiscard]] const float* row(int y) const { return values_.data() + offset(y); }
  [[nodiscard]] float* row(int y) { return values_.data() + offset(y); }

  /// Fills the margin; to be called when the picture has been written.
  void repeat_edges();

 private:
  [[nodiscard]] std::ptrdiff_t offset(int y) const {
    return std::ptrdiff_t(y + margin_) * stride_ + margin_;
  }
  int width_ = 0, height_ = 0, margin_ = 0, stride_ = 0;
  std::vector<float> values_;
};

using Planes = std::vector<Plane>;

/// Means over squares of so many pixels to each side, as far as they lie in the picture, weighted.
/// `weight` is not negative; where a square has none, the mean is 0. The margin is filled.
[[nodiscard]] Plane box_mean(const Plane& plane, const Plane& weight, int radius);

}  // namespace pvol::detail
