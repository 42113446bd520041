#include "pvol/math/limits.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "math/digits.h"

namespace pvol {
namespace {

using Shape = Limits::Shape;
using Layout = Limits::Layout;

/// "a whole number in 1..8"; "" for words alone.
std::string shape_text(const Limits& l) {
  switch (l.shape) {
    case Shape::flag:
      return "true or false";
    case Shape::whole:
      return "a whole number in " + std::to_string(l.least) + ".." + std::to_string(l.most);
    case Shape::number:
      return l.range.text().empty() ? "a finite number" : "a number " + l.range.text();
    case Shape::text:
      return "a string in quotes";
    case Shape::file:
      return "the name of a file";
    case Shape::word:
      break;
  }
  return "";
}

std::string one_text(const Limits& l) {
  std::vector<std::string> items;
  if (l.shape != Shape::word) items.push_back(shape_text(l));
  for (const std::string_view w : l.all_words()) items.push_back('"' + std::string(w) + '"');
  return listed(items);
}

/// What was expected in place of one that is refused.
std::string text_against(const Limits& l, const Value& v) {
  const std::string text = one_text(l);
  constexpr std::string_view kNumber = "a number ";
  const bool ends = std::isfinite(l.range.lo) && std::isfinite(l.range.hi);
  if (ends || !v.number() || std::isfinite(*v.number()) || !text.starts_with(kNumber)) return text;
  return "a finite number " + text.substr(kNumber.size());
}

std::string numbers_text(const Limits& l) {
  std::vector<std::string> lengths;
  for (const std::size_t n : l.counts) {
    if (n > 0) lengths.push_back(std::to_string(n));
  }
  return listed(lengths) + (l.shape == Shape::whole ? " whole numbers" : " numbers");
}

std::string list_text(const Limits& l) { return "an array of " + numbers_text(l); }

bool has_word(const Limits& l, const std::string& text) {
  return (!l.nothing.empty() && text == l.nothing) ||
         std::find(l.words.begin(), l.words.end(), text) != l.words.end();
}

bool is_one(const Limits& l, const Value& v) {
  if (const std::string* text = v.word()) {
    return has_word(l, *text) || l.shape == Shape::text ||
           (l.shape == Shape::file && !text->empty());
  }
  switch (l.shape) {
    case Shape::flag:
      return std::holds_alternative<bool>(v.data);
    case Shape::whole:
      return v.whole() && *v.whole() >= l.least && *v.whole() <= l.most;
    case Shape::number:
      return v.number() && l.range.contains(*v.number());
    default:
      return false;
  }
}

bool is_list(const Limits& l, const Value& v) {
  return v.list() && !v.list()->empty() &&
         std::find(l.counts.begin(), l.counts.end(), v.list()->size()) != l.counts.end();
}

std::optional<Refusal> refuse_list(const Limits& l, const Value& v) {
  if (!is_list(l, v)) return Refusal{list_text(l)};
  for (std::size_t i = 0; i < v.list()->size(); ++i) {
    if (!is_one(l, (*v.list())[i])) return Refusal{text_against(l, (*v.list())[i]), {i}};
  }
  return std::nullopt;
}

/// Items of a set are of the same kind as one alone, but for the word for nothing.
std::optional<Refusal> refuse_items(Limits l, const Value::List& items) {
  l.nothing = {};
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!is_one(l, items[i])) return Refusal{one_text(l), {i}};
  }
  return std::nullopt;
}

std::optional<Refusal> refuse_rows(const Limits& l, const Value& v) {
  const Value::List* rows = v.list();
  if (!rows || rows->empty() || !rows->front().list()) return refuse_list(l, v);
  for (std::size_t i = 0; i < rows->size(); ++i) {
    if (auto refusal = refuse_list(l, (*rows)[i])) {
      refusal->item.insert(refusal->item.begin(), i);
      return refusal;
    }
  }
  return std::nullopt;
}

std::optional<Refusal> refuse_shape(const Limits& l, const Value& v) {
  switch (l.layout) {
    case Layout::list:
      return refuse_list(l, v);
    case Layout::list_or_rows:
      return refuse_rows(l, v);
    case Layout::one_or_three:
      if (is_list(l, v)) return refuse_list(l, v);
      if (v.list()) return Refusal{expected(l)};
      break;
    case Layout::set:
      if (v.list()) return refuse_items(l, *v.list());
      if (!is_one(l, v)) return Refusal{expected(l)};
      break;
    case Layout::one:
      break;
  }
  if (is_one(l, v)) return std::nullopt;
  return Refusal{v.number() ? text_against(l, v) : expected(l)};
}

/// A whole number, a number, or the text itself.
Value parse_number(std::string_view text) {
  const char* const end = text.data() + text.size();
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  std::int64_t integer = 0;
  const auto as_integer = std::from_chars(begin, end, integer);
  if (as_integer.ec == std::errc{} && as_integer.ptr == end) return integer;
  double real = 0;
  const auto as_real = std::from_chars(begin, end, real);
  if (as_real.ec == std::errc{} && as_real.ptr == end) return real;
  return std::string(text);
}

Value parse_one(const Limits& l, std::string_view text) {
  if (l.shape == Shape::flag && text == "on") return true;
  if (l.shape == Shape::flag && text == "off") return false;
  if (has_word(l, std::string(text))) return std::string(text);
  if (l.shape == Shape::whole) return parse_number(text);
  if (l.shape == Shape::number) {
    const Value value = parse_number(text);
    return value.number() ? Value(*value.number()) : value;
  }
  return std::string(text);
}

}  // namespace

bool Range::contains(double v) const {
  return std::isfinite(v) && (lo_open ? v > lo : v >= lo) && (hi_open ? v < hi : v <= hi);
}

std::string Range::text() const {
  const bool below = std::isfinite(hi), above_ = std::isfinite(lo);
  if (below && above_) {
    return std::string("in ") + (lo_open ? "(" : "[") + number_text(lo) + ", " + number_text(hi) +
           (hi_open ? ")" : "]");
  }
  if (above_) return (lo_open ? "above " : "of at least ") + number_text(lo);
  if (below) return (hi_open ? "below " : "of at most ") + number_text(hi);
  return "";
}

std::vector<std::string_view> Limits::all_words() const {
  std::vector<std::string_view> all(words.begin(), words.end());
  if (!nothing.empty()) all.insert(all.begin(), nothing);
  return all;
}

const char* expect_direction(const Value& v) {
  Vec3d d;
  assign(d, v);
  if (d == Vec3d{}) return "a direction that is not zero";
  return length(d) > 0 && std::isfinite(length(d)) ? nullptr : "a direction whose length is finite";
}

const char* expect_rising(const Value& v) {
  const Value::List& two = *v.list();
  return *two[0].number() < *two[1].number() ? nullptr : "a first number below the second";
}

std::optional<Refusal> refuse(const Limits& limits, const Value& value) {
  if (auto refusal = refuse_shape(limits, value)) return refusal;
  const char* const wanted = limits.extra ? limits.extra(value) : nullptr;
  return wanted ? std::optional(Refusal{wanted}) : std::nullopt;
}

std::string ends_of(const Limits& l) {
  constexpr std::int64_t kTelling = 1 << 16;  // larger ones are what the machine can count to
  const bool single = l.layout == Limits::Layout::one;
  if (single && l.shape == Limits::Shape::whole && l.most <= kTelling) {
    return std::to_string(l.least) + " to " + std::to_string(l.most);
  }
  if (single && l.shape == Limits::Shape::number && std::isfinite(l.range.lo) &&
      std::isfinite(l.range.hi)) {
    return detail::digits(l.range.lo) + " to " + detail::digits(l.range.hi);
  }
  return "";
}

std::string expected(const Limits& limits) {
  switch (limits.layout) {
    case Layout::one:
      return one_text(limits);
    case Layout::list:
      return list_text(limits);
    case Layout::one_or_three:
      return one_text(limits) + ", or an array of 3 of them";
    case Layout::set:
      return one_text(limits) + ", or an array of them";
    case Layout::list_or_rows:
      break;
  }
  return list_text(limits) + ", or several";
}

Value parse_value(const Limits& limits, std::string_view text) {
  if (limits.layout == Layout::one) return parse_one(limits, text);
  const bool one_will_do = limits.layout == Layout::one_or_three || limits.layout == Layout::set;
  if (one_will_do && text.find(limits.separator) == text.npos) return parse_one(limits, text);
  const std::string between = limits.separator == 'x' ? "xX" : std::string(1, limits.separator);
  Value::List items;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(between, begin), text.size());
    items.push_back(parse_one(limits, text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return items;
}

std::string command_expected(const Limits& limits, const Refusal& refusal) {
  const std::vector<std::string_view> words = limits.all_words();
  if (limits.layout == Layout::set) {
    return listed({words.begin(), words.end()}) + ", or several with commas between";
  }
  if (limits.layout == Layout::list && refusal.expected == list_text(limits)) {
    const char between = limits.separator;
    return numbers_text(limits) + " with " + (between == ',' ? "commas" : std::string(1, between)) +
           " between";
  }
  if (limits.layout != Layout::one) return refusal.expected;
  if (limits.shape == Shape::flag) return "on or off";
  if (words.empty()) return refusal.expected;
  std::string text;
  for (const std::string_view w : words) {
    if (!text.empty()) text += " or ";
    text += w;
  }
  return limits.shape == Shape::word ? text : text + " or " + shape_text(limits);
}

std::string command_text(const Limits& limits, const Value& value) {
  if (const auto* on = std::get_if<bool>(&value.data)) return *on ? "on" : "off";
  return plain_text(value, limits.separator);
}

}  // namespace pvol
