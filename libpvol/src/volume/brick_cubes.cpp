#include "volume/brick_cubes.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "field/brick_codes.h"
#include "field/micro_codes.h"
#include "pvol/field/brick_field.h"
#include "pvol/math/field_map.h"
#include "volume/field_samples.h"

namespace pvol::detail {
namespace {

/// use(scale, codes) of a brick's samples, which tell the same whether the field has codes or not.
template <class Use>
auto with_codes(const VolumeField& field, std::uint32_t b, const Use& use) {
  if (field.codes != nullptr) return use(field.codes->scales[b], field.codes->of_brick(b));
  std::array<float, kFieldSamples> scratch;
  std::array<std::uint8_t, kFieldSamples> codes;
  const SampleCodes::Scale scale = code_samples(samples_of(field, b, scratch.data()), codes.data());
  return use(scale, std::as_const(codes).data());
}

/// What look-ups can compute in a whole brick, before the field's map.
DensityRange find_range(const VolumeField& field, std::uint32_t b) {
  return with_codes(field, b, [](SampleCodes::Scale scale, const std::uint8_t* codes) {
    return reach_of_codes(scale, find_code_range(codes));
  });
}

/// The same in its finest cubes.
BrickCubes find_ranges(const VolumeField& field, std::uint32_t b) {
  BrickCubes r{kLeafEdge >> kFinestCubes, {}};
  if (field.look_up == LookUp::tricubic) {
    CubeRanges cubes;
    tricubic_ranges(field.bricks().brick<LookUp::tricubic>(b), 1 << kFinestCubes, cubes);
    std::copy_n(cubes.cube.begin(), r.range.size(), r.range.begin());
    return r;
  }
  with_codes(field, b, [&](SampleCodes::Scale scale, const std::uint8_t* codes) {
    std::array<CodeRange, 64> ranges;
    find_code_ranges(codes, ranges);
    for (std::size_t i = 0; i < ranges.size(); ++i) r.range[i] = reach_of_codes(scale, ranges[i]);
  });
  return r;
}

}  // namespace

BrickCubes cubes_of(const VolumeField& field, std::uint32_t brick, int shift) {
  // Parts tell no more of the whole than its codes, unless a map is to be applied to them.
  if (kLeafEdge >> shift == 1 && field.map == nullptr && field.look_up != LookUp::tricubic) {
    return {1, {find_range(field, brick)}};
  }
  BrickCubes r = find_ranges(field, brick);
  if (field.map != nullptr) {
    for (DensityRange& d : r.range) {
      const ValueRange mapped = range_over(*field.map, {d.lo, d.hi});
      d = {mapped.lo, mapped.hi};
    }
  }
  while (r.n > kLeafEdge >> shift) r = coarser(r);
  return r;
}

BrickCubes coarser(const BrickCubes& fine) {
  BrickCubes r{fine.n / 2, {}};
  r.range.fill({std::numeric_limits<float>::max(), 0});
  for_cubes(fine.n, [&](int at, Vec3i cube) {
    const int parent = ((cube.x >> 1) * r.n + (cube.y >> 1)) * r.n + (cube.z >> 1);
    DensityRange& to = r.range[std::size_t(parent)];
    const DensityRange& from = fine.range[std::size_t(at)];
    to = {std::min(to.lo, from.lo), std::max(to.hi, from.hi)};
  });
  return r;
}

}  // namespace pvol::detail
