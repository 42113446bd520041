// Arithmetic on registers of lanes, compiled once for each instruction set: random numbers,
// flights' depths, directions, phase functions. The formulas are those of math/rng.h,
// math/circle.h, math/direction.h and volume/henyey_greenstein.h.
//
// Every operation rounds as IEEE says (no approximate reciprocals), so that kernels of any width
// give the same bits; sse4 alone has no fused products.

// Included once for each target, see math/instruction_sets.h.
#if defined(PVOL_LANE_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_MATH_INL_H
#undef PVOL_LANE_MATH_INL_H
#else
#define PVOL_LANE_MATH_INL_H
#endif

#include <hwy/highway.h>

#include <cstring>

#include "pvol/math/vec.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
using U = hn::Vec<DU>;
using M = hn::Mask<DF>;
constexpr DF kF;
constexpr DI kI;
constexpr DU kU;
constexpr std::size_t kLanes = hn::MaxLanes(DF());

HWY_INLINE F splat(float v) { return hn::Set(kF, v); }
HWY_INLINE I splat_int(int v) { return hn::Set(kI, v); }
HWY_INLINE U splat_bits(std::uint32_t v) { return hn::Set(kU, v); }
HWY_INLINE F load(const float* p) { return hn::LoadU(kF, p); }
HWY_INLINE U load(const std::uint32_t* p) { return hn::LoadU(kU, p); }
HWY_INLINE void store(F v, float* p) { hn::StoreU(v, kF, p); }
HWY_INLINE void store(U v, std::uint32_t* p) { hn::StoreU(v, kU, p); }
HWY_INLINE F as_float(U v) { return hn::BitCast(kF, v); }
HWY_INLINE U as_bits(F v) { return hn::BitCast(kU, v); }
HWY_INLINE I as_int(U v) { return hn::BitCast(kI, v); }
HWY_INLINE U as_bits(I v) { return hn::BitCast(kU, v); }
HWY_INLINE F to_float(I v) { return hn::ConvertTo(kF, v); }
HWY_INLINE I to_int(F v) { return hn::ConvertTo(kI, v); }  ///< towards 0
HWY_INLINE F gather(const float* from, I at) { return hn::GatherIndex(kF, from, at); }
HWY_INLINE U gather(const std::uint32_t* from, I at) {
  return as_bits(hn::GatherIndex(kI, reinterpret_cast<const std::int32_t*>(from), at));
}
/// Words of the four bytes from each place on.
HWY_INLINE U gather_bytes(const std::uint8_t* from, I at) {
  return as_bits(hn::GatherOffset(kI, reinterpret_cast<const std::int32_t*>(from), at));
}

/// Masks of integer comparisons, for floats.
HWY_INLINE M mask(hn::Mask<DI> m) { return hn::RebindMask(kF, m); }
HWY_INLINE M mask(hn::Mask<DU> m) { return hn::RebindMask(kF, m); }
HWY_INLINE F select(M m, F yes, F no) { return hn::IfThenElse(m, yes, no); }
HWY_INLINE I select(M m, I yes, I no) { return hn::IfThenElse(hn::RebindMask(kI, m), yes, no); }
HWY_INLINE U select(M m, U yes, U no) { return hn::IfThenElse(hn::RebindMask(kU, m), yes, no); }
HWY_INLINE I where(M m, I v) { return hn::IfThenElseZero(hn::RebindMask(kI, m), v); }
HWY_INLINE std::size_t count(M m) { return hn::CountTrue(kF, m); }
HWY_INLINE M first(std::size_t n) { return hn::FirstN(kF, n); }

/// One bit for each lane.
HWY_INLINE std::uint32_t bits_of(M m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(kF, m, bytes);
  std::uint32_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}
HWY_INLINE M mask_of(std::uint32_t bits) {
  std::uint8_t bytes[8] = {};
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(kF, bytes);
}

#if HWY_TARGET == HWY_AVX2
/// By a mask of 8 lanes: the numbers of its lanes, 4 bits each, in order. (Highway has such a
/// table, which compilers copy to the stack at each use.)
struct PackingTable {
  std::uint32_t lanes[256] = {};

  constexpr PackingTable() {
    for (std::uint32_t mask = 0; mask < 256; ++mask) {
      std::uint32_t n = 0;
      for (std::uint32_t lane = 0; lane < 8; ++lane) {
        if (mask >> lane & 1) lanes[mask] |= lane << (4 * n++);
      }
    }
  }
};
inline constexpr PackingTable kPackingTable;

/// The chosen lanes at the front, in order, and whatever behind them.
HWY_INLINE U compress(M m, U v) {
  const U numbers = splat_bits(kPackingTable.lanes[bits_of(m)]);
  const U of_lane = hn::Shr(numbers, hn::ShiftLeft<2>(hn::Iota(kU, 0))) & splat_bits(7);
  return hn::TableLookupLanes(v, hn::IndicesFromVec(kU, of_lane));
}
HWY_INLINE F compress(M m, F v) { return as_float(compress(m, as_bits(v))); }
#else
HWY_INLINE U compress(M m, U v) { return hn::Compress(v, hn::RebindMask(kU, m)); }
HWY_INLINE F compress(M m, F v) { return hn::Compress(v, m); }
#endif

/// Writes the chosen lanes, in order, and whatever behind them.
HWY_INLINE void pack(M m, F v, float* to) { store(compress(m, v), to); }
HWY_INLINE void pack(M m, U v, std::uint32_t* to) { store(compress(m, v), to); }

/// Random numbers of each lane.
/// Based on: Blackman, Vigna. Scrambled Linear Pseudorandom Number Generators. 2021: xoroshiro64**,
/// which passes BigCrush and PractRand there.
struct Random {
  U s0, s1;

  HWY_INLINE U next() {
    const U product = s0 * splat_bits(0x9e3779bbu);
    const U turned = hn::RotateRight<32 - 5>(product);
    const U result = turned + hn::ShiftLeft<2>(turned);
    s1 = s1 ^ s0;
    s0 = hn::RotateRight<32 - 26>(s0) ^ s1 ^ hn::ShiftLeft<9>(s1);
    s1 = hn::RotateRight<32 - 13>(s1);
    return result;
  }

  /// In [0, 1), in steps of 2^-24: for angles and the like.
  HWY_INLINE F uniform() { return to_float(as_int(hn::ShiftRight<8>(next()))) * splat(0x1p-24f); }

  /// In [0, 1), in steps of 2^-48 near 0: for events that are rare.
  HWY_INLINE F fine_uniform() {
    const F high = uniform(), low = uniform();
    return hn::Min(hn::MulAdd(low, splat(0x1p-24f), high), splat(0x1.fffffep-1f));
  }

  /// -log of a uniform number, as in to_exponential, in [0, 21.5); steps near 0 are below 2^-48.
  HWY_INLINE F exponential() {
    const U a = next(), b = next();
    // The leading zeros of the upper 31 bits by the exponent of a float, which must not be rounded
    // up to the next one.
    const U upper = hn::ShiftRight<1>(a) | splat_bits(1);
    const F lead = to_float(as_int(hn::AndNot(hn::ShiftRight<1>(upper), upper)));
    const I exponent = as_int(hn::ShiftRight<23>(as_bits(lead)));
    const F zeros = to_float(splat_int(127 + 30) - exponent);
    // A fraction of 24 bits, and 24 more below it: the lower bits of `a` are free where zeros are
    // few, and elsewhere what they add is lost in the sum.
    const U tail = (hn::ShiftLeft<16>(b) & splat_bits(0xff0000u)) | (a & splat_bits(0xffffu));
    const F f = hn::MulAdd(to_float(as_int(tail)), splat(0x1p-48f),
                           to_float(as_int(hn::ShiftRight<8>(b))) * splat(0x1p-24f));
    const F g = f * f;
    F even = hn::MulAdd(g, splat(0.0028146638689f), splat(0.0098255452332f));
    even = hn::MulAdd(g, even, splat(0.0084253986732f));
    even = hn::MulAdd(g, even, splat(0.041712576860f));
    even = hn::MulAdd(g, even, splat(0.50000001136f));
    F odd = hn::NegMulAdd(g, splat(0.0066242654498f), splat(-0.0031802962303f));
    odd = hn::MulAdd(g, odd, splat(0.015175317348f));
    odd = hn::MulAdd(g, odd, splat(0.12499821314f));
    return hn::MulAdd(zeros, splat(0.69314718056f), f * hn::MulAdd(f, odd, even));
  }

  /// Two numbers, to make other streams of. They are drawn whether or not there is to be one: what
  /// a lane draws never depends on its neighbours.
  struct Seed {
    U a, b;
  };
  HWY_INLINE Seed seed() {
    const U a = next(), b = next();
    return {a, b};
  }

  /// The stream with this number of a seed.
  static HWY_INLINE Random stream(const Seed& seed, int number) {
    const U n = splat_bits(std::uint32_t(number) * 0x9e3779b9u);
    return {scatter_bits(seed.a + n) | splat_bits(1), scatter_bits(seed.b ^ n)};
  }

 private:
  /// A bijection that mixes well: the finaliser of Wellons' search, "lowbias32".
  static HWY_INLINE U scatter_bits(U x) {
    x = (x ^ hn::ShiftRight<16>(x)) * splat_bits(0x21f0aaadu);
    x = (x ^ hn::ShiftRight<15>(x)) * splat_bits(0xd35a2d97u);
    return x ^ hn::ShiftRight<15>(x);
  }
};

struct V {
  F x, y, z;
};
HWY_INLINE V splat(Vec3f v) { return {splat(v.x), splat(v.y), splat(v.z)}; }
HWY_INLINE F dot(V a, V b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, a.z * b.z)); }
HWY_INLINE V select(M m, V a, V b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

HWY_INLINE F one_minus_cos(V a, V b) {
  const V d{a.x - b.x, a.y - b.y, a.z - b.z};
  return splat(0.5f) * dot(d, d);
}

/// Cosine and sine of 2 pi u.
HWY_INLINE void point_at_turns(F u, F& cosine, F& sine) {
  const I quarter = to_int(hn::MulAdd(u, splat(4), splat(0.5f)));
  const F f = hn::NegMulAdd(to_float(quarter), splat(0.25f), u), y = f * f;
  F s = hn::MulAdd(y, splat(-75.401612702f), splat(81.592542871f));
  s = hn::MulAdd(y, s, splat(-41.341662571f));
  s = f * hn::MulAdd(y, s, splat(6.2831852878f));
  F c = hn::MulAdd(y, splat(-83.591816778f), splat(64.921234253f));
  c = hn::MulAdd(y, c, splat(-19.739152119f));
  c = hn::MulAdd(y, c, splat(0.99999997233f));
  const M swap = mask(hn::TestBit(quarter, splat_int(1)));
  const I two = splat_int(2);
  const U flip_c = as_bits(hn::ShiftLeft<30>((quarter + splat_int(1)) & two));
  const U flip_s = as_bits(hn::ShiftLeft<30>(quarter & two));
  cosine = as_float(as_bits(select(swap, s, c)) ^ flip_c);
  sine = as_float(as_bits(select(swap, c, s)) ^ flip_s);
}

/// The unit vector at an angle with this 1 - cos from `n`, at azimuth 2 pi u.
HWY_INLINE V turn(V n, F one_minus_cosine, F u) {
  F c, s;
  point_at_turns(u, c, s);
  const F sine = hn::Sqrt(hn::Max(splat(0), one_minus_cosine * (splat(2) - one_minus_cosine)));
  c = c * sine;
  s = s * sine;
  const F along = splat(1) - one_minus_cosine;
  const F sign = hn::CopySign(splat(1), n.z);
  const F a = splat(-1) / (sign + n.z), b = n.x * n.y * a, sx = sign * n.x;
  const V r{hn::MulAdd(c, hn::MulAdd(sx * n.x, a, splat(1)), hn::MulAdd(s, b, n.x * along)),
            hn::MulAdd(c, sign * b, hn::MulAdd(s, hn::MulAdd(n.y * n.y, a, sign), n.y * along)),
            hn::NegMulAdd(c, sx, hn::NegMulAdd(s, n.y, n.z * along))};
  const F to_unit = hn::NegMulAdd(dot(r, r), splat(0.5f), splat(1.5f));
  return {r.x * to_unit, r.y * to_unit, r.z * to_unit};
}

/// One lobe of a phase function in each lane.
struct Lobe {
  F g, one_minus_g, one_minus_g2, axis;
};

HWY_INLINE F pdf_of_angle(const Lobe& h, F one_minus_cosine) {
  const F d = hn::MulAdd(splat(2) * h.g, one_minus_cosine, h.one_minus_g * h.one_minus_g);
  return splat(0.0795774715f) * h.one_minus_g2 / (d * hn::Sqrt(d));
}
HWY_INLINE F one_minus_cos_of_share(const Lobe& h, F u) {
  const F d = hn::MulAdd(splat(2) * h.g, splat(1) - u, h.one_minus_g);
  const F c = h.one_minus_g * u * (h.one_minus_g2 / d + h.one_minus_g) / d;
  return hn::Min(c, splat(2));
}
HWY_INLINE V along_axis(const Lobe& h, V from) {
  return {from.x * h.axis, from.y * h.axis, from.z * h.axis};
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
