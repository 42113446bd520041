// Ranges of the tricubic interpolant over cubes of cells, from its Bernstein coefficients.
#include <algorithm>
#include <limits>
#include <vector>

#include "pvol/field/brick_field.h"

#include "density/sample_range.h"
#include "field/micro_codes.h"

namespace pvol::detail {
namespace {

constexpr int kSamples = field_edge(LookUp::tricubic);
constexpr int kPoints = 3 * kLeafEdge + 1;  // Bezier points of 8 cells, which share their ends

/// The Bezier points of a spline with these samples, `step` apart, to places `to_step` apart. The
/// weights add up to 1, and none is negative.
void to_bezier(const double* s, int step, double* to, int to_step) {
  for (int cell = 0; cell <= kLeafEdge; ++cell, s += step, to += 3 * to_step) {
    to[0] = (s[0] + 4 * s[step] + s[2 * step]) / 6;
    if (cell == kLeafEdge) break;
    to[to_step] = (2 * s[step] + s[2 * step]) / 3;
    to[2 * to_step] = (s[step] + 2 * s[2 * step]) / 3;
  }
}

/// An array [x][y][z], converted along its last axis and turned to [z][x][y].
std::vector<double> convert(const std::vector<double>& v, int lines) {
  std::vector<double> r(std::size_t(lines) * kPoints);
  for (int line = 0; line < lines; ++line) {
    to_bezier(&v[std::size_t(line * kSamples)], 1, &r[std::size_t(line)], lines);
  }
  return r;
}

/// The same with `reduce` over the `width` entries that a cube of cells has along the last axis of
/// length `length`, `stride` apart from cube to cube.
template <class T, class Reduce>
std::vector<T> reduce_last(const std::vector<T>& v, int length, int cubes, int stride, int width,
                           const Reduce& reduce) {
  const int lines = int(v.size()) / length;
  std::vector<T> r(std::size_t(lines * cubes));
  for (int line = 0; line < lines; ++line) {
    for (int c = 0; c < cubes; ++c) {
      const auto first = v.begin() + line * length + c * stride;
      r[std::size_t(c * lines + line)] = *reduce(first, first + width);
    }
  }
  return r;
}

/// Extremes over the samples or Bezier points of each cube, cube (i, j, k) at (i * n + j) * n + k.
struct Extremes {
  std::vector<double> lo, hi;
};
Extremes extremes_of(std::vector<double> v, int length, int cubes, int stride, int width) {
  const auto least = [](auto a, auto b) { return std::min_element(a, b); };
  const auto most = [](auto a, auto b) { return std::max_element(a, b); };
  std::vector<double> lo = v, hi = std::move(v);
  for (int axis = 0; axis < 3; ++axis) {  // each turns the axes, three times back to the start
    lo = reduce_last(lo, length, cubes, stride, width, least);
    hi = reduce_last(hi, length, cubes, stride, width, most);
  }
  return {std::move(lo), std::move(hi)};
}

}  // namespace

void tricubic_ranges(const float* samples, int edge, CubeRanges& ranges) {
  constexpr int kCount = kSamples * kSamples * kSamples;
  const SampleRange all(samples, kCount);
  if (all.lo() == all.hi()) {
    ranges.all = {all.lo(), all.hi()};
    ranges.cube.fill(ranges.all);
    return;
  }
  const int n = kLeafEdge / edge;
  std::vector<double> v(samples, samples + kCount);
  const Extremes hull = extremes_of(v, kSamples, n, edge, edge + 3);
  v = convert(v, kSamples * kSamples);
  v = convert(v, kPoints * kSamples);
  v = convert(v, kPoints * kPoints);
  const Extremes bezier = extremes_of(std::move(v), kPoints, n, 3 * edge, 3 * edge + 1);

  // What look-ups and conversion are off the exact value, and look-ups alone off the hull (T1.4).
  constexpr double kOffExact = 0x1p-17, kOffHull = 0x1p-20;
  constexpr double kTiny = 64 * double(std::numeric_limits<float>::denorm_min());
  ranges.all = {std::numeric_limits<float>::max(), 0};
  for (std::size_t i = 0; i < std::size_t(n * n * n); ++i) {
    const double lo = hull.lo[i], hi = hull.hi[i];
    DensityRange r{float(lo), float(hi)};  // they are samples
    if (lo != hi) {
      const DensityRange a = widened(lo, hi, std::max(hi * kOffHull, kTiny));
      const DensityRange b = widened(bezier.lo[i], bezier.hi[i], std::max(hi * kOffExact, kTiny));
      r = {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
    }
    ranges.cube[i] = r;
    ranges.all = {std::min(ranges.all.lo, r.lo), std::max(ranges.all.hi, r.hi)};
  }
}

}  // namespace pvol::detail
