// The tricubic interpolant: the uniform cubic B-spline, as nested linear interpolation.
#pragma once

#include "pvol/math/float4.h"

namespace pvol {

/// The B-spline of four samples at the offset t in [0, 1] of the cell between the middle two is
///   w0 s0 + w1 s1 + w2 s2 + w3 s3 = lerp(lerp(s0, s1, low), lerp(s2, s3, high), outer),
/// low = w1 / (w0 + w1), high = w3 / (w2 + w3), outer = w2 + w3, for three axes at once. Every
/// factor is in [0, 1] and right to 2^-21 (THEORY.md, T1.4). Based on: Sigg and Hadwiger. Fast
/// Third-Order Texture Filtering. GPU Gems 2. 2005.
struct CubicFactors {
  Float4 low, high, outer;
};

[[nodiscard]] inline CubicFactors cubic_factors(Float4 t) {
  const Float4 u = 1.0f - t;
  // Six times the weights. None of these sums cancels: those subtracted are at most 3 of 4.
  const Float4 w0 = u * u * u, w1 = 4.0f - 3.0f * (t * t) * (2.0f - t);
  const Float4 w2 = 4.0f - 3.0f * (u * u) * (2.0f - u), w3 = t * t * t;
  constexpr float kSixth = 1.0f / 6;
  return {w1 / (w0 + w1), w3 / (w2 + w3), (w2 + w3) * kSixth};
}

/// The tricubic density at offset `t` of a cell: sample (i, j, k) of the 4^3 around it, none of
/// them negative, is s[i * kX + j * kY + k]. Not negative; in the samples' hull but for 6 ulp of
/// the largest, and the exact value but for 2^-17 of that; between equal samples exactly theirs
/// (T1.4).
template <int kX, int kY>
[[nodiscard]] inline float tricubic(const float* s, Float4 t) {
  const CubicFactors f = cubic_factors(t);
  const auto lerp = [](auto a, auto b, auto x) { return a + (b - a) * x; };
  const auto along = [&](int axis, Float4 a, Float4 b, Float4 c, Float4 d) {
    return lerp(lerp(a, b, splat(f.low[axis])), lerp(c, d, splat(f.high[axis])),
                splat(f.outer[axis]));
  };
  const auto row = [&](int i, int j) { return load(s + i * kX + j * kY); };
  const auto line = [&](int j) { return along(0, row(0, j), row(1, j), row(2, j), row(3, j)); };
  const Float4 v = along(1, line(0), line(1), line(2), line(3));
  return lerp(lerp(v[0], v[1], f.low[2]), lerp(v[2], v[3], f.high[2]), f.outer[2]);
}

}  // namespace pvol
