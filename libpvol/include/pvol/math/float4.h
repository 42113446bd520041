// Three axes at once: the walk's arithmetic in four-lane registers, the fourth lane idle.
//
// Float4 and Int4 are four numbers, with the operators of numbers lane by lane; one number beside
// them stands for four. Comparisons give masks, -1 where they hold and 0 elsewhere. Integers wrap.
// Each kind of processor has a header of its own with the same contents and the same results, bit
// by bit; -DPVOL_PLAIN_LANES takes arrays on all of them. The kinds are namespaces of their own, so
// that sources that differ in this do not link.
#pragma once

#include <algorithm>
#include <cstdint>

#if defined(PVOL_PLAIN_LANES)
#include "pvol/math/float4_plain.h"
#elif defined(__SSE2__) || defined(_M_X64)
#include "pvol/math/float4_sse2.h"
#elif defined(__aarch64__) || defined(_M_ARM64)
#include "pvol/math/float4_neon.h"
#else
#include "pvol/math/float4_plain.h"
#endif
#include "pvol/math/vec.h"

namespace pvol {

[[nodiscard]] inline Float4 widen(Vec3f v, float spare = 0) { return {v.x, v.y, v.z, spare}; }
[[nodiscard]] inline Int4 widen(Vec3i v) { return {v.x, v.y, v.z, 0}; }
[[nodiscard]] inline Float4 splat(float v) { return v; }
[[nodiscard]] inline Int4 splat(std::int32_t v) { return v; }
[[nodiscard]] inline Vec3f vec3(Float4 v) { return {v[0], v[1], v[2]}; }
[[nodiscard]] inline Vec3i vec3(Int4 v) { return {v[0], v[1], v[2]}; }

/// Largest integers not above v; |v| must be below 2^31.
[[nodiscard]] inline Int4 floor_to_int(Float4 v) {
  const Int4 truncated = truncate_to_int(v);
  return truncated + (v < to_float(truncated));  // a true comparison is -1
}

/// Least, and bitwise or, of the three axes.
[[nodiscard]] inline float least(Float4 v) { return std::min(std::min(v[0], v[1]), v[2]); }
[[nodiscard]] inline std::int32_t any_bits(Int4 v) { return v[0] | v[1] | v[2]; }

}  // namespace pvol
