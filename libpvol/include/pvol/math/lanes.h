// Three axes at once: the walk's arithmetic in four-lane registers, the fourth lane idle.
#pragma once

#include <cstdint>

#include "pvol/math/vec.h"

namespace pvol {

// The vector extensions of GCC and Clang: element-wise operators, comparisons give masks of 0 and
// -1.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

[[nodiscard]] inline Float4 lanes(Vec3f v, float spare = 0) { return Float4{v.x, v.y, v.z, spare}; }
[[nodiscard]] inline Int4 lanes(Vec3i v) { return Int4{v.x, v.y, v.z, 0}; }
[[nodiscard]] inline Float4 splat(float v) { return Float4{v, v, v, v}; }
[[nodiscard]] inline Int4 splat(std::int32_t v) { return Int4{v, v, v, v}; }
[[nodiscard]] inline Vec3f vec3(Float4 v) { return {v[0], v[1], v[2]}; }
[[nodiscard]] inline Vec3i vec3(Int4 v) { return {v[0], v[1], v[2]}; }

[[nodiscard]] inline Float4 to_float(Int4 v) { return __builtin_convertvector(v, Float4); }

/// Largest integers not above v; |v| must be below 2^31.
[[nodiscard]] inline Int4 floor_to_int(Float4 v) {
  const Int4 truncated = __builtin_convertvector(v, Int4);
  return truncated + (v < to_float(truncated));  // a true comparison is -1
}

[[nodiscard]] inline Float4 select(Int4 mask, Float4 yes, Float4 no) { return mask ? yes : no; }
[[nodiscard]] inline Int4 select(Int4 mask, Int4 yes, Int4 no) { return mask ? yes : no; }
[[nodiscard]] inline Float4 min(Float4 a, Float4 b) { return a < b ? a : b; }
[[nodiscard]] inline Float4 max(Float4 a, Float4 b) { return a > b ? a : b; }
[[nodiscard]] inline Int4 min(Int4 a, Int4 b) { return a < b ? a : b; }
[[nodiscard]] inline Int4 max(Int4 a, Int4 b) { return a > b ? a : b; }

/// Least, and bitwise or, of the three axes.
[[nodiscard]] inline float least(Float4 v) { return std::min(std::min(v[0], v[1]), v[2]); }
[[nodiscard]] inline std::int32_t any_bits(Int4 v) { return v[0] | v[1] | v[2]; }

}  // namespace pvol
