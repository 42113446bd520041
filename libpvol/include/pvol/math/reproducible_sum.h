// Sums that are the same to the last bit whatever the order of their terms, and however parts of
// them were summed before (THEORY.md, T5.20).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "pvol/math/vec.h"

namespace pvol {

/// Sums of kSize channels. Each is kept as three digits of base 2^32 that count multiples of 2^64,
/// 2^32 and 1 times a unit; the unit follows from the largest term of any channel so far. A term's
/// digits depend on itself and the unit alone and are added as whole numbers, so that nothing is
/// left of the order. What a term has below the unit, at most 2^-64 of the largest term, is rounded
/// off. Terms must be finite; there may be 2^32 of them.
/// Based on: Demmel, Nguyen. Parallel Reproducible Summation. IEEE Transactions on Computers 64(7),
/// 2015.
template <int kSize>
struct ReproducibleSum {
  static constexpr int kDigits = 3;
  static constexpr int kLowest = -31, kHighest = 32;  ///< levels

  /// From the most significant on. They may be larger than the base: nothing is carried.
  std::array<std::array<std::int64_t, kSize>, kDigits> digits{};
  /// The first digit counts multiples of 2^(32 level).
  std::int8_t level = kLowest;

  void add(const std::array<double, kSize>& terms) {
    double most = 0;
    for (const double t : terms) most = std::max(most, std::abs(t));
    if (most == 0) return;
    // A first digit is at most 2^31. Which level a term wants depends on it alone: at equality,
    // too.
    if (most >= power(32 * level + 31)) raise(level_of(most));
    const double to_digits = power(-32 * level);
    for (int c = 0; c < kSize; ++c) {
      double rest = terms[std::size_t(c)] * to_digits;
      for (auto& digit : digits) digit[std::size_t(c)] += take_digit(rest);
    }
  }

  /// Adds n terms, rows[c] those of a channel: many at once, which a compiler makes vectors of.
  void add(const std::array<const double*, kSize>& rows, std::size_t n) {
    std::int64_t most = 0;  // positive doubles are in the order of their bits
    for (const double* const row : rows) {
      for (std::size_t k = 0; k < n; ++k) {
        most = std::max(most, std::bit_cast<std::int64_t>(std::abs(row[k])));
      }
    }
    if (most == 0) return;
    const auto largest = std::bit_cast<double>(most);
    if (largest >= power(32 * level + 31)) raise(level_of(largest));
    const double to_digits = power(-32 * level);
    for (std::size_t c = 0; c < kSize; ++c) {
      std::array<std::int64_t, kDigits> sums{};
      for (std::size_t k = 0; k < n; ++k) {
        double rest = rows[c][k] * to_digits;
        for (auto& sum : sums) sum += take_digit(rest);
      }
      for (std::size_t d = 0; d < kDigits; ++d) digits[d][c] += sums[d];
    }
  }

  /// Adds all terms of another sum.
  void merge(const ReproducibleSum& other) {
    raise(other.level);
    const int shift = level - other.level;
    for (int d = 0; d + shift < kDigits; ++d) {
      for (std::size_t c = 0; c < kSize; ++c) {
        digits[std::size_t(d + shift)][c] += other.digits[std::size_t(d)][c];
      }
    }
  }

  /// A channel's sum, to within two units in the last place of a double.
  [[nodiscard]] double value(int channel) const {
    const auto c = std::size_t(channel);
    // Digits between -2^31 and 2^31, so that neighbours do not cancel.
    constexpr std::int64_t kHalf = std::int64_t(1) << 31;
    const std::int64_t carry = (digits[2][c] + kHalf) >> 32;
    const std::int64_t low = digits[2][c] - carry * (kHalf * 2);
    const std::int64_t middle = digits[1][c] + carry;
    const std::int64_t carried = (middle + kHalf) >> 32;
    const double rest = double(middle - carried * (kHalf * 2)) + double(low) * 0x1p-32;
    const double high = double(digits[0][c] + carried) + rest * 0x1p-32;
    return level > 0 ? high * power(32 * (level - 1)) * 0x1p32 : high * power(32 * level);
  }

  friend bool operator==(const ReproducibleSum&, const ReproducibleSum&) = default;

 private:
  /// Added to a number below 2^51, it rounds that to a whole one, ties to even.
  static constexpr double kRound = 0x1.8p52;

  /// The whole number nearest to `rest`, which becomes 2^32 times what is left.
  [[nodiscard]] static std::int64_t take_digit(double& rest) {
    const double whole = rest + kRound;
    rest = (rest - (whole - kRound)) * 0x1p32;
    return std::bit_cast<std::int64_t>(whole) - std::bit_cast<std::int64_t>(kRound);
  }

  /// 2^e for e in [-1023, 1023], by its bits; infinity above.
  [[nodiscard]] static double power(int e) {
    return e > -1023 ? std::bit_cast<double>(std::uint64_t(std::min(e, 1024) + 1023) << 52)
                     : std::ldexp(1.0, e);
  }

  /// The least level whose first digit holds a term, by its exponent.
  [[nodiscard]] static int level_of(double term) {
    const int exponent = int(std::bit_cast<std::uint64_t>(term) >> 52) - 1023;  // term > 0
    return std::clamp((exponent + 1 + 1024) / 32 - 32, kLowest, kHighest);
  }

  /// Digits of earlier terms move to where they stand at a higher level.
  void raise(int to) {
    for (; level < to; ++level) {
      for (int d = kDigits - 1; d > 0; --d) digits[std::size_t(d)] = digits[std::size_t(d - 1)];
      digits[0] = {};
    }
  }
};

/// Of colours and places.
using Sum3 = ReproducibleSum<3>;
using Sum1 = ReproducibleSum<1>;

inline void add(Sum3& to, Vec3d term) { to.add({term.x, term.y, term.z}); }
inline void add(Sum1& to, double term) { to.add({term}); }
[[nodiscard]] inline Vec3d value(const Sum3& s) { return {s.value(0), s.value(1), s.value(2)}; }
[[nodiscard]] inline double value(const Sum1& s) { return s.value(0); }

}  // namespace pvol
