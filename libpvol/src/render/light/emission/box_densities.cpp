// Compiles the kernel once for each instruction set that has it.
#include "render/light/emission/box_densities.h"

#include <algorithm>
#include <cmath>

#include "math/instruction_sets.h"
#include "math/processor.h"
#define HWY_TARGET_INCLUDE "render/light/emission/box_densities.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, SeenBoxes::kRegister>;
using F = hn::Vec<D>;
constexpr D kF;
constexpr std::size_t kParts = SeenBoxes::kRegister / hn::MaxLanes(kF);  // of the widest register

HWY_INLINE F splat(float v) { return hn::Set(kF, v); }
HWY_INLINE F square(F v) { return v * v; }

/// Sums in as many places as the widest register has, whatever the width.
struct Sums {
  F parts[kParts];

  HWY_INLINE Sums() {
    for (F& part : parts) part = splat(0);
  }
  HWY_INLINE float all() const {
    float each[SeenBoxes::kRegister];
    for (std::size_t k = 0; k < kParts; ++k) hn::StoreU(parts[k], kF, each + k * hn::Lanes(kF));
    for (std::size_t half = SeenBoxes::kRegister / 2; half > 0; half /= 2) {
      for (std::size_t i = 0; i < half; ++i) each[i] += each[i + half];
    }
    return each[0];
  }
};

/// The weights of a register of boxes, from the i-th on.
HWY_INLINE F weights_of(const SeenBoxes& boxes, const F (&place)[3], std::size_t i) {
  F squared = splat(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    squared = squared + square(place[axis] - hn::LoadU(kF, &boxes.centre[axis][i]));
  }
  const F nearest = hn::LoadU(kF, &boxes.squared_radius[i]);
  return hn::LoadU(kF, &boxes.power[i]) / hn::Max(squared, nearest);
}

void find_weights(const SeenBoxes& boxes, Vec3f place, float* to) {
  const F at[3] = {splat(place.x), splat(place.y), splat(place.z)};
  for (std::size_t i = 0; i < boxes.size(); i += hn::Lanes(kF)) {
    hn::StoreU(weights_of(boxes, at, i), kF, to + i);
  }
}

BoxDensities find_densities(const SeenBoxes& boxes, Vec3f place, const BoxLine& line) {
  constexpr float kParallel = 1e-20f;  // below this a line never leaves a pair of planes
  const F at[3] = {splat(place.x), splat(place.y), splat(place.z)};
  F from[3], inverse[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float d = line.direction[axis];
    inverse[axis] = splat(1 / (std::abs(d) < kParallel ? kParallel : d));
    from[axis] = splat(line.nearest[axis]);
  }
  const F before = splat(line.before);
  Sums weights, along_line;
  for (std::size_t first = 0; first < boxes.size(); first += SeenBoxes::kRegister) {
    for (std::size_t k = 0; k < kParts; ++k) {
      const std::size_t i = first + k * hn::Lanes(kF);
      F begin = splat(0) - before, end = splat(3e38f);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const F a = (hn::LoadU(kF, &boxes.lo[axis][i]) - from[axis]) * inverse[axis];
        const F b = (hn::LoadU(kF, &boxes.hi[axis][i]) - from[axis]) * inverse[axis];
        begin = hn::Max(begin, hn::Min(a, b));
        end = hn::Min(end, hn::Max(a, b));
      }
      const F weight = weights_of(boxes, at, i);
      weights.parts[k] = weights.parts[k] + weight;
      const F t0 = before + begin, t1 = before + end;
      const F integral = (end - begin) * (square(t0) + t0 * t1 + square(t1)) * splat(1.0f / 3);
      const F share = weight * integral * hn::LoadU(kF, &boxes.inverse_volume[i]);
      along_line.parts[k] = along_line.parts[k] + hn::IfThenElseZero(hn::Lt(begin, end), share);
    }
  }
  return {weights.all(), along_line.all()};
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pvol::detail {

void SeenBoxes::add(Vec3f low, Vec3f high, float its_power) {
  const Vec3f size = high - low, half = size * 0.5f;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = std::size_t(axis);
    lo[k].push_back(low[axis]), hi[k].push_back(high[axis]);
    centre[k].push_back((low[axis] + high[axis]) * 0.5f);
  }
  power.push_back(its_power);
  squared_radius.push_back(dot(half, half));
  inverse_volume.push_back(1 / (size.x * size.y * size.z));
}

void SeenBoxes::fill_register() {
  while (size() % kRegister != 0) add(Vec3f(0.0f), Vec3f(1.0f), 0);
}

std::vector<BoxKernel> box_kernels() {
  std::vector<BoxKernel> all;
#if HWY_TARGETS & HWY_AVX3
  if (has_avx512()) all.push_back({N_AVX3::find_weights, N_AVX3::find_densities});
#endif
#if HWY_TARGETS & HWY_AVX2
  if (has_x86_64_v3()) all.push_back({N_AVX2::find_weights, N_AVX2::find_densities});
#endif
#if HWY_TARGETS & HWY_SSE4
  if (has_sse4()) all.push_back({N_SSE4::find_weights, N_SSE4::find_densities});
#endif
#if HWY_TARGETS & HWY_NEON
  if (has_neon()) all.push_back({N_NEON::find_weights, N_NEON::find_densities});
#endif
  all.push_back({N_SCALAR::find_weights, N_SCALAR::find_densities});
  return all;
}

const BoxKernel& box_kernel() {
  static const BoxKernel widest = box_kernels().front();
  return widest;
}

}  // namespace pvol::detail
#endif
