#include "shell/fit/enclosing_ellipsoid.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "shell/fit/sampling.h"

namespace pvol::detail {
namespace {

constexpr int kDirections = 64;      // extreme points to start from
constexpr int kRounds = 30;          // of adding the points that lie farthest outside
constexpr int kAdded = 16;           // each time
constexpr int kIterations = 4000;    // of weights in each round
constexpr double kTolerance = 1e-3;  // relative, of (p - c)^T A (p - c)

using Lifted = std::array<double, 4>;
using Matrix4 = std::array<Lifted, 4>;

/// The inverse of a symmetric positive matrix by Gauss-Jordan elimination with the pivots in order.
Matrix4 inverse(Matrix4 m) {
  Matrix4 r{};
  for (std::size_t i = 0; i < 4; ++i) r[i][i] = 1;
  for (std::size_t p = 0; p < 4; ++p) {
    const double scale = 1 / m[p][p];
    for (std::size_t j = 0; j < 4; ++j) m[p][j] *= scale, r[p][j] *= scale;
    for (std::size_t i = 0; i < 4; ++i) {
      if (i == p) continue;
      const double factor = m[i][p];
      for (std::size_t j = 0; j < 4; ++j) {
        m[i][j] -= factor * m[p][j];
        r[i][j] -= factor * r[p][j];
      }
    }
  }
  return r;
}

double quadratic_form(const Matrix4& m, const Lifted& q) {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += q[i] * (m[i][0] * q[0] + m[i][1] * q[1] + m[i][2] * q[2] + m[i][3] * q[3]);
  }
  return sum;
}

/// Weights of the optimal design on the lifted points (p - origin, 1), which are the Lagrange
/// multipliers of the smallest ellipsoid: raise the weight of the farthest point or lower that of
/// the nearest one, whichever is more amiss.
class Design {
 public:
  explicit Design(Vec3d origin) : origin_(origin) {}

  void add(Vec3d p) {
    const Vec3d d = p - origin_;
    points_.push_back({d.x, d.y, d.z, 1});
    weight_.push_back(0);
  }

  void balance() {
    if (std::accumulate(weight_.begin(), weight_.end(), 0.0) == 0) {
      std::fill(weight_.begin(), weight_.end(), 1.0 / double(weight_.size()));
    }
    for (int iteration = 0; iteration < kIterations && step(); ++iteration) {
    }
  }

  /// The ellipsoid that the weights describe, at the scale of the smallest one.
  [[nodiscard]] Quadric ellipsoid() const {
    // With the centre moved to the origin the lifted matrix falls apart into 3x3 and 1.
    Vec3d centre;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      centre += Vec3d{points_[i][0], points_[i][1], points_[i][2]} * weight_[i];
    }
    Matrix4 moments{};
    moments[3][3] = 1;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Lifted d{points_[i][0] - centre.x, points_[i][1] - centre.y, points_[i][2] - centre.z};
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) moments[r][c] += weight_[i] * d[r] * d[c];
      }
    }
    const Matrix4 a = inverse(moments);
    const Quadric at_origin{Vec3d{a[0][0], a[1][1], a[2][2]} * (-1.0 / 3),
                            Vec3d{a[1][2], a[0][2], a[0][1]} * (-2.0 / 3),
                            {},
                            1};
    return transform(translation(origin_ + centre), at_origin);
  }

 private:
  bool step() {
    Matrix4 moments{};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (weight_[i] == 0) continue;
      for (std::size_t r = 0; r < 4; ++r) {
        for (std::size_t c = 0; c < 4; ++c)
          moments[r][c] += weight_[i] * points_[i][r] * points_[i][c];
      }
    }
    const Matrix4 metric = inverse(moments);
    std::size_t far = 0, near = 0;
    double most = -1, least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double distance = quadratic_form(metric, points_[i]);
      if (distance > most) most = distance, far = i;
      if (weight_[i] > 0 && distance < least) least = distance, near = i;
    }
    if (!(std::max(most - 4, 4 - least) > 4 * kTolerance)) return false;
    const bool raise = most - 4 >= 4 - least;
    const std::size_t changed = raise ? far : near;
    const double distance = raise ? most : least;
    double share = (distance - 4) / (4 * (distance - 1));
    const double to_nothing = -weight_[changed] / (1 - weight_[changed]);
    const bool drop = !raise && share <= to_nothing;  // a weight cannot fall below 0
    if (drop) share = to_nothing;
    for (double& w : weight_) w *= 1 - share;
    weight_[changed] = drop ? 0 : weight_[changed] + share;
    return true;
  }

  Vec3d origin_;
  std::vector<Lifted> points_;
  std::vector<double> weight_;
};

std::vector<std::size_t> extreme_points(const Points& points) {
  std::vector<std::size_t> found;
  for (int k = 0; k < kDirections; ++k) {
    const Vec3d d = direction_on_spiral(k, kDirections);
    std::size_t best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double s = dot(d, Vec3d(points[i]));
      if (s > most) most = s, best = i;
    }
    found.push_back(best);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

Quadric enclosing_ellipsoid(const Points& points) {
  const std::vector<std::size_t> start = extreme_points(points);
  Vec3d middle;
  for (const std::size_t i : start) middle += Vec3d(points[i]) / double(start.size());
  Design design(middle);
  for (const std::size_t i : start) design.add(Vec3d(points[i]));
  for (int round = 0;; ++round) {
    design.balance();
    const Quadric q = design.ellipsoid();
    std::vector<std::pair<double, std::size_t>> outside;
    double least = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double v = value(q, Vec3d(points[i]));
      least = std::min(least, v);
      if (v < -kTolerance) outside.emplace_back(v, i);
    }
    if (outside.empty() || round == kRounds) {
      // Grow about the centre until the last point is inside: there F is 1.
      Quadric grown = (1 / (1 - least)) * q;
      grown.constant = (q.constant - least) / (1 - least);
      return grown;
    }
    const std::size_t added = std::min<std::size_t>(kAdded, outside.size());
    std::partial_sort(outside.begin(), outside.begin() + std::ptrdiff_t(added), outside.end());
    for (std::size_t k = 0; k < added; ++k) design.add(Vec3d(points[outside[k].second]));
  }
}

}  // namespace pvol::detail
