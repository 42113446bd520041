#include "toml/toml_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

constexpr std::size_t kShownText = 60;  // characters of a found string

template <class T>
std::string shortest(T value) {
  std::array<char, 64> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

/// "a, b or c", each as `show` puts it.
template <class Items, class Show>
std::string listed(const Items& items, Show show) {
  std::string text;
  std::size_t left = items.size();
  for (const auto& item : items) {
    text += show(item);
    if (--left > 0) text += left > 1 ? ", " : " or ";
  }
  return text;
}

[[noreturn]] void fail_at(const TomlValue& value, const std::string& expected) {
  throw Error(value.where + ": " + value.name + " is " + value.text() + "; expected " + expected);
}

/// Levenshtein's distance, row by row.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replace, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// '; did you mean "fov"?', or nothing where every word needs more than two edits of the key, or
/// edits of more than half of it.
template <class Words>
std::string suggestion(std::string_view key, const Words& words) {
  constexpr std::size_t kClose = 2;
  const auto nearest = std::min_element(words.begin(), words.end(), [&](auto a, auto b) {
    return edit_distance(key, a) < edit_distance(key, b);
  });
  if (nearest == words.end()) return "";
  const std::size_t edits = edit_distance(key, *nearest);
  if (edits > kClose || edits * 2 > key.size()) return "";
  return "; did you mean " + toml_string(*nearest) + "?";
}

std::string whole_number_text(std::int64_t lo, std::int64_t hi) {
  return "a whole number in " + std::to_string(lo) + ".." + std::to_string(hi);
}

std::int64_t whole_number_of(const TomlValue& value, std::int64_t lo, std::int64_t hi) {
  const auto* whole = std::get_if<std::int64_t>(&value.value);
  if (!whole || *whole < lo || *whole > hi) fail_at(value, whole_number_text(lo, hi));
  return *whole;
}

std::string number_text(const Range& range) {
  const std::string ends = range.text();
  return ends.empty() ? "a finite number" : "a number " + ends;
}

double number_of(const TomlValue& value, const Range& range) {
  double number = std::numeric_limits<double>::quiet_NaN();
  if (const auto* real = std::get_if<double>(&value.value)) number = *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) number = double(*whole);
  if (!range.contains(number)) fail_at(value, number_text(range));
  return number;
}

/// The items of an array with an allowed length; `what` names them in the message.
const TomlArray& array_of(const TomlValue& value, std::initializer_list<std::size_t> counts,
                          const std::string& what) {
  const auto* array = std::get_if<TomlArray>(&value.value);
  const bool fits = array && (counts.size() == 0 || std::find(counts.begin(), counts.end(),
                                                              array->size()) != counts.end());
  if (!fits) {
    const std::string lengths = listed(counts, shortest<std::size_t>);
    fail_at(value, "an array of " + lengths + (lengths.empty() ? "" : " ") + what);
  }
  return *array;
}

std::vector<double> numbers_of(const TomlValue& value, std::initializer_list<std::size_t> counts,
                               const Range& range) {
  std::vector<double> result;
  for (const TomlValue& item : array_of(value, counts, "numbers")) {
    result.push_back(number_of(item, range));
  }
  return result;
}

Vec3d vector_of(const TomlValue& value, const Range& range) {
  const std::vector<double> v = numbers_of(value, {3}, range);
  return {v[0], v[1], v[2]};
}

}  // namespace

bool Range::contains(double v) const {
  return std::isfinite(v) && (lo_open ? v > lo : v >= lo) && (hi_open ? v < hi : v <= hi);
}

std::string Range::text() const {
  const bool below = std::isfinite(hi), above_ = std::isfinite(lo);
  if (below && above_) {
    return std::string("in ") + (lo_open ? "(" : "[") + shortest(lo) + ", " + shortest(hi) +
           (hi_open ? ")" : "]");
  }
  if (above_) return (lo_open ? "above " : "of at least ") + shortest(lo);
  if (below) return (hi_open ? "below " : "of at most ") + shortest(hi);
  return "";
}

std::string TomlValue::text() const {
  struct Shown {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return shortest(v); }
    std::string operator()(double v) const { return toml_number(v); }
    std::string operator()(const std::string& v) const {
      return v.size() <= kShownText ? toml_string(v) : toml_string(v.substr(0, kShownText)) + "...";
    }
    std::string operator()(TomlDate) const { return "a date or time"; }
    std::string operator()(const TomlArray& v) const { return "an array of " + shortest(v.size()); }
    std::string operator()(const TomlTable&) const { return "a table"; }
  };
  return std::visit(Shown{}, value);
}

void TomlTable::allow_only(std::initializer_list<std::string_view> keys) const {
  const auto plain = [](std::string_view key) { return std::string(key); };
  for (const TomlValue& member : members) {
    if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
    const std::string what = name.empty()
                                 ? "unknown section or key " + toml_string(member.key)
                                 : "unknown key " + toml_string(member.key) + " in [" + name + "]";
    throw Error(member.key_where + ": " + what + "; expected one of " + listed(keys, plain) +
                suggestion(member.key, keys));
  }
}

void TomlTable::require(std::initializer_list<std::string_view> keys) const {
  for (const std::string_view key : keys) {
    if (has(key)) continue;
    if (name.empty()) throw Error(where + ": there is no [" + std::string(key) + "]; add it");
    throw Error(where + ": [" + name + "] has no " + std::string(key) + "; add it");
  }
}

const TomlValue* TomlTable::find(std::string_view key) const {
  const auto member = std::find_if(members.begin(), members.end(),
                                   [&](const TomlValue& value) { return value.key == key; });
  return member == members.end() ? nullptr : &*member;
}

std::optional<bool> TomlTable::boolean(std::string_view key) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  if (const auto* flag = std::get_if<bool>(&value->value)) return *flag;
  fail_at(*value, "true or false");
}

std::optional<std::int64_t> TomlTable::integer(std::string_view key, std::int64_t lo,
                                               std::int64_t hi) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  return whole_number_of(*value, lo, hi);
}

std::optional<double> TomlTable::number(std::string_view key, Range range) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  return number_of(*value, range);
}

std::optional<std::string> TomlTable::string(std::string_view key) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&value->value)) return *text;
  fail_at(*value, "a string in quotes");
}

std::optional<std::string> TomlTable::word(std::string_view key,
                                           const std::vector<std::string_view>& words) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  const auto* text = std::get_if<std::string>(&value->value);
  if (text && std::find(words.begin(), words.end(), *text) != words.end()) return *text;
  fail_at(*value, listed(words, toml_string) + (text ? suggestion(*text, words) : ""));
}

std::optional<std::vector<double>> TomlTable::numbers(std::string_view key,
                                                      std::initializer_list<std::size_t> counts,
                                                      Range range) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  return numbers_of(*value, counts, range);
}

std::optional<std::vector<std::vector<double>>> TomlTable::rows(std::string_view key,
                                                                std::size_t width,
                                                                Range range) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  const auto* array = std::get_if<TomlArray>(&value->value);
  if (!array || array->empty() || !std::holds_alternative<TomlArray>(array->front().value)) {
    return std::vector<std::vector<double>>{numbers_of(*value, {width}, range)};
  }
  std::vector<std::vector<double>> result;
  for (const TomlValue& row : *array) result.push_back(numbers_of(row, {width}, range));
  return result;
}

std::optional<std::vector<std::int64_t>> TomlTable::integers(
    std::string_view key, std::initializer_list<std::size_t> counts, std::int64_t lo,
    std::int64_t hi) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  std::vector<std::int64_t> result;
  for (const TomlValue& item : array_of(*value, counts, "whole numbers")) {
    result.push_back(whole_number_of(item, lo, hi));
  }
  return result;
}

std::optional<Vec3d> TomlTable::vector(std::string_view key, Range range) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  return vector_of(*value, range);
}

std::optional<Vec3d> TomlTable::direction(std::string_view key) const {
  const std::optional<Vec3d> result = vector(key);
  if (result && *result == Vec3d{}) fail(key, "a direction that is not zero");
  return result;
}

std::optional<Vec3d> TomlTable::number_or_vector(std::string_view key, Range range) const {
  const TomlValue* value = find(key);
  if (!value) return std::nullopt;
  if (const auto* array = std::get_if<TomlArray>(&value->value)) {
    if (array->size() == 3) return vector_of(*value, range);
    fail_at(*value, number_text(range) + ", or an array of 3 of them");
  }
  return Vec3d(number_of(*value, range));
}

std::optional<Rgb> TomlTable::rgb(std::string_view key, Range range) const {
  const std::optional<Vec3d> colour = number_or_vector(key, range);
  if (!colour) return std::nullopt;
  return Rgb(*colour);
}

const TomlTable* TomlTable::table(std::string_view key) const {
  const TomlValue* value = find(key);
  if (!value) return nullptr;
  if (const auto* result = std::get_if<TomlTable>(&value->value)) return result;
  fail_at(*value, "a table [" + value->name + "]");
}

std::vector<const TomlTable*> TomlTable::tables(std::string_view key) const {
  const TomlValue* value = find(key);
  if (!value) return {};
  if (const auto* single = std::get_if<TomlTable>(&value->value)) return {single};
  const std::string expected = "a table [" + value->name + "] or tables [[" + value->name + "]]";
  const auto* array = std::get_if<TomlArray>(&value->value);
  if (!array) fail_at(*value, expected);
  std::vector<const TomlTable*> result;
  for (const TomlValue& item : *array) {
    result.push_back(std::get_if<TomlTable>(&item.value));
    if (!result.back()) fail_at(item, "a table");
  }
  return result;
}

void TomlTable::fail(std::string_view key, const std::string& expected) const {
  if (const TomlValue* value = find(key)) fail_at(*value, expected);
  throw Error(where + ": " + (name.empty() ? "it" : "[" + name + "]") + " has no " +
              std::string(key) + "; expected " + expected);
}

std::string toml_number(double value) {
  const std::string text = shortest(value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;  // "n": nan and inf
}

std::string toml_number(float value) {
  const std::string text = shortest(value);
  double read = 0;
  std::from_chars(text.data(), text.data() + text.size(), read);
  // A short text can lie so near the middle of two floats that its double rounds to the other one.
  if (float(read) != value && std::isfinite(value)) return toml_number(double(value));
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string toml_string(std::string_view text) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += std::string("\\") + c;
    } else if (byte < 0x20 || byte == 0x7f) {  // control characters
      result += std::string("\\u00") + kHex[byte >> 4] + kHex[byte & 15];
    } else {
      result += c;
    }
  }
  return result + "\"";
}

}  // namespace pvol::formats
