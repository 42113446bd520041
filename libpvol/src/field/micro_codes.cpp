#include "field/micro_codes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

constexpr int kTopCode = 255;
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr std::size_t kGrain = 64;  // bricks of a task

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

}  // namespace

DensityRange widened(double lo, double hi, double slack) {
  const double below = std::max(0.0, lo - slack), above = std::min(hi + slack, double(kLargest));
  const auto l = static_cast<float>(below), h = static_cast<float>(above);
  return {double(l) <= below ? l : std::nextafter(l, 0.0f),
          double(h) >= above ? h : std::nextafter(h, kLargest)};
}

void bound_brick(MicroBounds& m, std::size_t b, const RangesOfBrick& ranges_of,
                 CubeRanges& ranges) {
  const std::size_t cubes = micro_cubes_per_brick(m.edge);
  ranges_of(b, m.edge, ranges);
  const MicroBounds::Scale s = m.scales[b] = make_scale(ranges.all);
  for (std::size_t i = 0; i < cubes; ++i) {
    const DensityRange r = ranges.cube[i];
    // Where steps are lost in rounding several codes stand for one density; the order is kept.
    const int up = code_up(s, r.hi), down = std::min(code_down(s, r.lo), up);
    m.codes[b * cubes + i] = {std::uint8_t(down), std::uint8_t(up)};
  }
}

MicroBounds make_micro_bounds(std::size_t bricks, int edge, const RangesOfBrick& ranges_of) {
  if (edge != 1 && edge != 2) {
    throw Error("found an edge of " + std::to_string(edge) +
                " cells of micro-bounds; expected 1 or 2");
  }
  MicroBounds m;
  m.edge = edge;
  m.scales.resize(bricks);
  m.codes.resize(bricks * micro_cubes_per_brick(edge));
  parallel_parts(0, bricks, kGrain, [&](std::size_t begin, std::size_t end) {
    CubeRanges ranges;
    for (std::size_t b = begin; b != end; ++b) bound_brick(m, b, ranges_of, ranges);
  });
  return m;
}

bool fit(const MicroBounds& bounds, std::size_t bricks) {
  return (bounds.edge == 1 || bounds.edge == 2) && bounds.scales.size() == bricks &&
         bounds.codes.size() == bricks * micro_cubes_per_brick(bounds.edge);
}

std::optional<std::uint32_t> find_violation(const MicroBounds& bounds, std::size_t bricks,
                                            const RangesOfBrick& ranges_of) {
  const std::size_t cubes = micro_cubes_per_brick(bounds.edge);
  const auto is_violated = [&](std::size_t b) {
    CubeRanges ranges;
    ranges_of(b, bounds.edge, ranges);
    bool good = true;
    for (std::size_t i = 0; i < cubes; ++i) {
      const MicroBounds::Codes c = bounds.codes[b * cubes + i];
      const MicroBounds::Scale s = bounds.scales[b];
      good &= decode(s, c.lo) <= ranges.cube[i].lo && ranges.cube[i].hi <= decode(s, c.hi);
    }
    return !good;
  };
  if (const auto b = parallel_find(bricks, kGrain, is_violated)) return std::uint32_t(*b);
  return std::nullopt;
}

}  // namespace pvol::detail
