// What a value that a user sets may be, as data: checked once, here, for every reader.
//
//   number(Range::closed(0, 1)).or_three()     one number in [0, 1], or an array of three
//   whole(1, 1 << 20).times(2, 'x')            an array of two; 640x480 on a command line
//   whole(0, 16).or_word("auto")               a number, or the word for none
//   set_of<Fruit>().or_word("none")            names, in an array or with commas between
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string_view>

#include "pvol/math/value.h"

namespace pvol {

/// Finite numbers between two ends; `text` is how messages put it.
struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_open = false, hi_open = false;  ///< whether the end itself is out

  [[nodiscard]] static constexpr Range closed(double lo, double hi) { return {lo, hi}; }
  [[nodiscard]] static constexpr Range open(double lo, double hi) { return {lo, hi, true, true}; }
  [[nodiscard]] static constexpr Range half_open(double lo, double hi) {
    return {lo, hi, false, true};
  }
  [[nodiscard]] static constexpr Range at_least(double lo) { return {.lo = lo}; }
  [[nodiscard]] static constexpr Range above(double lo) { return {.lo = lo, .lo_open = true}; }

  [[nodiscard]] bool contains(double v) const;  ///< false for what is not finite
  [[nodiscard]] std::string text() const;       ///< e.g. "in [0, 1)", "above 0"; "" for any number
};

struct Limits {
  enum class Shape : char { word, flag, whole, number, text, file };
  enum class Layout : char {
    one,
    list,
    one_or_three,  ///< one that counts for all three, or an array
    list_or_rows,  ///< an array, or an array of such arrays
    set,           ///< one, or an array of any length
  };
  /// Says what was expected of a value of the right shape, or null where it is right.
  using Also = const char* (*)(const Value&);

  Shape shape = Shape::word;
  Layout layout = Layout::one;
  Range range{};                              ///< of numbers
  std::int64_t least = 0, most = 0;           ///< of whole numbers
  std::array<std::size_t, 2> counts{};        ///< lengths of a list; 0 is none
  char separator = ',';                       ///< of a list on a command line
  std::string_view nothing{};                 ///< a word besides, for no value; may be empty
  std::span<const std::string_view> words{};  ///< other words, in static memory
  Also extra = nullptr;

  [[nodiscard]] constexpr Limits or_word(std::string_view word) const {
    Limits l = *this;
    l.nothing = word;
    return l;
  }
  [[nodiscard]] constexpr Limits times(std::size_t count, char between = ',') const {
    return times({count, 0}, between);
  }
  [[nodiscard]] constexpr Limits times(std::array<std::size_t, 2> lengths,
                                       char between = ',') const {
    Limits l = *this;
    l.layout = Layout::list;
    l.counts = lengths;
    l.separator = between;
    return l;
  }
  [[nodiscard]] constexpr Limits or_three() const {
    Limits l = times(3);
    l.layout = Layout::one_or_three;
    return l;
  }
  [[nodiscard]] constexpr Limits in_rows() const {
    Limits l = *this;
    l.layout = Layout::list_or_rows;
    return l;
  }
  [[nodiscard]] constexpr Limits also(Also check) const {
    Limits l = *this;
    l.extra = check;
    return l;
  }
  /// The word for nothing and the others.
  [[nodiscard]] std::vector<std::string_view> all_words() const;
};

[[nodiscard]] constexpr Limits flag() { return {.shape = Limits::Shape::flag}; }
[[nodiscard]] constexpr Limits whole(std::int64_t least, std::int64_t most) {
  return {.shape = Limits::Shape::whole, .least = least, .most = most};
}
[[nodiscard]] constexpr Limits number(Range range = {}) {
  return {.shape = Limits::Shape::number, .range = range};
}
[[nodiscard]] constexpr Limits any_text() { return {.shape = Limits::Shape::text}; }
[[nodiscard]] constexpr Limits file_name() { return {.shape = Limits::Shape::file}; }

/// The names of an enumeration, in static memory.
template <HasNames Enum>
inline constexpr auto kWords = [] {
  constexpr auto all = names(Enum{});
  std::array<std::string_view, all.size()> words;
  for (std::size_t i = 0; i < all.size(); ++i) words[i] = all[i].name;
  return words;
}();
template <HasNames Enum>
[[nodiscard]] constexpr Limits name_of() {
  return {.words = kWords<Enum>};
}

/// Any of the names of an enumeration.
template <HasNames Enum>
[[nodiscard]] constexpr Limits set_of() {
  Limits l = name_of<Enum>();
  l.layout = Limits::Layout::set;
  return l;
}

/// A direction: three numbers that are not all 0, nor so small or large that its length is.
[[nodiscard]] const char* expect_direction(const Value& value);
[[nodiscard]] constexpr Limits direction() { return number().times(3).also(expect_direction); }

/// Two numbers of which the second is greater.
[[nodiscard]] const char* expect_rising(const Value& value);

/// What was expected of a value that is refused, and which of its items is to blame: indices from
/// the outer array inwards, none for the value itself.
struct Refusal {
  std::string expected;
  std::vector<std::size_t> item{};
};

/// Nothing where the value is within the limits.
[[nodiscard]] std::optional<Refusal> refuse(const Limits& limits, const Value& value);

/// E.g. `a number in [0, 1]`, `a whole number in 0..23 or "auto"`, `an array of 4 numbers`.
[[nodiscard]] std::string expected(const Limits& limits);

/// For help: "0 to 23" of one number whose ends say something, else nothing.
[[nodiscard]] std::string ends_of(const Limits& limits);

/// The value that a text means under these limits, as command lines write it: 640x480, on, auto,
/// 1e-3. What is neither of the words nor a number is a word that `refuse` will not let pass.
[[nodiscard]] Value parse_value(const Limits& limits, std::string_view text);

/// What was expected of a value that was refused, in the words of a command line: auto or a whole
/// number in 0..23, 2 whole numbers with x between.
[[nodiscard]] std::string command_expected(const Limits& limits, const Refusal& refusal);

/// The text that `parse_value` takes for the value.
[[nodiscard]] std::string command_text(const Limits& limits, const Value& value);

}  // namespace pvol
