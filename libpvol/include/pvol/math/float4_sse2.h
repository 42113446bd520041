// The lanes of float4.h in registers of x86-64: SSE2, and a little of SSE4.1 where there is any.
// Elsewhere there is nothing in it.
#pragma once

#if defined(__SSE2__) || defined(_M_X64)

#include <emmintrin.h>
#if defined(__SSE4_1__) || defined(__AVX__)
#include <smmintrin.h>
#endif

#include <cstdint>

namespace pvol {
inline namespace sse2_float4 {

struct Int4 {
  __m128i v;

  Int4() = default;
  Int4(__m128i bits) : v(bits) {}
  Int4(std::int32_t all) : v(_mm_set1_epi32(all)) {}
  Int4(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
      : v(_mm_setr_epi32(a, b, c, d)) {}
  [[nodiscard]] std::int32_t operator[](int lane) const {
    alignas(16) std::int32_t all[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(all), v);
    return all[lane];
  }

  friend Int4 operator-(Int4 a) { return _mm_sub_epi32(_mm_setzero_si128(), a.v); }
  friend Int4 operator+(Int4 a, Int4 b) { return _mm_add_epi32(a.v, b.v); }
  friend Int4 operator-(Int4 a, Int4 b) { return _mm_sub_epi32(a.v, b.v); }
  friend Int4 operator&(Int4 a, Int4 b) { return _mm_and_si128(a.v, b.v); }
  friend Int4 operator|(Int4 a, Int4 b) { return _mm_or_si128(a.v, b.v); }
  friend Int4 operator^(Int4 a, Int4 b) { return _mm_xor_si128(a.v, b.v); }
  friend Int4 operator>>(Int4 a, int bits) { return _mm_srai_epi32(a.v, bits); }
  friend Int4 operator==(Int4 a, Int4 b) { return _mm_cmpeq_epi32(a.v, b.v); }
  friend Int4 operator!=(Int4 a, Int4 b) { return (a == b) ^ Int4(-1); }
  friend Int4 operator<(Int4 a, Int4 b) { return _mm_cmplt_epi32(a.v, b.v); }
  friend Int4 operator>(Int4 a, Int4 b) { return _mm_cmpgt_epi32(a.v, b.v); }
};

struct Float4 {
  __m128 v;

  Float4() = default;
  Float4(__m128 bits) : v(bits) {}
  Float4(float all) : v(_mm_set1_ps(all)) {}
  Float4(float a, float b, float c, float d) : v(_mm_setr_ps(a, b, c, d)) {}
  [[nodiscard]] float operator[](int lane) const {
    alignas(16) float all[4];
    _mm_store_ps(all, v);
    return all[lane];
  }

  friend Float4 operator-(Float4 a) { return _mm_xor_ps(a.v, _mm_set1_ps(-0.0f)); }
  friend Float4 operator+(Float4 a, Float4 b) { return _mm_add_ps(a.v, b.v); }
  friend Float4 operator-(Float4 a, Float4 b) { return _mm_sub_ps(a.v, b.v); }
  friend Float4 operator*(Float4 a, Float4 b) { return _mm_mul_ps(a.v, b.v); }
  friend Float4 operator/(Float4 a, Float4 b) { return _mm_div_ps(a.v, b.v); }
  friend Int4 operator<(Float4 a, Float4 b) { return _mm_castps_si128(_mm_cmplt_ps(a.v, b.v)); }
  friend Int4 operator>(Float4 a, Float4 b) { return _mm_castps_si128(_mm_cmpgt_ps(a.v, b.v)); }
  friend Int4 operator<=(Float4 a, Float4 b) { return _mm_castps_si128(_mm_cmple_ps(a.v, b.v)); }
  friend Int4 operator>=(Float4 a, Float4 b) { return _mm_castps_si128(_mm_cmpge_ps(a.v, b.v)); }
};

/// Four numbers in a row, of any alignment.
[[nodiscard]] inline Float4 load(const float* four) { return _mm_loadu_ps(four); }

[[nodiscard]] inline Float4 to_float(Int4 a) { return _mm_cvtepi32_ps(a.v); }
/// Towards 0; |a| must be below 2^31.
[[nodiscard]] inline Int4 truncate_to_int(Float4 a) { return _mm_cvttps_epi32(a.v); }

// By a mask of 0 and -1; and the lesser and greater.
#if defined(__SSE4_1__) || defined(__AVX__)
[[nodiscard]] inline Int4 select(Int4 mask, Int4 yes, Int4 no) {
  return _mm_blendv_epi8(no.v, yes.v, mask.v);
}
[[nodiscard]] inline Float4 select(Int4 mask, Float4 yes, Float4 no) {
  return _mm_blendv_ps(no.v, yes.v, _mm_castsi128_ps(mask.v));
}
[[nodiscard]] inline Int4 min(Int4 a, Int4 b) { return _mm_min_epi32(a.v, b.v); }
[[nodiscard]] inline Int4 max(Int4 a, Int4 b) { return _mm_max_epi32(a.v, b.v); }
#else
[[nodiscard]] inline Int4 select(Int4 mask, Int4 yes, Int4 no) {
  return (mask & yes) | _mm_andnot_si128(mask.v, no.v);
}
[[nodiscard]] inline Float4 select(Int4 mask, Float4 yes, Float4 no) {
  const __m128 m = _mm_castsi128_ps(mask.v);
  return _mm_or_ps(_mm_and_ps(m, yes.v), _mm_andnot_ps(m, no.v));
}
[[nodiscard]] inline Int4 min(Int4 a, Int4 b) { return select(a < b, a, b); }
[[nodiscard]] inline Int4 max(Int4 a, Int4 b) { return select(a > b, a, b); }
#endif

/// a < b ? a : b and a > b ? a : b, of zeros and NaN as well: what the instructions do.
[[nodiscard]] inline Float4 min(Float4 a, Float4 b) { return _mm_min_ps(a.v, b.v); }
[[nodiscard]] inline Float4 max(Float4 a, Float4 b) { return _mm_max_ps(a.v, b.v); }

}  // namespace sse2_float4
}  // namespace pvol

#endif
