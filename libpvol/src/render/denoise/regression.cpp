#include "render/denoise/regression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pvol::detail {
namespace {

constexpr std::size_t kMostUnknowns = 1 + kMostFeatures;
constexpr std::size_t kSystemMoments = kMostUnknowns * (kMostUnknowns + 1) / 2;

/// Of each pixel in a row of a tile, so that compilers make vectors of them.
using Row = std::array<float, kTile>;
using FeatureRows = std::array<Row, kMostFeatures>;
using UnknownRows = std::array<Row, kMostUnknowns>;

/// Least and greatest values.
struct Range {
  Row least, most;

  Range() {
    least.fill(std::numeric_limits<float>::infinity());
    most.fill(-std::numeric_limits<float>::infinity());
  }
  /// Takes in values of pixels that have a weight.
  void add(const float* weights, const Row& values) {
    for (std::size_t x = 0; x < kTile; ++x) {
      const bool counts = weights[x] > 0;
      least[x] = counts ? std::min(least[x], values[x]) : least[x];
      most[x] = counts ? std::max(most[x], values[x]) : most[x];
    }
  }
};

/// Weighted products of the unknowns' factors, and of these and each plane of the colours.
struct Moments {
  std::array<Row, kSystemMoments> system{};
  std::vector<UnknownRows> planes;
  std::vector<Range> ranges;  ///< of the planes

  explicit Moments(std::size_t count) : planes(count), ranges(count) {}
};

/// Of each plane: its value where features do not differ, and its slopes by features.
using Coefficients = std::vector<UnknownRows>;

/// The features of the pixels at an offset from those of a row of the tile, less their own.
void find_differences(const Planes& own, const Planes& others, const Tile& t, int dx, int dy, int y,
                      FeatureRows& d) {
  for (std::size_t i = 0; i < own.size(); ++i) {
    const float* p = own[i].row(t.y + y) + t.x;
    const float* q = others[i].row(t.y + y + dy) + t.x + dx;
    for (int x = 0; x < t.width; ++x) d[i][std::size_t(x)] = q[x] - p[x];
  }
}

/// to += a b, element by element.
void add_products(Row& to, const Row& a, const Row& b) {
  for (std::size_t x = 0; x < kTile; ++x) to[x] += a[x] * b[x];
}

void add_moments(const FrameInput& in, const Tile& t, const float* weights, int dx, int dy, int y,
                 const FeatureRows& d, Moments& m) {
  const std::size_t features = in.features->size();
  UnknownRows weighted;  // factors of unknowns times weights
  std::copy_n(weights, kTile, weighted[0].begin());
  for (std::size_t i = 0; i < features; ++i) {
    for (std::size_t x = 0; x < kTile; ++x) weighted[i + 1][x] = weights[x] * d[i][x];
  }
  std::size_t k = 0;
  for (std::size_t i = 0; i <= features; ++i) {
    Row& first = m.system[k++];
    for (std::size_t x = 0; x < kTile; ++x) first[x] += weighted[i][x];
    for (std::size_t j = 0; j < i; ++j) add_products(m.system[k++], weighted[i], d[j]);
  }
  for (std::size_t c = 0; c < in.colours.size(); ++c) {
    Row u{};
    std::copy_n(in.colours[c]->row(t.y + y + dy) + t.x + dx, t.width, u.begin());
    for (std::size_t i = 0; i <= features; ++i) add_products(m.planes[c][i], weighted[i], u);
    m.ranges[c].add(weights, u);
  }
}

/// The symmetric system of one pixel, and its solution by Cholesky's L L^T, in double.
struct System {
  std::size_t unknowns = 0;
  std::array<std::array<double, kMostUnknowns>, kMostUnknowns> a{};

  /// Unknowns that others determine but for rounding get an infinite pivot, and become 0.
  void factorise() {
    constexpr double kRounding = 1e-5;  // of moments, which are sums of floats
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
        if (i != j) {
          a[i][j] = sum / a[j][j];
        } else {
          const bool independent = sum > kRounding * a[i][i];
          a[i][i] = independent ? std::sqrt(sum) : std::numeric_limits<double>::infinity();
        }
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
    const double all = double(m.system[0][x]);
    if (!(all > 0)) continue;
    System s{features + 1, {}};
    std::size_t k = 0;
    for (std::size_t i = 0; i <= features; ++i) {
      s.a[i][0] = double(m.system[k++][x]);
      for (std::size_t j = 0; j < i; ++j) s.a[i][j + 1] = double(m.system[k++][x]);
      if (i > 0) s.a[i][i] += kWarned * s.a[i][i] / all + kLeast * all;
    }
    s.factorise();
    for (std::size_t c = 0; c < out.size(); ++c) {
      std::array<double, kMostUnknowns> b{};
      for (std::size_t i = 0; i <= features; ++i) b[i] = double(m.planes[c][i][x]);
      s.solve(b);
      for (std::size_t i = 0; i <= features; ++i) out[c][i][x] = float(b[i]);
    }
  }
}

/// Calls f(dx, dy) for the offsets of a window.
template <class F>
void for_offsets(int window, const F& f) {
  for (int dy = -window; dy <= window; ++dy) {
    for (int dx = -window; dx <= window; ++dx) f(dx, dy);
  }
}

/// Adds what the fits of a row of the tile predict for their windows.
void add_predictions(const Tile& t, const float* weights, int at, const FeatureRows& d,
                     std::size_t features, const Coefficients& fits, Predictions& p) {
  for (std::size_t c = 0; c < fits.size(); ++c) {
    Row value = fits[c][0];
    for (std::size_t i = 0; i < features; ++i) add_products(value, fits[c][i + 1], d[i]);
    float* to = p.sums[c].data() + at;
    for (int x = 0; x < t.width; ++x) to[x] += weights[x] * value[std::size_t(x)];
  }
  float* to = p.weights.data() + at;
  for (int x = 0; x < t.width; ++x) to[x] += weights[x];
}

/// What the moments of a row tell of the windows of its pixels.
void put_windows(const Tile& t, int y, const Moments& m, Predictions& p) {
  for (std::size_t c = 0; c < m.planes.size(); ++c) {
    for (std::size_t x = 0; x < std::size_t(t.width); ++x) {
      const float all = m.system[0][x];
      if (!(all > 0)) continue;
      p.windows[c][std::size_t(y) * kTile + x] = {m.planes[c][0][x] / all, m.ranges[c].least[x],
                                                  m.ranges[c].most[x]};
    }
  }
}

/// A frame, and what its pixels weigh.
struct FrameWeights {
  const FrameInput* frame;
  PatchWeights weights;
};

/// Of the frame that is filtered, which is the first, and of all others.
std::vector<FrameWeights> find_weights(const RegressionInput& in, const Tile& t) {
  std::vector<FrameWeights> all;
  const auto add = [&](const FrameInput& f) {
    all.push_back({&f, PatchWeights(*in.own.guide, *f.guide, f.known, t, in.options)});
  };
  add(in.own);
  for (const FrameInput& f : in.others) add(f);
  return all;
}

}  // namespace

Predictions regress(const RegressionInput& in, const Tile& t) {
  const int window = in.options.window;
  const std::size_t planes = in.own.colours.size(), features = in.own.features->size();
  const std::vector<FrameWeights> frames = find_weights(in, t);
  Predictions p;
  p.edge = kTile + 2 * window;
  const std::size_t size = std::size_t(p.edge) * std::size_t(p.edge);
  p.sums.assign(planes, std::vector<float>(size));
  p.weights.resize(size);
  p.windows.assign(planes, std::vector<WindowValues>(kTile * kTile));
  for (int y = 0; y < t.height; ++y) {
    FeatureRows d{};
    Moments m(planes);
    for (const FrameWeights& of : frames) {
      for_offsets(window, [&](int dx, int dy) {
        find_differences(*in.own.features, *of.frame->features, t, dx, dy, y, d);
        add_moments(*of.frame, t, of.weights.row(dx, dy, y), dx, dy, y, d, m);
      });
    }
    put_windows(t, y, m, p);
    Coefficients fits(planes);
    solve_row(features, m, fits);
    const PatchWeights& own = frames.front().weights;
    for_offsets(window, [&](int dx, int dy) {
      const int at = (y + dy + window) * p.edge + dx + window;
      find_differences(*in.own.features, *in.own.features, t, dx, dy, y, d);
      add_predictions(t, own.row(dx, dy, y), at, d, features, fits, p);
    });
  }
  return p;
}

}  // namespace pvol::detail
