// The lanes of float4.h in registers of AArch64. Elsewhere there is nothing in it.
#pragma once

#if defined(__aarch64__) || defined(_M_ARM64)

#include <arm_neon.h>

#include <cstdint>

namespace pvol {
inline namespace neon_float4 {

struct Int4 {
  int32x4_t v;

  Int4() = default;
  Int4(int32x4_t bits) : v(bits) {}
  Int4(std::int32_t all) : v(vdupq_n_s32(all)) {}
  Int4(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    const std::int32_t all[4] = {a, b, c, d};
    v = vld1q_s32(all);
  }
  [[nodiscard]] std::int32_t operator[](int lane) const {
    std::int32_t all[4];
    vst1q_s32(all, v);
    return all[lane];
  }

  friend Int4 operator-(Int4 a) { return vnegq_s32(a.v); }
  friend Int4 operator+(Int4 a, Int4 b) { return vaddq_s32(a.v, b.v); }
  friend Int4 operator-(Int4 a, Int4 b) { return vsubq_s32(a.v, b.v); }
  friend Int4 operator&(Int4 a, Int4 b) { return vandq_s32(a.v, b.v); }
  friend Int4 operator|(Int4 a, Int4 b) { return vorrq_s32(a.v, b.v); }
  friend Int4 operator^(Int4 a, Int4 b) { return veorq_s32(a.v, b.v); }
  friend Int4 operator>>(Int4 a, int bits) { return vshlq_s32(a.v, vdupq_n_s32(-bits)); }
  friend Int4 operator==(Int4 a, Int4 b) { return vreinterpretq_s32_u32(vceqq_s32(a.v, b.v)); }
  friend Int4 operator!=(Int4 a, Int4 b) { return (a == b) ^ Int4(-1); }
  friend Int4 operator<(Int4 a, Int4 b) { return vreinterpretq_s32_u32(vcltq_s32(a.v, b.v)); }
  friend Int4 operator>(Int4 a, Int4 b) { return vreinterpretq_s32_u32(vcgtq_s32(a.v, b.v)); }
};

struct Float4 {
  float32x4_t v;

  Float4() = default;
  Float4(float32x4_t bits) : v(bits) {}
  Float4(float all) : v(vdupq_n_f32(all)) {}
  Float4(float a, float b, float c, float d) {
    const float all[4] = {a, b, c, d};
    v = vld1q_f32(all);
  }
  [[nodiscard]] float operator[](int lane) const {
    float all[4];
    vst1q_f32(all, v);
    return all[lane];
  }

  friend Float4 operator-(Float4 a) { return vnegq_f32(a.v); }
  friend Float4 operator+(Float4 a, Float4 b) { return vaddq_f32(a.v, b.v); }
  friend Float4 operator-(Float4 a, Float4 b) { return vsubq_f32(a.v, b.v); }
  friend Float4 operator*(Float4 a, Float4 b) { return vmulq_f32(a.v, b.v); }
  friend Float4 operator/(Float4 a, Float4 b) { return vdivq_f32(a.v, b.v); }
  friend Int4 operator<(Float4 a, Float4 b) { return vreinterpretq_s32_u32(vcltq_f32(a.v, b.v)); }
  friend Int4 operator>(Float4 a, Float4 b) { return vreinterpretq_s32_u32(vcgtq_f32(a.v, b.v)); }
  friend Int4 operator<=(Float4 a, Float4 b) { return vreinterpretq_s32_u32(vcleq_f32(a.v, b.v)); }
  friend Int4 operator>=(Float4 a, Float4 b) { return vreinterpretq_s32_u32(vcgeq_f32(a.v, b.v)); }
};

/// Four numbers in a row, of any alignment.
[[nodiscard]] inline Float4 load(const float* four) { return vld1q_f32(four); }

[[nodiscard]] inline Float4 to_float(Int4 a) { return vcvtq_f32_s32(a.v); }
/// Towards 0; |a| must be below 2^31.
[[nodiscard]] inline Int4 truncate_to_int(Float4 a) { return vcvtq_s32_f32(a.v); }

/// By a mask of 0 and -1.
[[nodiscard]] inline Int4 select(Int4 mask, Int4 yes, Int4 no) {
  return vbslq_s32(vreinterpretq_u32_s32(mask.v), yes.v, no.v);
}
[[nodiscard]] inline Float4 select(Int4 mask, Float4 yes, Float4 no) {
  return vbslq_f32(vreinterpretq_u32_s32(mask.v), yes.v, no.v);
}

/// a < b ? a : b and a > b ? a : b, of zeros and NaN as well, which the instructions of these names
/// treat otherwise.
[[nodiscard]] inline Float4 min(Float4 a, Float4 b) { return select(a < b, a, b); }
[[nodiscard]] inline Float4 max(Float4 a, Float4 b) { return select(a > b, a, b); }
[[nodiscard]] inline Int4 min(Int4 a, Int4 b) { return vminq_s32(a.v, b.v); }
[[nodiscard]] inline Int4 max(Int4 a, Int4 b) { return vmaxq_s32(a.v, b.v); }

}  // namespace neon_float4
}  // namespace pvol

#endif
