// Compiles the kernel of noise once for each instruction set that has it.
#include "density/noise_kernels.h"

#include "density/octave.h"
#include "math/instruction_sets.h"
#include "math/processor.h"
#define HWY_TARGET_INCLUDE "density/noise_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET & PVOL_TARGETS_WITH_LANES
HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, NoisePoints::kRegister>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;
using F = hn::Vec<D>;
using U = hn::Vec<DU>;
constexpr D kF;
constexpr DI kI;
constexpr DU kU;

HWY_INLINE F splat(double v) { return hn::Set(kF, v); }
HWY_INLINE U splat_bits(std::uint64_t v) { return hn::Set(kU, v); }

/// mix64() in lanes.
HWY_INLINE U mix(U x) {
  x = hn::Xor(x, hn::ShiftRight<30>(x)) * splat_bits(0xbf58476d1ce4e5b9u);
  x = hn::Xor(x, hn::ShiftRight<27>(x)) * splat_bits(0x94d049bb133111ebu);
  return hn::Xor(x, hn::ShiftRight<31>(x));
}

/// The components of all gradients along an axis, plus 1, in two bits each.
constexpr std::uint64_t components_along(int axis) {
  std::uint64_t all = 0;
  for (std::size_t k = 0; k < kGradients.size(); ++k) {
    all |= static_cast<std::uint64_t>(kGradients[k][axis] + 1) << 2 * k;
  }
  return all;
}

/// Of numbers below 2^52, less 1, exactly: they become the last bits of a double that 2^52 begins.
HWY_INLINE F less_one(U v) {
  const U exponent = hn::BitCast(kU, splat(0x1p52));
  return hn::BitCast(kF, hn::Or(v, exponent)) - splat(0x1p52 + 1);
}

/// The slopes at places that lie this far from the corners with these hashes.
HWY_INLINE F slope(U hash, F x, F y, F z) {
  // Twice the index: the bits from kIndexShift on, one place higher.
  const U twice = hn::And(hn::ShiftRight<kIndexShift - 1>(hash), splat_bits(30));
  const auto component = [&](std::uint64_t all) {
    return less_one(hn::And(splat_bits(all) >> twice, splat_bits(3)));
  };
  constexpr std::uint64_t kX = components_along(0), kY = components_along(1),
                          kZ = components_along(2);
  return component(kX) * x + component(kY) * y + component(kZ) * z;
}

HWY_INLINE F fade(F t) { return t * t * t * (t * (t * splat(6) - splat(15)) + splat(10)); }
HWY_INLINE F lerp(F a, F b, F t) { return a + t * (b - a); }

/// gradient_noise() in lanes.
HWY_INLINE F noise(std::uint64_t seed, F px, F py, F pz) {
  const F ix = hn::Floor(px), iy = hn::Floor(py), iz = hn::Floor(pz);
  const F x = px - ix, y = py - iy, z = pz - iz;
  const auto lattice = [&](F i, std::uint64_t k) {
    return hn::BitCast(kU, hn::ConvertTo(kI, i)) * splat_bits(k);
  };
  const U base = splat_bits(seed) + lattice(ix, kHashX) + lattice(iy, kHashY) + lattice(iz, kHashZ);
  const auto corner = [&](unsigned c) {
    const U hash =
        mix(base + splat_bits((c & 1 ? kHashX : 0) + (c & 2 ? kHashY : 0) + (c & 4 ? kHashZ : 0)));
    return slope(hash, x - splat(c & 1), y - splat(c >> 1 & 1), z - splat(c >> 2));
  };
  const F u = fade(x), v = fade(y), w = fade(z);
  const auto face = [&](unsigned c) {
    return lerp(lerp(corner(c), corner(c + 1), u), lerp(corner(c + 2), corner(c + 3), u), v);
  };
  return splat(kNoiseScale) * lerp(face(0), face(4), w);
}

void fbm_kernel(const Fbm& fbm, NoisePoints& points) {
  std::array<Octave, kMaxOctaves> octaves;
  for (int k = 0; k < fbm.octaves; ++k) octaves[std::size_t(k)] = octave(fbm, k);
  for (std::size_t at = 0; at < points.n; at += hn::Lanes(kF)) {
    const F x = hn::LoadU(kF, &points.x[at]), y = hn::LoadU(kF, &points.y[at]),
            z = hn::LoadU(kF, &points.z[at]);
    F sum = splat(0);
    double weights = 0, weight = 1;
    for (int k = 0; k < fbm.octaves; ++k) {
      const Octave& o = octaves[std::size_t(k)];
      const F scale = splat(o.scale);
      const F n = noise(o.seed, x * scale + splat(o.offset.x), y * scale + splat(o.offset.y),
                        z * scale + splat(o.offset.z));
      sum = sum + splat(weight) * (fbm.billow ? hn::Abs(n) : n);
      weights += weight;
      weight *= fbm.gain;
    }
    hn::StoreU(sum / splat(weights), kF, &points.noise[at]);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace pvol::detail {

std::vector<FbmKernel> fbm_kernels() {
  std::vector<FbmKernel> all;
#if HWY_TARGETS & HWY_AVX3
  if (has_avx512()) all.push_back(N_AVX3::fbm_kernel);
#endif
#if HWY_TARGETS & HWY_AVX2
  if (has_x86_64_v3()) all.push_back(N_AVX2::fbm_kernel);
#endif
#if HWY_TARGETS & HWY_SSE4
  if (has_sse4()) all.push_back(N_SSE4::fbm_kernel);
#endif
#if HWY_TARGETS & HWY_NEON
  if (has_neon()) all.push_back(N_NEON::fbm_kernel);
#endif
  return all;
}

void find_fbm(const Fbm& fbm, NoisePoints& points) {
  static const std::vector<FbmKernel> kernels = fbm_kernels();
  if (!kernels.empty()) return kernels.front()(fbm, points);
  for (std::size_t k = 0; k < points.n; ++k) {
    points.noise[k] = pvol::fbm(fbm, {points.x[k], points.y[k], points.z[k]});
  }
}

}  // namespace pvol::detail
#endif
