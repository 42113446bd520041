#include "toml/toml_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "pvol/error.h"
#include "pvol/math/nearest_word.h"

namespace pvol::formats {
namespace {

constexpr std::size_t kShownText = 60;  // characters of a found string
constexpr std::size_t kShownItems = 4;  // of a found array

[[noreturn]] void fail_at(const TomlValue& value, const std::string& expected) {
  throw Error(
      fmt::format("{}: {} is {}; expected {}", value.where, value.name, value.text(), expected));
}

/// What other programs call some of our keys; the first of ours that is expected counts.
struct OtherName {
  std::string_view theirs, ours;
};
constexpr OtherName kOtherNames[] = {
    {"lens", "focal_length"},   {"color", "irradiance"},      {"color", "intensity"},
    {"color", "radiance"},      {"color", "albedo"},          {"colour", "irradiance"},
    {"colour", "intensity"},    {"colour", "radiance"},       {"colour", "albedo"},
    {"energy", "irradiance"},   {"energy", "intensity"},      {"strength", "irradiance"},
    {"strength", "radiance"},   {"strength", "intensity"},    {"anisotropy", "g"},
    {"samples", "spp"},         {"resolution", "size"},       {"rotation", "rotate"},
    {"location", "translate"},  {"translation", "translate"}, {"position", "translate"},
    {"radiance", "irradiance"}, {"look_at", "target"},        {"aperture", "f_stop"},
};

/// '; did you mean "fov"?', by spelling or by kOtherNames; or nothing.
std::string suggestion(std::string_view key, const std::vector<std::string_view>& words) {
  if (const auto nearest = nearest_word(key, words)) {
    return "; did you mean " + toml_string(*nearest) + "?";
  }
  for (const OtherName& name : kOtherNames) {
    if (name.theirs != key || std::ranges::find(words, name.ours) == words.end()) continue;
    return "; did you mean " + toml_string(name.ours) + "?";
  }
  return "";
}

/// The value without its place; nothing for a table, which no key takes, and for a date.
Value plain(const TomlValue& value) {
  struct Plain {
    Value operator()(bool v) const { return v; }
    Value operator()(std::int64_t v) const { return v; }
    Value operator()(double v) const { return v; }
    Value operator()(const std::string& v) const { return v; }
    Value operator()(const TomlDate&) const { return {}; }
    Value operator()(const TomlTable&) const { return {}; }
    Value operator()(const TomlArray& v) const {
      Value::List items;
      for (const TomlValue& item : v) items.push_back(plain(item));
      return items;
    }
  };
  return std::visit(Plain{}, value.value);
}

[[noreturn]] void fail_at(const TomlValue& value, const Refusal& refusal, const Limits& limits) {
  const TomlValue* found = &value;
  for (const std::size_t i : refusal.item) found = &std::get<TomlArray>(found->value)[i];
  const auto* text = std::get_if<std::string>(&found->value);
  fail_at(*found, refusal.expected + (text ? suggestion(*text, limits.all_words()) : ""));
}

std::vector<double> numbers_of(const Value& list) {
  std::vector<double> all;
  for (const Value& item : *list.list()) all.push_back(*item.number());
  return all;
}

std::optional<Vec3d> vector_of(const std::optional<Value>& value) {
  std::optional<Vec3d> v;
  if (value) assign(v.emplace(), *value);
  return v;
}

}  // namespace

std::string TomlValue::text() const {
  struct Shown {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return fmt::to_string(v); }
    std::string operator()(double v) const { return toml_number(v); }
    std::string operator()(const std::string& v) const {
      return v.size() <= kShownText ? toml_string(v) : toml_string(v.substr(0, kShownText)) + "...";
    }
    std::string operator()(const TomlDate&) const { return "a date or time"; }
    std::string operator()(const TomlArray& v) const {
      if (v.size() > kShownItems) return fmt::format("an array of {}", v.size());
      std::vector<std::string> items;
      for (const auto& item : v) items.push_back(item.text());
      return fmt::format("[{}]", fmt::join(items, ", "));
    }
    std::string operator()(const TomlTable&) const { return "a table"; }
  };
  return std::visit(Shown{}, value);
}

void TomlTable::allow_only(const std::vector<std::string_view>& keys) const {
  for (const TomlValue& member : members) {
    if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
    const std::string quoted = toml_string(member.key);
    const std::string what = name.empty() ? "unknown section or key " + quoted
                                          : fmt::format("unknown key {} in [{}]", quoted, name);
    throw Error(fmt::format("{}: {}; expected one of {}{}", member.key_where, what,
                            listed({keys.begin(), keys.end()}), suggestion(member.key, keys)));
  }
}

void TomlTable::require(const std::vector<std::string_view>& keys) const {
  for (const std::string_view key : keys) {
    if (has(key)) continue;
    if (name.empty()) throw Error(fmt::format("{}: there is no [{}]; add it", where, key));
    throw Error(fmt::format("{}: [{}] has no {}; add it", where, name, key));
  }
}

const TomlValue* TomlTable::find(std::string_view key) const {
  const auto member = std::find_if(members.begin(), members.end(),
                                   [&](const TomlValue& value) { return value.key == key; });
  return member == members.end() ? nullptr : &*member;
}

std::optional<Value> TomlTable::take(std::string_view key, const Limits& limits) const {
  const TomlValue* found = find(key);
  if (!found) return std::nullopt;
  const auto* date = std::get_if<TomlDate>(&found->value);
  const bool as_text = date != nullptr && limits.shape == Limits::Shape::text;
  Value value = as_text ? Value(date->text) : plain(*found);
  if (const auto refusal = refuse(limits, value)) fail_at(*found, *refusal, limits);
  return value;
}

std::optional<std::int64_t> TomlTable::integer(std::string_view key, std::int64_t lo,
                                               std::int64_t hi) const {
  const auto value = take(key, whole(lo, hi));
  return value ? value->whole() : std::nullopt;
}

std::optional<double> TomlTable::number(std::string_view key, Range range) const {
  const auto value = take(key, pvol::number(range));
  return value ? value->number() : std::nullopt;
}

std::optional<std::string> TomlTable::string(std::string_view key) const {
  const auto value = take(key, any_text());
  return value ? std::optional(*value->word()) : std::nullopt;
}

std::optional<std::string> TomlTable::word(std::string_view key,
                                           const std::vector<std::string_view>& words) const {
  const auto value = take(key, {.words = words});
  return value ? std::optional(*value->word()) : std::nullopt;
}

std::optional<std::vector<double>> TomlTable::numbers(std::string_view key,
                                                      std::size_t count) const {
  const auto value = take(key, pvol::number().times(count));
  return value ? std::optional(numbers_of(*value)) : std::nullopt;
}

std::optional<std::vector<std::vector<double>>> TomlTable::rows(std::string_view key,
                                                                std::size_t width) const {
  const auto value = take(key, pvol::number().times(width).in_rows());
  if (!value) return std::nullopt;
  std::vector<std::vector<double>> result;
  if (!value->list()->front().list()) {
    result.push_back(numbers_of(*value));
    return result;
  }
  for (const Value& row : *value->list()) result.push_back(numbers_of(row));
  return result;
}

std::optional<Vec3d> TomlTable::vector(std::string_view key) const {
  return vector_of(take(key, pvol::number().times(3)));
}

std::optional<Vec3d> TomlTable::direction(std::string_view key) const {
  return vector_of(take(key, pvol::direction()));
}

std::optional<Vec3d> TomlTable::number_or_vector(std::string_view key, Range range) const {
  return vector_of(take(key, pvol::number(range).or_three()));
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
  throw Error(fmt::format("{}: {} has no {}; expected {}", where,
                          name.empty() ? "it" : "[" + name + "]", key, expected));
}

std::string toml_number(double value) {
  const std::string text = number_text(value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;  // "n": nan and inf
}

std::string toml_number(float value) {
  const std::string text = number_text(value);
  double read = 0;
  std::from_chars(text.data(), text.data() + text.size(), read);
  // A short text can lie so near the middle of two floats that its double rounds to the other one.
  if (float(read) != value && std::isfinite(value)) return toml_number(double(value));
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else if (byte < 0x20 || byte == 0x7f) {  // control characters
      result += fmt::format("\\u{:04X}", byte);
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string toml_text(const Value& value) {
  struct Text {
    std::string operator()(std::monostate) const { return "\"\""; }
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return fmt::to_string(v); }
    std::string operator()(double v) const { return toml_number(v); }
    std::string operator()(float v) const { return toml_number(v); }
    std::string operator()(const std::string& v) const { return toml_string(v); }
    std::string operator()(const Value::List& v) const {
      std::vector<std::string> items;
      for (const Value& item : v) items.push_back(toml_text(item));
      return fmt::format("[{}]", fmt::join(items, ", "));
    }
  };
  return std::visit(Text{}, value.data);
}

}  // namespace pvol::formats
