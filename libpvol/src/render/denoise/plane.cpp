#include "render/denoise/plane.h"

#include <algorithm>

#include "pvol/math/parallel.h"

namespace pvol::detail {

void Plane::repeat_edges() {
  for (int y = 0; y < height_; ++y) {
    float* r = row(y);
    std::fill(r - margin_, r, r[0]);
    std::fill(r + width_, r + width_ + margin_, r[width_ - 1]);
  }
  for (int y = 1; y <= margin_; ++y) {
    std::copy_n(row(0) - margin_, stride_, row(-y) - margin_);
    std::copy_n(row(height_ - 1) - margin_, stride_, row(height_ - 1 + y) - margin_);
  }
}

Plane box_mean(const Plane& plane, const Plane& weight, int radius) {
  const int width = plane.width(), height = plane.height();
  Plane out(width, height, radius);
  // Sums along each row, then down the columns: in double, and each anew, so that they do not
  // drift.
  const auto size = std::size_t(width) * std::size_t(height);
  std::vector<double> sums(size), weights(size);
  parallel_for(0, std::size_t(height), [&](std::size_t y) {
    const float *v = plane.row(int(y)), *w = weight.row(int(y));
    for (int x = 0; x < width; ++x) {
      double sum = 0, all = 0;
      for (int i = std::max(0, x - radius); i <= std::min(width - 1, x + radius); ++i) {
        sum += double(v[i]) * double(w[i]), all += double(w[i]);
      }
      sums[y * std::size_t(width) + std::size_t(x)] = sum;
      weights[y * std::size_t(width) + std::size_t(x)] = all;
    }
  });
  parallel_for(0, std::size_t(height), [&](std::size_t y) {
    const int begin = std::max(0, int(y) - radius), end = std::min(height - 1, int(y) + radius);
    for (int x = 0; x < width; ++x) {
      double sum = 0, all = 0;
      for (int i = begin; i <= end; ++i) {
        sum += sums[std::size_t(i) * std::size_t(width) + std::size_t(x)];
        all += weights[std::size_t(i) * std::size_t(width) + std::size_t(x)];
      }
      out.row(int(y))[x] = all > 0 ? float(sum / all) : 0;
    }
  });
  out.repeat_edges();
  return out;
}

}  // namespace pvol::detail
