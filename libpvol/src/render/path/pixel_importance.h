// How much noise counts in each pixel: it is seen beside the pixel's own brightness.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pvol::detail {

/// The factor by which decisions take a path's light to be brighter than it is (THEORY.md, T5.5),
/// on a coarse raster over the whole image.
struct PixelImportance {
  int columns = 1, rows = 1;
  std::vector<float> of_cell{1.0f};  ///< in rows from the top

  /// At a place of the image, from 0 to 1 across and down, between the centres of cells.
  [[nodiscard]] float of(double across, double down) const {
    const Between i(across, columns), j(down, rows);
    const auto row = [&](int k) {
      return at(i.first, k) + (at(i.second, k) - at(i.first, k)) * i.share;
    };
    return row(j.first) + (row(j.second) - row(j.first)) * j.share;
  }

 private:
  /// Two cells along an axis, and how far a place is from the first to the second.
  struct Between {
    int first, second;
    float share;
    Between(double place, int cells) {
      const double x = std::clamp(place * cells - 0.5, 0.0, cells - 1.0);
      first = int(x), second = std::min(first + 1, cells - 1);
      share = float(x - first);
    }
  };
  [[nodiscard]] float at(int column, int row) const {
    return of_cell[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
  }
};

}  // namespace pvol::detail
