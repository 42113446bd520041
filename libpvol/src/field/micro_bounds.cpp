// Micro-bounds of bricks of samples.
#include "pvol/field/micro_bounds.h"

#include "density/sample_range.h"
#include "field/brick_samples.h"
#include "field/cube_range.h"
#include "field/micro_codes.h"
#include "pvol/field/brick_field.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

void trilinear_ranges(const float* samples, int edge, detail::CubeRanges& ranges) {
  const detail::SampleRange all(samples, kFieldSamples);
  ranges.all = detail::reach_of_look_ups({all.lo(), all.hi()});
  const int n = kLeafEdge / edge;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        ranges.cube[std::size_t((i * n + j) * n + k)] =
            detail::reach_of_look_ups(detail::samples_in_cube(samples, {i, j, k}, edge));
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
