// Micro-bounds of bricks of samples.
#include "pvol/field/micro_bounds.h"

#include <algorithm>
#include <limits>

#include "field/brick_samples.h"
#include "field/micro_codes.h"
#include "math/parallel.h"
#include "pvol/field/brick_field.h"

namespace pvol {
namespace {

/// The densities that trilinear and nearest look-ups can compute where samples lie in [lo, hi]: on
/// plateaus exactly the samples, else up to 3 ulp beyond (THEORY.md, T1.2). An ulp is at most 2^-23
/// of the value: 2^-21 of the largest covers 4 of them.
DensityRange reach_of_lookups(float lo, float hi) {
  if (lo == hi) return {lo, hi};
  const double slack =
      std::max(double(hi) * 0x1p-21, 4 * double(std::numeric_limits<float>::denorm_min()));
  return detail::widened(double(lo), double(hi), slack);
}

/// Densities of a cube of cells: what its kernel reads are the samples of its closed corners.
DensityRange cube_range(const float* samples, Vec3i cube, int edge) {
  float lo = std::numeric_limits<float>::max(), hi = 0;
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

void trilinear_ranges(const float* samples, int edge, detail::CubeRanges& ranges) {
  const auto [lo, hi] = std::minmax_element(samples, samples + kFieldSamples);
  ranges.all = reach_of_lookups(*lo, *hi);
  const int n = kLeafEdge / edge;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        ranges.cube[std::size_t((i * n + j) * n + k)] = cube_range(samples, {i, j, k}, edge);
      }
    }
  }
}

detail::RangesOfBrick ranges_of(const BrickField& field) {
  using enum LookUp;
  return [&field](std::size_t b, int edge, detail::CubeRanges& ranges) {
    const auto brick = std::uint32_t(b);
    if (field.look_up == tricubic) {
      detail::tricubic_ranges(field.brick<tricubic>(brick), edge, ranges);
    } else {
      trilinear_ranges(field.brick(brick), edge, ranges);
    }
  };
}

detail::RangesOfBrick ranges_of(const SharedField& field) {
  return [&field](std::size_t b, int edge, detail::CubeRanges& ranges) {
    std::array<float, kFieldSamples> scratch;
    trilinear_ranges(detail::samples_of(field, std::uint32_t(b), scratch.data()), edge, ranges);
  };
}

}  // namespace

MicroBounds build_micro_bounds(const BrickField& field, int edge) {
  return detail::make_micro_bounds(field.bricks(), edge, ranges_of(field));
}

MicroBounds build_micro_bounds(const SharedField& field, int edge) {
  return detail::make_micro_bounds(field.bricks(), edge, ranges_of(field));
}

void detail::remake_micro_bounds(MicroBounds& bounds, const BrickField& field,
                                 std::span<const std::uint32_t> bricks) {
  bounds.scales.resize(field.bricks());
  bounds.codes.resize(field.bricks() * micro_cubes_per_brick(bounds.edge));
  const RangesOfBrick ranges_of_brick = ranges_of(field);
  parallel_parts(0, bricks.size(), 16, [&](std::size_t begin, std::size_t end) {
    CubeRanges ranges;
    for (std::size_t i = begin; i != end; ++i) {
      bound_brick(bounds, bricks[i], ranges_of_brick, ranges);
    }
  });
}

std::optional<std::uint32_t> find_violation(const MicroBounds& bounds, const BrickField& field) {
  return detail::find_violation(bounds, field.bricks(), ranges_of(field));
}

bool hold(const MicroBounds& bounds, const BrickField& field) {
  return detail::fit(bounds, field.bricks()) && !find_violation(bounds, field);
}

}  // namespace pvol
