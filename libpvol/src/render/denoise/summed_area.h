// Sums over rectangles, and rectangles added up, each in a time that does not depend on their size.
// Based on: Crow. Summed-area Tables for Texture Mapping. 1984.
#pragma once

#include <cstddef>
#include <vector>

#include "render/denoise/plane.h"

namespace pvol::detail {

/// The pixels of [x0, x1) x [y0, y1).
struct Rectangle {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// A number for each corner of a picture's pixels.
class Corners {
 public:
  Corners(int width, int height)
      : width_(width + 1), values_(std::size_t(width + 1) * std::size_t(height + 1)) {}
  [[nodiscard]] double& at(int x, int y) { return values_[index(x, y)]; }
  [[nodiscard]] double at(int x, int y) const { return values_[index(x, y)]; }

  /// Each becomes the sum of all that are neither right of it nor below.
  void accumulate() {
    const int height = int(values_.size()) / width_;
    for (int y = 0; y < height; ++y) {
      double row = 0;
      for (int x = 0; x < width_; ++x) {
        row += at(x, y);
        at(x, y) = y > 0 ? at(x, y - 1) + row : row;
      }
    }
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(width_) + std::size_t(x);
  }
  int width_;
  std::vector<double> values_;
};

/// Sums of a plane over rectangles.
class RectangleSums {
 public:
  explicit RectangleSums(const Plane& p) : corners_(p.width(), p.height()) {
    for (int y = 0; y < p.height(); ++y) {
      for (int x = 0; x < p.width(); ++x) corners_.at(x + 1, y + 1) = double(p.row(y)[x]);
    }
    corners_.accumulate();
  }
  [[nodiscard]] double over(const Rectangle& r) const {
    return corners_.at(r.x1, r.y1) - corners_.at(r.x0, r.y1) - corners_.at(r.x1, r.y0) +
           corners_.at(r.x0, r.y0);
  }

 private:
  Corners corners_;
};

/// The sum of rectangles that each have one value inside: `add` them, `finish`, and read.
class AddedRectangles {
 public:
  AddedRectangles(int width, int height) : corners_(width, height) {}
  void add(const Rectangle& r, double value) {
    corners_.at(r.x0, r.y0) += value, corners_.at(r.x1, r.y1) += value;
    corners_.at(r.x1, r.y0) -= value, corners_.at(r.x0, r.y1) -= value;
  }
  void finish() { corners_.accumulate(); }
  [[nodiscard]] double at(int x, int y) const { return corners_.at(x, y); }

 private:
  Corners corners_;
};

}  // namespace pvol::detail
