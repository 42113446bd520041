// Every operation of lanes beside the same on single numbers, over values at which they differ if
// anything does. Templates over the types of lanes, so that each kind has functions of its own.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "pvol/math/float4.h"

namespace pvol::test {

using LaneBits = std::array<std::uint32_t, 4>;

/// One operation on four pairs of operands.
struct LaneCase {
  std::string what;
  LaneBits found, expected;
  /// The result is one of the operands or a mask: NaN must be equal to the bit, not just NaN.
  bool exact;
};

template <class T>
[[nodiscard]] std::vector<T> edge_values() {
  using Limits = std::numeric_limits<T>;
  std::mt19937 engine(7);
  std::vector<T> all;
  if constexpr (Limits::is_integer) {
    all = {0,
           1,
           -1,
           2,
           3,
           7,
           8,
           -8,
           255,
           (1 << 24) + 1,
           -(1 << 24) - 1,
           1 << 30,
           Limits::max() - 1,
           Limits::max(),
           Limits::min(),
           Limits::min() + 1};
    for (int i = 0; i < 17; ++i) all.push_back(T(std::uint32_t(engine())));
  } else {
    all = {0.0f, 1.0f, 0.5f, 1.5f, 3.0f, 0.99999994f, 1.00000012f, 1e-30f, 8388607.5f, 16777217.0f};
    for (const T v : {Limits::denorm_min(), Limits::min(), Limits::max(), Limits::infinity(),
                      Limits::quiet_NaN()}) {
      all.push_back(v);
    }
    for (int i = 0; i < 18; ++i)
      all.push_back(std::ldexp(float(engine()), int(engine() % 64) - 60));
    for (std::size_t i = all.size(); i-- > 0;) all.push_back(-all[i]);
  }
  return all;
}

/// In the domain of conversions: |v| < 2^31.
[[nodiscard]] inline std::vector<float> convertible_values() {
  std::vector<float> all;
  for (const float v : edge_values<float>()) {
    if (std::abs(v) < 0x1p31f) all.push_back(v);
  }
  for (const float v :
       {2147483520.0f, 2147483392.0f, 8388608.0f, 8388609.0f, 4194303.5f, 0.49999997f}) {
    all.push_back(v);
    all.push_back(-v);
  }
  return all;
}

template <class T>
requires std::is_arithmetic_v<T>
[[nodiscard]] std::uint32_t bits_of(T one) {
  if constexpr (std::is_same_v<T, bool>) {
    return one ? 0xffffffffu : 0u;  // as in masks
  } else {
    return std::bit_cast<std::uint32_t>(one);
  }
}

template <class Four>
requires requires(Four v) { v[0]; }
[[nodiscard]] LaneBits bits_of(const Four& v) {
  return {bits_of(v[0]), bits_of(v[1]), bits_of(v[2]), bits_of(v[3])};
}

/// All pairs of values, four at a time.
template <class Four, class T, class OfFour, class OfOne>
void add_pairs(std::vector<LaneCase>& cases, const char* what, bool exact,
               const std::vector<T>& values, const OfFour& of_four, const OfOne& of_one) {
  const std::size_t n = values.size();
  for (std::size_t i = 0; i < n * n; i += 4) {
    const auto a = [&](std::size_t lane) { return values[(i + lane) / n % n]; };
    const auto b = [&](std::size_t lane) { return values[(i + lane) % n]; };
    const auto one = [&](std::size_t lane) { return bits_of(of_one(a(lane), b(lane))); };
    cases.push_back({what,
                     bits_of(of_four(Four{a(0), a(1), a(2), a(3)}, Four{b(0), b(1), b(2), b(3)})),
                     {one(0), one(1), one(2), one(3)},
                     exact});
  }
}

template <class Float4, class Int4>
void add_float_cases(std::vector<LaneCase>& cases) {
  const std::vector<float> values = edge_values<float>();
  const auto add = [&](const char* what, bool exact, const auto& of_four, const auto& of_one) {
    add_pairs<Float4>(cases, what, exact, values, of_four, of_one);
  };
  const auto both = [&](const char* what, bool exact, const auto& op) { add(what, exact, op, op); };
  both("-a", true, [](auto a, auto) { return -a; });
  both("a + b", false, [](auto a, auto b) { return a + b; });
  both("a - b", false, [](auto a, auto b) { return a - b; });
  both("a * b", false, [](auto a, auto b) { return a * b; });
  both("a / b", false, [](auto a, auto b) { return a / b; });
  both("a + 0.75", false, [](auto a, auto) { return a + 0.75f; });
  both("1 - a", false, [](auto a, auto) { return 1.0f - a; });
  both("a < b", true, [](auto a, auto b) { return a < b; });
  both("a > b", true, [](auto a, auto b) { return a > b; });
  both("a <= b", true, [](auto a, auto b) { return a <= b; });
  both("a >= b", true, [](auto a, auto b) { return a >= b; });
  both("a >= 0", true, [](auto a, auto) { return a >= 0; });
  add(
      "min", true, [](auto a, auto b) { return min(a, b); },
      [](float a, float b) { return a < b ? a : b; });
  add(
      "max", true, [](auto a, auto b) { return max(a, b); },
      [](float a, float b) { return a > b ? a : b; });
  add(
      "select", true, [](auto a, auto b) { return select(a < b, b, -a); },
      [](float a, float b) { return a < b ? b : -a; });
  add(
      "load", true,
      [](Float4 a, Float4 b) {
        const float row[] = {a[3], b[0], b[1], b[2], b[3], a[0]};
        return load(row + 1);
      },
      [](float, float b) { return b; });
}

template <class Float4, class Int4>
void add_int_cases(std::vector<LaneCase>& cases) {
  const std::vector<std::int32_t> values = edge_values<std::int32_t>();
  using U = std::uint32_t;
  using I = std::int32_t;
  const auto add = [&](const char* what, const auto& of_four, const auto& of_one) {
    add_pairs<Int4>(cases, what, true, values, of_four, of_one);
  };
  const auto both = [&](const char* what, const auto& op) { add(what, op, op); };
  add(
      "-a", [](auto a, auto) { return -a; }, [](I a, I) { return I(0 - U(a)); });
  add(
      "a + b", [](auto a, auto b) { return a + b; }, [](I a, I b) { return I(U(a) + U(b)); });
  add(
      "a - b", [](auto a, auto b) { return a - b; }, [](I a, I b) { return I(U(a) - U(b)); });
  add(
      "a + 7", [](auto a, auto) { return a + 7; }, [](I a, I) { return I(U(a) + 7u); });
  both("a & b", [](auto a, auto b) { return a & b; });
  both("a | b", [](auto a, auto b) { return a | b; });
  both("a ^ b", [](auto a, auto b) { return a ^ b; });
  both("a & -8", [](auto a, auto) { return a & -8; });
  both("a == b", [](auto a, auto b) { return a == b; });
  both("a != b", [](auto a, auto b) { return a != b; });
  both("a != 0", [](auto a, auto) { return a != 0; });
  both("a < b", [](auto a, auto b) { return a < b; });
  both("a > b", [](auto a, auto b) { return a > b; });
  for (int bits = 0; bits < 32; ++bits) {
    both("a >> bits", [bits](auto a, auto) { return a >> bits; });
  }
  add(
      "min", [](auto a, auto b) { return min(a, b); }, [](I a, I b) { return a < b ? a : b; });
  add(
      "max", [](auto a, auto b) { return max(a, b); }, [](I a, I b) { return a > b ? a : b; });
  add(
      "select", [](auto a, auto b) { return select(a < b, b, a ^ b); },
      [](I a, I b) { return a < b ? b : a ^ b; });
  add(
      "to_float", [](auto a, auto) { return to_float(a); }, [](I a, I) { return float(a); });
}

/// The three of floor_to_int and the two conversions.
template <class Float4, class Int4>
void add_conversion_cases(std::vector<LaneCase>& cases) {
  const std::vector<float> values = convertible_values();
  add_pairs<Float4>(
      cases, "truncate_to_int", true, values, [](auto a, auto) { return truncate_to_int(a); },
      [](float a, float) { return std::int32_t(a); });
  add_pairs<Float4>(
      cases, "floor_to_int", true, values, [](auto, auto b) { return floor_to_int(b); },
      [](float, float b) { return std::int32_t(std::floor(b)); });
}

template <class Float4, class Int4>
[[nodiscard]] std::vector<LaneCase> lane_cases() {
  std::vector<LaneCase> cases;
  add_float_cases<Float4, Int4>(cases);
  add_int_cases<Float4, Int4>(cases);
  add_conversion_cases<Float4, Int4>(cases);
  return cases;
}

/// Those of arrays, from a source that is compiled with PVOL_PLAIN_LANES.
[[nodiscard]] std::vector<LaneCase> plain_lane_cases();

}  // namespace pvol::test
