#include "render/denoise/patch_weights.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pvol::detail {
namespace {

constexpr int kMostPatch = 8;
constexpr int kEdge = kTile + 2 * kMostPatch;

/// A tile with what lies around it within a patch.
using Surroundings = std::array<std::array<float, kEdge>, kEdge>;

/// Squared differences over the variance that they should have, less what noise alone leads to
/// expect, averaged over the planes: around 0 for pixels of equal expectation.
void add_differences(const Guide& here, const Guide& there, const Tile& t, const PatchOptions& o,
                     int dx, int dy, Surroundings& sum) {
  // Of a scale that planes have after they were made ready; far below any noise that matters.
  constexpr float kLeast = 1e-12f;
  const float k2 = o.bandwidth * o.bandwidth;
  const int width = t.width + 2 * o.patch;
  for (int y = 0; y < t.height + 2 * o.patch; ++y) {
    float* s = sum[std::size_t(y)].data();
    std::fill_n(s, width, 0.0f);
    for (std::size_t c = 0; c < here.values.size(); ++c) {
      const int row = t.y + y - o.patch, x0 = t.x - o.patch;
      const float* p = here.values[c].row(row) + x0;
      const float* q = there.values[c].row(row + dy) + x0 + dx;
      const float* vp = here.variances[c].row(row) + x0;
      const float* vq = there.variances[c].row(row + dy) + x0 + dx;
      for (int x = 0; x < width; ++x) {
        const float d = p[x] - q[x];
        const float explained = vp[x] + std::min(vp[x], vq[x]);
        s[x] += (d * d - explained) / (kLeast + k2 * (vp[x] + vq[x]));
      }
    }
  }
}

/// exp(-d) for d >= 0, but for the far end, where this reaches 0: (1 - d/8)^8.
float fall_off(float d) {
  const float a = std::max(0.0f, 1 - std::max(0.0f, d) / 8);
  const float a2 = a * a, a4 = a2 * a2;
  return a4 * a4;
}

}  // namespace

std::size_t tiles_in(int width, int height) {
  return std::size_t((width + kTile - 1) / kTile) * std::size_t((height + kTile - 1) / kTile);
}

Tile tile_of(std::size_t number, int width, int height) {
  const int across = (width + kTile - 1) / kTile;
  const int x = int(number % std::size_t(across)) * kTile;
  const int y = int(number / std::size_t(across)) * kTile;
  return {x, y, std::min(kTile, width - x), std::min(kTile, height - y)};
}

PatchWeights::PatchWeights(const Guide& here, const Guide& there, const Plane* known, const Tile& t,
                           const PatchOptions& o)
    : window_(o.window), weights_(std::size_t(offsets_of(o.window)) * kTile * kTile) {
  const int picture_width = here.values[0].width(), picture_height = here.values[0].height();
  const int edge = 2 * o.patch + 1;
  const float share = 1 / (float(edge * edge) * float(here.values.size()));
  Surroundings d{};
  float* to = weights_.data();
  for (int dy = -o.window; dy <= o.window; ++dy) {
    for (int dx = -o.window; dx <= o.window; ++dx, to += kTile * kTile) {
      add_differences(here, there, t, o, dx, dy, d);
      for (int y = 0; y < t.height + 2 * o.patch; ++y) {  // sums of stretches, at their left ends
        auto& row = d[std::size_t(y)];
        for (int x = 0; x < t.width; ++x) {
          float sum = 0;
          for (int i = 0; i < edge; ++i) sum += row[std::size_t(x + i)];
          row[std::size_t(x)] = sum;
        }
      }
      const int first = std::max(0, -(t.x + dx));
      const int last = std::min(t.width, picture_width - t.x - dx);
      for (int y = 0; y < t.height; ++y) {
        if (t.y + y + dy < 0 || t.y + y + dy >= picture_height) continue;
        std::array<float, kTile> sum{};
        for (int i = 0; i < edge; ++i) {
          const float* row = d[std::size_t(y + i)].data();
          for (int x = 0; x < kTile; ++x) sum[std::size_t(x)] += row[x];
        }
        const float* counts = known ? known->row(t.y + y + dy) + t.x + dx : nullptr;
        for (int x = first; x < last; ++x) {
          const float w = fall_off(sum[std::size_t(x)] * share);
          to[y * kTile + x] = counts ? w * counts[x] : w;
        }
      }
    }
  }
}

}  // namespace pvol::detail
