// Compiles loops over points for AVX2 and for the compiler's default: they do the same arithmetic.
#include "shell/fit/monomials.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "math/instruction_sets.h"
#include "math/processor.h"
#define HWY_TARGET_INCLUDE "shell/fit/monomials.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_STATIC_TARGET
HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

// Eight floats at once: the vector extension of GCC and Clang, of a fixed width so that sums do not
// depend on the processor.
using Wide = float __attribute__((vector_size(4 * kWide)));

HWY_INLINE void load(const float* from, Wide& v) { std::memcpy(&v, from, sizeof v); }

HWY_INLINE void load(const Points& points, std::size_t i, Wide& x, Wide& y, Wide& z) {
  load(&points.x[i], x);
  load(&points.y[i], y);
  load(&points.z[i], z);
}

/// The value at one point, or at eight.
template <class F>
HWY_INLINE void find_value(const Monomials& q, const F& x, const F& y, const F& z, F& value) {
  value = x * (q[0] * x + q[5] * y + q[4] * z + q[6]) + y * (q[1] * y + q[3] * z + q[7]) +
          z * (q[2] * z + q[8]) + q[9];
}

HWY_INLINE float greatest_of(const Wide& v) {
  float most = v[0];
  for (std::size_t lane = 1; lane < kWide; ++lane) most = v[lane] > most ? v[lane] : most;
  return most;
}

HWY_INLINE bool all_zero(const Wide& v) {
  std::uint64_t bits[kWide / 2];
  std::memcpy(bits, &v, sizeof v);
  return (bits[0] | bits[1] | bits[2] | bits[3]) == 0;
}

/// Of weights times monomials.
struct Sums {
  Wide of[10] = {};

  HWY_INLINE void add(const Wide& x, const Wide& y, const Wide& z, const Wide& w) {
    const Wide wx = w * x, wy = w * y, wz = w * z;
    of[0] += wx * x;
    of[1] += wy * y;
    of[2] += wz * z;
    of[3] += wy * z;
    of[4] += wz * x;
    of[5] += wx * y;
    of[6] += wx;
    of[7] += wy;
    of[8] += wz;
    of[9] += w;
  }
  [[nodiscard]] QuadricTerms totals() const {
    QuadricTerms result{};
    for (std::size_t k = 0; k < 10; ++k) {
      for (std::size_t lane = 0; lane < kWide; ++lane) result[k] += double(of[k][lane]);
    }
    return result;
  }
};

float evaluate(const Monomials& q, const Points& points, float* values) {
  float most = -std::numeric_limits<float>::infinity();
  Wide most_of_lanes = Wide{} + most;
  std::size_t i = 0;
  for (; i + kWide <= points.size(); i += kWide) {
    Wide x, y, z, v;
    load(points, i, x, y, z);
    find_value(q, x, y, z, v);
    std::memcpy(values + i, &v, sizeof v);
    most_of_lanes = v > most_of_lanes ? v : most_of_lanes;
  }
  most = greatest_of(most_of_lanes);
  for (; i < points.size(); ++i) {
    find_value(q, points.x[i], points.y[i], points.z[i], values[i]);
    most = values[i] > most ? values[i] : most;
  }
  return most;
}

QuadricTerms moments(const Points& points, const float* weights) {
  Sums sums;
  for (std::size_t i = 0; i < points.size(); i += kWide) {
    Wide x, y, z, w;
    load(points, i, x, y, z);
    load(weights + i, w);
    sums.add(x, y, z, w);
  }
  return sums.totals();
}

QuadricTerms moments_near(const Points& points, const float* values, float most, float per_reach) {
  Sums sums;
  for (std::size_t i = 0; i < points.size(); i += kWide) {
    Wide v;
    load(values + i, v);
    Wide near = 1.0f - (most - v) * per_reach;
    near = near > 0.0f ? near : Wide{};
    if (all_zero(near)) continue;
    Wide x, y, z;
    load(points, i, x, y, z);
    sums.add(x, y, z, (near * near) * (near * near));
  }
  return sums.totals();
}

QuadricTerms moments_of_slopes(const Monomials& q, const Points& points, float most,
                               float per_width) {
  Sums sums;
  for (std::size_t i = 0; i < points.size(); i += kWide) {
    Wide x, y, z, v;
    load(points, i, x, y, z);
    find_value(q, x, y, z, v);
    const Wide u = (v - most) * per_width;
    const Wide r = 1.0f / (1.0f + u * u);
    Wide root;
    for (std::size_t lane = 0; lane < kWide; ++lane) root[lane] = std::sqrt(r[lane]);
    sums.add(x, y, z, r * root);
  }
  return sums.totals();
}

inline constexpr PointLoops kPointLoops{evaluate, moments, moments_near, moments_of_slopes};

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace pvol::detail {
std::vector<PointLoops> point_loops() {
  std::vector<PointLoops> all;
#if HWY_TARGETS & HWY_AVX2
  if (has_x86_64_v3()) all.push_back(N_AVX2::kPointLoops);
#endif
  all.push_back(HWY_STATIC_DISPATCH(kPointLoops));
  return all;
}

namespace {

const PointLoops& fastest() {
  static const PointLoops loops = point_loops().front();
  return loops;
}

}  // namespace

Monomials monomials(const Quadric& q) {
  Monomials m;
  std::ranges::transform(terms(q), m.begin(), [](double c) { return float(c); });
  return m;
}

float evaluate(const Monomials& q, const Points& points, float* values) {
  return fastest().evaluate(q, points, values);
}

std::size_t count_positive(const Monomials& q, const Points& points) {
  std::vector<float> values(points.size());
  evaluate(q, points, values.data());
  return std::size_t(std::ranges::count_if(values, [](float v) { return v > 0; }));
}

float greatest(const Monomials& q, const Points& points) {
  std::vector<float> values(points.size());
  return evaluate(q, points, values.data());
}

QuadricTerms moments(const Points& points, const std::vector<float>& weights) {
  return fastest().moments(points, weights.data());
}

double mean_square_gradient(const Quadric& q, const QuadricTerms& moments) {
  // The gradient is affine, g = A p + b with the rows of A (2xx, xy, zx), ...: |g|^2 is a quadric.
  const QuadricTerms w = terms(q);
  const double xx = 2 * w[0], yy = 2 * w[1], zz = 2 * w[2], yz = w[3], zx = w[4], xy = w[5];
  const double bx = w[6], by = w[7], bz = w[8];
  const QuadricTerms square{xx * xx + xy * xy + zx * zx,       xy * xy + yy * yy + yz * yz,
                            zx * zx + yz * yz + zz * zz,       2 * (xy * zx + yy * yz + yz * zz),
                            2 * (xx * zx + xy * yz + zx * zz), 2 * (xx * xy + xy * yy + zx * yz),
                            2 * (xx * bx + xy * by + zx * bz), 2 * (xy * bx + yy * by + yz * bz),
                            2 * (zx * bx + yz * by + zz * bz), bx * bx + by * by + bz * bz};
  double sum = square[9] * moments[9];
  for (std::size_t i = 0; i < 9; ++i) sum += square[i] * moments[i];
  return std::max(0.0, sum / moments[9]);
}

QuadricTerms moments_near(const Points& points, const std::vector<float>& values, float most,
                          float per_reach) {
  return fastest().moments_near(points, values.data(), most, per_reach);
}

QuadricTerms moments_of_slopes(const Monomials& q, const Points& points, float most,
                               float per_width) {
  return fastest().moments_of_slopes(q, points, most, per_width);
}

}  // namespace pvol::detail
#endif
