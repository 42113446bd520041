#include "render/film/denoise/regression.h"

#include <algorithm>
#include <cmath>

namespace pvol::detail {
namespace {

constexpr std::size_t kColours = Predictions::kColours;
constexpr std::size_t kMostUnknowns = 1 + kMostFeatures;
constexpr std::size_t kMoments = kMostUnknowns * (kMostUnknowns + 1) / 2 + kColours * kMostUnknowns;

/// Of each pixel in a row of a tile, so that compilers make vectors of them.
using Row = std::array<float, kTile>;
using FeatureRows = std::array<Row, kMostFeatures>;

/// Weighted products of unknowns' factors, then of these and of colours.
using Moments = std::array<Row, kMoments>;
using Coefficients = std::array<std::array<Row, kMostUnknowns>, kColours>;

/// The features of the pixels at an offset from those of a row of the tile, less their own.
void find_differences(const RegressionInput& in, const Tile& t, int dx, int dy, int y,
                      FeatureRows& d) {
  for (std::size_t i = 0; i < in.features.size(); ++i) {
    const float* p = in.features[i].row(t.y + y) + t.x;
    const float* q = in.features[i].row(t.y + y + dy) + t.x + dx;
    for (int x = 0; x < t.width; ++x) d[i][std::size_t(x)] = q[x] - p[x];
  }
}

/// to += a b, element by element.
void add_products(Row& to, const Row& a, const Row& b) {
  for (std::size_t x = 0; x < kTile; ++x) to[x] += a[x] * b[x];
}

void add_moments(const RegressionInput& in, const Tile& t, const float* weights, int dx, int dy,
                 int y, const FeatureRows& d, Moments& m) {
  const std::size_t features = in.features.size();
  std::array<Row, kMostUnknowns> weighted;  // factors of unknowns times weights
  std::copy_n(weights, kTile, weighted[0].begin());
  for (std::size_t i = 0; i < features; ++i) {
    for (std::size_t x = 0; x < kTile; ++x) weighted[i + 1][x] = weights[x] * d[i][x];
  }
  std::size_t k = 0;
  for (std::size_t i = 0; i <= features; ++i) {
    Row& first = m[k++];
    for (std::size_t x = 0; x < kTile; ++x) first[x] += weighted[i][x];
    for (std::size_t j = 0; j < i; ++j) add_products(m[k++], weighted[i], d[j]);
  }
  for (const Plane& colour : in.colour) {
    Row u{};
    std::copy_n(colour.row(t.y + y + dy) + t.x + dx, t.width, u.begin());
    for (std::size_t i = 0; i <= features; ++i) add_products(m[k++], weighted[i], u);
  }
}

/// The symmetric system of one pixel, and its solution by Cholesky's L L^T, in double.
struct System {
  std::size_t unknowns = 0;
  std::array<std::array<double, kMostUnknowns>, kMostUnknowns> a{};

  void factorise() {
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
        a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
      }
    }
  }
  void solve(std::array<double, kMostUnknowns>& b) const {
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
      b[i] /= a[i][i];
    }
    for (std::size_t i = unknowns; i-- > 0;) {
      for (std::size_t k = i + 1; k < unknowns; ++k) b[i] -= a[k][i] * b[k];
      b[i] /= a[i][i];
    }
  }
};

/// Least squares with a doubt about slopes: as if one pixel more, of weight 1 and as far off as the
/// others, had said that there are none. Without it a pixel that is like no other would be
/// fitted by planes through nothing but itself.
void solve_row(std::size_t features, const Moments& m, Coefficients& out) {
  constexpr double kWarned = 1;
  constexpr double kLeast = 1e-9;  // of features that do not differ; their scale is 1
  for (std::size_t x = 0; x < kTile; ++x) {
    const double all = double(m[0][x]);
    for (auto& colour : out) {
      for (std::size_t i = 0; i <= features; ++i) colour[i][x] = 0;
    }
    if (!(all > 0)) continue;
    System s{features + 1, {}};
    std::size_t k = 0;
    for (std::size_t i = 0; i <= features; ++i) {
      s.a[i][0] = double(m[k++][x]);
      for (std::size_t j = 0; j < i; ++j) s.a[i][j + 1] = double(m[k++][x]);
      if (i > 0) s.a[i][i] += kWarned * s.a[i][i] / all + kLeast * all;
    }
    s.factorise();
    for (auto& colour : out) {
      std::array<double, kMostUnknowns> b{};
      for (std::size_t i = 0; i <= features; ++i) b[i] = double(m[k++][x]);
      s.solve(b);
      for (std::size_t i = 0; i <= features; ++i) colour[i][x] = float(b[i]);
    }
  }
}

void predict(const Tile& t, const PatchOptions& o, const float* weights, int dx, int dy, int y,
             std::size_t features, const FeatureRows& d, const Coefficients& fits, Predictions& p) {
  const int at = (y + dy + o.window) * p.edge + dx + o.window;
  for (std::size_t c = 0; c < kColours; ++c) {
    Row value = fits[c][0];
    for (std::size_t i = 0; i < features; ++i) add_products(value, fits[c][i + 1], d[i]);
    float* to = p.sums[c].data() + at;
    for (int x = 0; x < t.width; ++x) to[x] += weights[x] * value[std::size_t(x)];
  }
  float* to = p.sums[kColours].data() + at;
  for (int x = 0; x < t.width; ++x) to[x] += weights[x];
}

/// Calls f(dx, dy) for the offsets of a window.
template <class F>
void for_offsets(int window, const F& f) {
  for (int dy = -window; dy <= window; ++dy) {
    for (int dx = -window; dx <= window; ++dx) f(dx, dy);
  }
}

}  // namespace

Predictions regress(const RegressionInput& in, const Tile& t) {
  const int window = in.options.window;
  const PatchWeights weights(in.guide, t, in.options);
  Predictions p;
  p.edge = kTile + 2 * window;
  for (auto& sums : p.sums) sums.resize(std::size_t(p.edge) * std::size_t(p.edge));
  for (int y = 0; y < t.height; ++y) {
    FeatureRows d{};
    Moments m{};
    for_offsets(window, [&](int dx, int dy) {
      find_differences(in, t, dx, dy, y, d);
      add_moments(in, t, weights.row(dx, dy, y), dx, dy, y, d, m);
    });
    Coefficients fits;
    solve_row(in.features.size(), m, fits);
    for_offsets(window, [&](int dx, int dy) {
      find_differences(in, t, dx, dy, y, d);
      predict(t, in.options, weights.row(dx, dy, y), dx, dy, y, in.features.size(), d, fits, p);
    });
  }
  return p;
}

}  // namespace pvol::detail
