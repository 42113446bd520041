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

  /// What a sum has beside its values: from both it follows again (THEORY.md, T5.20), and they take
  /// less space. For sums of up to kMostPacked terms.
  struct Remainder {
    std::array<std::array<std::uint16_t, 4>, kSize> rest{};  ///< int64_t that needs no alignment
    std::array<std::array<std::int16_t, kDigits - 1>, kSize> carries{};
    std::int8_t level = kLowest;
    friend bool operator==(const Remainder&, const Remainder&) = default;
  };
  static constexpr std::uint32_t kMostPacked = 65'534;

  void add(const std::array<double, kSize>& terms) {
    double most = 0;
    for (const double t : terms) most = std::max(most, std::abs(t));
    if (most == 0) return;
    raise_for(most);
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
    raise_for(std::bit_cast<double>(most));
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
    Digits d = of_channel(std::size_t(channel));
    (void)carry(d);
    const double high = double(d[0]) + (double(d[1]) + double(d[2]) * 0x1p-32) * 0x1p-32;
    return level > 0 ? high * power(32 * (level - 1)) * 0x1p32 : high * power(32 * level);
  }

  /// Of a sum whose values are finite.
  [[nodiscard]] Remainder remainder() const {
    Remainder r{.level = level};
    for (std::size_t c = 0; c < kSize; ++c) {
      Digits left = of_channel(c);
      const auto [middle, high] = carry(left);
      r.carries[c] = {std::int16_t(middle), std::int16_t(high)};
      const Digits rounded = digits_of(value(int(c)), level);
      for (std::size_t d = 0; d < kDigits; ++d) left[d] -= rounded[d];
      const std::uint64_t rest = (std::uint64_t(left[1]) << 32) + std::uint64_t(left[2]);
      r.rest[c] = std::bit_cast<std::array<std::uint16_t, 4>>(rest);
    }
    return r;
  }

  /// The sum that had these values and this remainder.
  [[nodiscard]] static ReproducibleSum restored(const std::array<double, kSize>& values,
                                                const Remainder& r) {
    ReproducibleSum s{.level = r.level};
    for (std::size_t c = 0; c < kSize; ++c) {
      Digits all = digits_of(values[c], r.level);
      const auto rest = std::bit_cast<std::int64_t>(r.rest[c]);
      all[1] += rest >> 32, all[2] += std::int64_t(std::uint32_t(rest));
      (void)carry(all);
      const auto [middle, high] = r.carries[c];
      s.digits[0][c] = all[0] - high;
      s.digits[1][c] = all[1] + high * kBase - middle;
      s.digits[2][c] = all[2] + middle * kBase;
    }
    return s;
  }

  friend bool operator==(const ReproducibleSum&, const ReproducibleSum&) = default;

 private:
  using Digits = std::array<std::int64_t, kDigits>;  // of a channel
  static constexpr std::int64_t kBase = std::int64_t(1) << 32;

  [[nodiscard]] Digits of_channel(std::size_t c) const {
    return {digits[0][c], digits[1][c], digits[2][c]};
  }

  /// Brings all digits but the first to between -2^31 and 2^31, so that neighbours do not cancel.
  /// Returns what was carried to the middle one, and to the first.
  static std::array<std::int64_t, 2> carry(Digits& d) {
    const std::int64_t middle = (d[2] + kBase / 2) >> 32;
    d[2] -= middle * kBase, d[1] += middle;
    const std::int64_t high = (d[1] + kBase / 2) >> 32;
    d[1] -= high * kBase, d[0] += high;
    return {middle, high};
  }

  /// The digits of a sum's value, which is a whole number of units below 2^127.
  [[nodiscard]] static Digits digits_of(double value, int level) {
    double rest = value * power(-32 * (level + 1));
    const std::int64_t highest = take_digit(rest), high = take_digit(rest);
    const std::int64_t middle = take_digit(rest);
    return {std::int64_t((std::uint64_t(highest) << 32) + std::uint64_t(high)), middle,
            take_digit(rest)};
  }

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

  /// Makes room for a term. A first digit is at most 2^31; which level a term wants depends on it
  /// alone: at equality, too.
  void raise_for(double term) {
    if (term >= power(32 * level + 31)) raise(level_of(term));
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
[[nodiscard]] inline Sum3 restored(Vec3d value, const Sum3::Remainder& r) {
  return Sum3::restored({value.x, value.y, value.z}, r);
}
[[nodiscard]] inline Sum1 restored(double value, const Sum1::Remainder& r) {
  return Sum1::restored({value}, r);
}

}  // namespace pvol
