// Extremes of the samples in each cube's reach, rounded outward to a byte.
#include "pvol/bounds/micro_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pvol/error.h"

namespace pvol {
namespace {

constexpr int kTopCode = 255;
constexpr float kLargest = std::numeric_limits<float>::max();

/// The densities that look-ups can compute where samples lie in [lo, hi]: on plateaus exactly the
/// samples, else up to 3 ulp beyond (THEORY.md, T2), though never below 0. An ulp is at most 2^-23
/// of the value: 2^-21 of the largest covers 4 of them.
DensityRange reach_of_lookups(float lo, float hi) {
  if (lo == hi) return {lo, hi};
  const double slack =
      std::max(double(hi) * 0x1p-21, 4 * double(std::numeric_limits<float>::denorm_min()));
  const double below = std::max(0.0, double(lo) - slack), above = double(hi) + slack;
  const float l = float(below), h = float(std::min(above, double(kLargest)));
  return {double(l) <= below ? l : std::nextafter(l, 0.0f),
          double(h) >= above ? h : std::nextafter(h, kLargest)};
}

/// Densities of a cube of cells: what its kernel reads are the samples of its closed corners.
DensityRange cube_range(const float* samples, Vec3i cube, int edge) {
  float lo = kLargest, hi = 0;
  for (int i = cube.x * edge; i <= (cube.x + 1) * edge; ++i) {
    for (int j = cube.y * edge; j <= (cube.y + 1) * edge; ++j) {
      for (int k = cube.z * edge; k <= (cube.z + 1) * edge; ++k) {
        const float v = samples[(i * kFieldEdge + j) * kFieldEdge + k];
        lo = std::min(lo, v);
        hi = std::max(hi, v);
      }
    }
  }
  return reach_of_lookups(lo, hi);
}

/// `f(at, range)` for every cube of a brick, in the order of the codes.
template <class F>
void for_cubes(const float* samples, int edge, const F& f) {
  const int n = kLeafEdge / edge;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        f(std::size_t((i * n + j) * n + k), cube_range(samples, {i, j, k}, edge));
      }
    }
  }
}

float decode(MicroBounds::Scale s, int code) { return s.base + float(code) * s.step; }

/// The scale of a brick whose cubes lie in `range`: code 0 is its low end, 255 its high end or a
/// little more.
MicroBounds::Scale make_scale(DensityRange range) {
  MicroBounds::Scale s{range.lo, (range.hi - range.lo) / kTopCode};
  while (decode(s, kTopCode) < range.hi) s.step = std::nextafter(s.step, kLargest);
  return s;
}

/// The largest code not above v and the smallest not below it. The quotient is right to a code or
/// so; decoding decides.
int code_down(MicroBounds::Scale s, float v) {
  if (s.step == 0) return 0;
  int c = std::clamp(int((v - s.base) / s.step) + 1, 0, kTopCode);
  while (c > 0 && decode(s, c) > v) --c;
  return c;
}
int code_up(MicroBounds::Scale s, float v) {
  if (s.step == 0) return 0;
  int c = std::clamp(int((v - s.base) / s.step) - 1, 0, kTopCode);
  while (c < kTopCode && decode(s, c) < v) ++c;
  return c;
}

void encode_brick(const float* samples, int edge, MicroBounds::Scale& scale,
                  MicroBounds::Codes* codes) {
  const auto [lo, hi] = std::minmax_element(samples, samples + kFieldSamples);
  scale = make_scale(reach_of_lookups(*lo, *hi));
  for_cubes(samples, edge, [&](std::size_t at, DensityRange r) {
    // Where steps are lost in rounding several codes stand for one density; the order is kept.
    const int up = code_up(scale, r.hi), down = std::min(code_down(scale, r.lo), up);
    codes[at] = {std::uint8_t(down), std::uint8_t(up)};
  });
}

constexpr std::size_t kGrain = 64;  // bricks of a task

std::size_t brick_count(const BrickField& field) { return field.samples.size() / kFieldSamples; }

}  // namespace

MicroBounds build_micro_bounds(const BrickField& field, int edge) {
  if (edge != 1 && edge != 2) {
    throw Error(std::to_string(edge) + ": the edge of micro-bounds must be 1 or 2 cells");
  }
  const std::size_t bricks = brick_count(field), cubes = micro_cubes_per_brick(edge);
  MicroBounds m;
  m.edge = edge;
  m.scales.resize(bricks);
  m.codes.resize(bricks * cubes);
  const tbb::blocked_range<std::size_t> all(0, bricks, kGrain);
  tbb::parallel_for(all, [&](const auto& range) {
    for (std::size_t b = range.begin(); b != range.end(); ++b) {
      encode_brick(field.brick(std::uint32_t(b)), edge, m.scales[b], &m.codes[b * cubes]);
    }
  });
  return m;
}

std::optional<std::uint32_t> find_violation(const MicroBounds& bounds, const BrickField& field) {
  const std::size_t cubes = micro_cubes_per_brick(bounds.edge);
  const auto brick_holds = [&](std::size_t b) {
    bool good = true;
    for_cubes(field.brick(std::uint32_t(b)), bounds.edge, [&](std::size_t at, DensityRange r) {
      const MicroBounds::Codes c = bounds.codes[b * cubes + at];
      const MicroBounds::Scale s = bounds.scales[b];
      good &= decode(s, c.lo) <= r.lo && r.hi <= decode(s, c.hi);
    });
    return good;
  };
  const std::size_t none = brick_count(field);
  const std::size_t first = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, none, kGrain), none,
      [&](const auto& range, std::size_t found) {
        for (std::size_t b = range.begin(); b < std::min(range.end(), found); ++b) {
          if (!brick_holds(b)) return b;
        }
        return found;
      },
      [](std::size_t x, std::size_t y) { return std::min(x, y); });
  if (first == none) return std::nullopt;
  return std::uint32_t(first);
}

bool hold(const MicroBounds& bounds, const BrickField& field) {
  if (bounds.edge != 1 && bounds.edge != 2) return false;
  const std::size_t bricks = brick_count(field), cubes = micro_cubes_per_brick(bounds.edge);
  if (bounds.scales.size() != bricks || bounds.codes.size() != bricks * cubes) return false;
  return !find_violation(bounds, field);
}

}  // namespace pvol
