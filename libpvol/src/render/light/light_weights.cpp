// Compiles the kernel once for each instruction set that has it.
#include "render/light/light_weights.h"

#include <algorithm>
#include <numbers>

#include "math/instruction_sets.h"
#include "math/processor.h"
#define HWY_TARGET_INCLUDE "render/light/light_weights.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, LightGroups::kGroup>;
using F = hn::Vec<D>;
constexpr D kF;

HWY_INLINE F splat(float v) { return hn::Set(kF, v); }

HWY_INLINE std::uint32_t bits_of(hn::Mask<D> m) {
  std::uint8_t bytes[8] = {};  // as many as it writes at once
  hn::StoreMaskBits(kF, m, bytes);
  return std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8;
}

struct F3 {
  F x, y, z;
};
HWY_INLINE F dot(const F3& a, const F3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE F3 splat(Vec3d v) { return {splat(float(v.x)), splat(float(v.y)), splat(float(v.z))}; }

/// The ways from a place to the lights of a group. They are differences of doubles: a light far
/// away must not take the digits of those near by.
class Ways {
 public:
  HWY_INLINE Ways(const LightGroups& g, std::size_t group, Vec3d from) {
    const hn::CappedTag<double, LightGroups::kGroup> kD;
    const hn::Rebind<float, decltype(kD)> kHalf;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* const places = &g.place[axis][group * LightGroups::kGroup];
      const auto begin = hn::Set(kD, from[int(axis)]);
      for (std::size_t i = 0; i < LightGroups::kGroup; i += hn::Lanes(kD)) {
        hn::Store(hn::DemoteTo(kHalf, hn::LoadU(kD, places + i) - begin), kHalf, way_[axis] + i);
      }
    }
  }

  HWY_INLINE F3 from(std::size_t i) const {
    return {hn::Load(kF, way_[0] + i), hn::Load(kF, way_[1] + i), hn::Load(kF, way_[2] + i)};
  }

 private:
  alignas(64) float way_[3][LightGroups::kGroup];
};

/// Of a register of lights.
struct Weighed {
  F weight;
  F square;  ///< of the distance
};

/// weigh(ways) for all lights of a group: weights of those of power 1.
template <class Weigh>
HWY_INLINE std::uint32_t weigh_group(const LightGroups& g, std::size_t group, Vec3d from, float* to,
                                     const Weigh& weigh) {
  constexpr float kNear = 2;  // radii
  const Ways ways(g, group, from);
  const float* const power = &g.power[group * LightGroups::kGroup];
  const float* const radii = &g.radius[group * LightGroups::kGroup];
  std::uint32_t near = 0;
  for (std::size_t i = 0; i < LightGroups::kGroup; i += hn::Lanes(kF)) {
    const F radius = hn::LoadU(kF, radii + i), p = hn::LoadU(kF, power + i);
    const Weighed w = weigh(ways.from(i));
    const auto shines = hn::Gt(p, splat(0));
    hn::StoreU(hn::IfThenElseZero(shines, hn::Max(p * w.weight, splat(LightGroups::kLeast))), kF,
               to + i);
    const F reach = radius * splat(kNear);
    near |= bits_of(hn::Lt(w.square, reach * reach)) << i;
  }
  return near;
}

constexpr float kLeastSquare = 1e-30f, kMostSquare = 1e38f;  // at a light, and without end

HWY_INLINE F squared(const F3& way) {
  return hn::Min(hn::Max(dot(way, way), splat(kLeastSquare)), splat(kMostSquare));
}

std::uint32_t at_place(const LightGroups& g, std::size_t group, const AtPlace& from, float* to) {
  return weigh_group(g, group, from.place, to, [](const F3& way) -> Weighed {
    const F square = squared(way);
    return {splat(1) / square, square};
  });
}

std::uint32_t on_plane(const LightGroups& g, std::size_t group, const OnPlane& from, float* to) {
  // Lights have an extent: some of it may be above the plane although its middle is not.
  constexpr float kLeastCosine = 0.02f;
  const F3 normal = splat(from.normal);
  return weigh_group(g, group, from.place, to, [&](const F3& way) -> Weighed {
    const F square = squared(way);
    const F cosine = hn::Max(dot(way, normal) / hn::Sqrt(square), splat(kLeastCosine));
    return {cosine / square, square};
  });
}

std::uint32_t along_flight(const LightGroups& g, std::size_t group, const AlongFlight& from,
                           float* to) {
  const F3 d = splat(from.direction);
  const auto length = float(from.length);
  const F share = splat(length / std::numbers::pi_v<float>);
  // As near to a ray as EvenAngles takes a lamp to be.
  const F nearest = splat(std::max(1e-12f * length * length, kLeastSquare));
  return weigh_group(g, group, from.from, to, [&](const F3& way) -> Weighed {
    const F t = hn::Max(splat(0), hn::Min(dot(way, d), splat(length)));
    const F3 beside{way.x - d.x * t, way.y - d.y * t, way.z - d.z * t};
    const F square = hn::Max(squared(beside), nearest);
    // Exact where light falls evenly on the flight, and where that is endless.
    return {splat(1) / (square + hn::Sqrt(square) * share), square};
  });
}

void multiply(const float* factors, const std::uint32_t* numbers, float* weights) {
  const hn::RebindToSigned<D> kI;
  for (std::size_t i = 0; i < LightGroups::kGroup; i += hn::Lanes(kF)) {
    const auto number = hn::BitCast(kI, hn::LoadU(hn::RebindToUnsigned<D>(), numbers + i));
    hn::StoreU(hn::LoadU(kF, weights + i) * hn::GatherIndex(kF, factors, number), kF, weights + i);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pvol::detail {

void LightGroups::add_group() {
  for (std::vector<double>& axis : place) axis.resize(axis.size() + kGroup);
  power.resize(power.size() + kGroup);
  radius.resize(radius.size() + kGroup);
}

std::vector<LightKernel> light_kernels() {
  std::vector<LightKernel> all;
#if HWY_TARGETS & HWY_AVX3
  if (has_avx512())
    all.push_back({N_AVX3::at_place, N_AVX3::on_plane, N_AVX3::along_flight, N_AVX3::multiply});
#endif
#if HWY_TARGETS & HWY_AVX2
  if (has_x86_64_v3())
    all.push_back({N_AVX2::at_place, N_AVX2::on_plane, N_AVX2::along_flight, N_AVX2::multiply});
#endif
#if HWY_TARGETS & HWY_SSE4
  if (has_sse4())
    all.push_back({N_SSE4::at_place, N_SSE4::on_plane, N_SSE4::along_flight, N_SSE4::multiply});
#endif
#if HWY_TARGETS & HWY_NEON
  if (has_neon())
    all.push_back({N_NEON::at_place, N_NEON::on_plane, N_NEON::along_flight, N_NEON::multiply});
#endif
  all.push_back(
      {N_SCALAR::at_place, N_SCALAR::on_plane, N_SCALAR::along_flight, N_SCALAR::multiply});
  return all;
}

const LightKernel& light_kernel() {
  static const LightKernel widest = light_kernels().front();
  return widest;
}

}  // namespace pvol::detail
#endif
