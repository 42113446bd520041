#include "shell/fit/distance_transform.h"

#include <limits>

#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The lower envelope of parabolas f(q) + (p - q)^2 along one row, in place.
class Envelope {
 public:
  explicit Envelope(int longest)
      : f_(std::size_t(longest)), apex_(std::size_t(longest)), start_(std::size_t(longest)) {}

  void apply(float* row, std::size_t stride, int n) {
    int count = 0;
    for (int q = 0; q < n; ++q) {
      const auto f = double(row[std::size_t(q) * stride]);
      f_[std::size_t(q)] = f;
      if (f == double(kInfinity)) continue;
      double start = -std::numeric_limits<double>::infinity();
      while (count > 0) {
        const int last = apex_[std::size_t(count - 1)];
        // Where the parabola of q falls below that of the last apex.
        start = ((f + double(q) * q) - (f_[std::size_t(last)] + double(last) * last)) /
                (2.0 * (q - last));
        if (start > start_[std::size_t(count - 1)]) break;
        start = -std::numeric_limits<double>::infinity();
        --count;
      }
      apex_[std::size_t(count)] = q;
      start_[std::size_t(count)] = start;
      ++count;
    }
    int k = 0;
    for (int p = 0; p < n && count > 0; ++p) {
      while (k + 1 < count && start_[std::size_t(k + 1)] < p) ++k;
      const int q = apex_[std::size_t(k)];
      row[std::size_t(p) * stride] = float(f_[std::size_t(q)] + double(p - q) * (p - q));
    }
  }

 private:
  std::vector<double> f_;
  std::vector<int> apex_;
  std::vector<double> start_;  ///< from where on each apex is the lowest
};

}  // namespace

std::vector<float> squared_distances(const std::vector<std::uint8_t>& marked, Vec3i size) {
  std::vector<float> distance(marked.size());
  for (std::size_t i = 0; i < marked.size(); ++i) distance[i] = marked[i] ? 0 : kInfinity;
  const std::size_t stride[3] = {1, std::size_t(size.x), std::size_t(size.x) * std::size_t(size.y)};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    parallel_parts(0, std::size_t(size[v]), 1, [&](std::size_t begin, std::size_t end) {
      Envelope envelope(size[axis]);
      for (std::size_t j = begin; j != end; ++j) {
        for (int i = 0; i < size[u]; ++i) {
          envelope.apply(&distance[std::size_t(i) * stride[u] + j * stride[v]], stride[axis],
                         size[axis]);
        }
      }
    });
  }
  return distance;
}

}  // namespace pvol::detail
