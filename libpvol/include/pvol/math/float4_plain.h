// The lanes of float4.h as arrays, for any processor.
#pragma once

#include <cstdint>

namespace pvol {
inline namespace plain_float4 {

struct alignas(16) Int4 {
  std::int32_t v[4] = {};

  Int4() = default;
  Int4(std::int32_t all) : v{all, all, all, all} {}
  Int4(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) : v{a, b, c, d} {}
  [[nodiscard]] std::int32_t operator[](int lane) const { return v[lane]; }

  /// What `op` makes of each lane of both.
  template <class Op>
  [[nodiscard]] static Int4 each(const Int4& a, const Int4& b, const Op& op) {
    return {op(a.v[0], b.v[0]), op(a.v[1], b.v[1]), op(a.v[2], b.v[2]), op(a.v[3], b.v[3])};
  }
  using U = std::uint32_t;  // wraps
  friend Int4 operator-(Int4 a) { return Int4(0) - a; }
  friend Int4 operator+(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return std::int32_t(U(x) + U(y)); });
  }
  friend Int4 operator-(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return std::int32_t(U(x) - U(y)); });
  }
  friend Int4 operator&(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return x & y; });
  }
  friend Int4 operator|(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return x | y; });
  }
  friend Int4 operator^(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return x ^ y; });
  }
  friend Int4 operator>>(Int4 a, int bits) {
    return each(a, a, [bits](auto x, auto) { return x >> bits; });
  }
  friend Int4 operator==(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return -(x == y); });
  }
  friend Int4 operator!=(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return -(x != y); });
  }
  friend Int4 operator<(Int4 a, Int4 b) {
    return each(a, b, [](auto x, auto y) { return -(x < y); });
  }
  friend Int4 operator>(Int4 a, Int4 b) { return b < a; }
};

struct alignas(16) Float4 {
  float v[4] = {};

  Float4() = default;
  Float4(float all) : v{all, all, all, all} {}
  Float4(float a, float b, float c, float d) : v{a, b, c, d} {}
  [[nodiscard]] float operator[](int lane) const { return v[lane]; }

  /// What `op` makes of each lane of both: floats, or a mask.
  template <class Result, class Op>
  [[nodiscard]] static Result each(const Float4& a, const Float4& b, const Op& op) {
    return {op(a.v[0], b.v[0]), op(a.v[1], b.v[1]), op(a.v[2], b.v[2]), op(a.v[3], b.v[3])};
  }
  friend Float4 operator-(Float4 a) {
    return each<Float4>(a, a, [](float x, float) { return -x; });
  }
  friend Float4 operator+(Float4 a, Float4 b) {
    return each<Float4>(a, b, [](float x, float y) { return x + y; });
  }
  friend Float4 operator-(Float4 a, Float4 b) {
    return each<Float4>(a, b, [](float x, float y) { return x - y; });
  }
  friend Float4 operator*(Float4 a, Float4 b) {
    return each<Float4>(a, b, [](float x, float y) { return x * y; });
  }
  friend Float4 operator/(Float4 a, Float4 b) {
    return each<Float4>(a, b, [](float x, float y) { return x / y; });
  }
  friend Int4 operator<(Float4 a, Float4 b) {
    return each<Int4>(a, b, [](float x, float y) { return -(x < y); });
  }
  friend Int4 operator<=(Float4 a, Float4 b) {
    return each<Int4>(a, b, [](float x, float y) { return -(x <= y); });
  }
  friend Int4 operator>(Float4 a, Float4 b) { return b < a; }
  friend Int4 operator>=(Float4 a, Float4 b) { return b <= a; }
};

/// Four numbers in a row, of any alignment.
[[nodiscard]] inline Float4 load(const float* four) { return {four[0], four[1], four[2], four[3]}; }

[[nodiscard]] inline Float4 to_float(Int4 a) {
  return {float(a.v[0]), float(a.v[1]), float(a.v[2]), float(a.v[3])};
}
/// Towards 0; |a| must be below 2^31.
[[nodiscard]] inline Int4 truncate_to_int(Float4 a) {
  return {std::int32_t(a.v[0]), std::int32_t(a.v[1]), std::int32_t(a.v[2]), std::int32_t(a.v[3])};
}

/// By a mask of 0 and -1.
[[nodiscard]] inline Int4 select(Int4 mask, Int4 yes, Int4 no) {
  Int4 result = no;
  for (int i = 0; i < 4; ++i) {
    if (mask.v[i] != 0) result.v[i] = yes.v[i];
  }
  return result;
}
[[nodiscard]] inline Float4 select(Int4 mask, Float4 yes, Float4 no) {
  Float4 result = no;
  for (int i = 0; i < 4; ++i) {
    if (mask.v[i] != 0) result.v[i] = yes.v[i];
  }
  return result;
}

/// a < b ? a : b and a > b ? a : b, of zeros and NaN as well.
[[nodiscard]] inline Float4 min(Float4 a, Float4 b) { return select(a < b, a, b); }
[[nodiscard]] inline Float4 max(Float4 a, Float4 b) { return select(a > b, a, b); }
[[nodiscard]] inline Int4 min(Int4 a, Int4 b) { return select(a < b, a, b); }
[[nodiscard]] inline Int4 max(Int4 a, Int4 b) { return select(a > b, a, b); }

}  // namespace plain_float4
}  // namespace pvol
