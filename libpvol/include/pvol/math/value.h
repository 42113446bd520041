// A value as users write it, apart from any syntax: what scene files, command lines and reports
// exchange with the tables of keys.h.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pvol/math/names.h"
#include "pvol/math/vec.h"

namespace pvol {

struct Value {
  using List = std::vector<Value>;
  /// Nothing at all is an optional value that is absent; no key takes it. A float is told from a
  /// double so that it is printed in as few digits as bring it back.
  std::variant<std::monostate, bool, std::int64_t, double, float, std::string, List> data;

  Value() = default;
  Value(bool v) : data(v) {}
  Value(std::int64_t v) : data(v) {}
  Value(double v) : data(v) {}
  Value(float v) : data(v) {}
  Value(std::string v) : data(std::move(v)) {}
  Value(const char* v) : data(std::string(v)) {}
  Value(List v) : data(std::move(v)) {}
  friend bool operator==(const Value&, const Value&) = default;

  [[nodiscard]] bool nothing() const { return std::holds_alternative<std::monostate>(data); }
  [[nodiscard]] const std::string* word() const { return std::get_if<std::string>(&data); }
  [[nodiscard]] const List* list() const { return std::get_if<List>(&data); }
  [[nodiscard]] std::optional<std::int64_t> whole() const;
  [[nodiscard]] std::optional<double> number() const;  ///< whole numbers are numbers, too
};

/// The shortest decimals that read back as the same number.
[[nodiscard]] std::string number_text(double value);
[[nodiscard]] std::string number_text(float value);

/// "a, b or c".
[[nodiscard]] std::string listed(const std::vector<std::string>& items);

/// As messages and the command line show it: 200, fog, 640x480 with the separator 'x'.
[[nodiscard]] std::string plain_text(const Value& value, char separator = ',');

// From members of structs to values, and back.

[[nodiscard]] inline Value to_value(bool v) { return v; }
[[nodiscard]] inline Value to_value(double v) { return v; }
[[nodiscard]] inline Value to_value(float v) { return v; }
[[nodiscard]] inline Value to_value(const std::string& v) { return v; }
[[nodiscard]] inline Value to_value(std::int64_t v) { return v; }
[[nodiscard]] inline Value to_value(int v) { return std::int64_t(v); }
[[nodiscard]] inline Value to_value(std::uint32_t v) { return std::int64_t(v); }
/// Throws Error for a number of 2^63 or more, which neither a scene nor JSON can hold.
[[nodiscard]] Value to_value(std::uint64_t v);
template <HasNames Enum>
[[nodiscard]] Value to_value(Enum v) {
  return name(v);
}
/// Nothing for none; else the names in their order.
template <HasNames Enum>
[[nodiscard]] Value to_value(SetOf<Enum> v) {
  if (v.empty()) return {};
  Value::List list;
  for (const Named<Enum>& n : names(Enum{})) {
    if (v.has(n.value)) list.emplace_back(n.name);
  }
  return list;
}
template <class T>
[[nodiscard]] Value to_value(const Vec3<T>& v) {
  return Value::List{v.x, v.y, v.z};
}
template <class T>
[[nodiscard]] Value to_value(const std::optional<T>& v) {
  return v ? to_value(*v) : Value{};
}

/// `v` is one that the member's limits allow (limits.h): its shape is not checked again.
inline void assign(bool& to, const Value& v) { to = std::get<bool>(v.data); }
inline void assign(std::string& to, const Value& v) { to = *v.word(); }
template <class T>
requires std::integral<T> || std::floating_point<T>
void assign(T& to, const Value& v) {
  if constexpr (std::integral<T>) {
    to = T(*v.whole());
  } else {
    to = T(*v.number());
  }
}
template <HasNames Enum>
void assign(Enum& to, const Value& v) {
  to = *find_named<Enum>(*v.word());
}
/// One name, a list of them, or another word for none.
template <HasNames Enum>
void assign(SetOf<Enum>& to, const Value& v) {
  to = {};
  for (const Value& item : v.list() ? *v.list() : Value::List{v}) {
    if (const auto found = find_named<Enum>(*item.word())) to.add(*found);
  }
}
/// One number counts for all three.
template <class T>
void assign(Vec3<T>& to, const Value& v) {
  const Value::List* list = v.list();
  to = list ? Vec3<T>(T(*(*list)[0].number()), T(*(*list)[1].number()), T(*(*list)[2].number()))
            : Vec3<T>(T(*v.number()));
}
/// A word stands for nothing.
template <class T>
void assign(std::optional<T>& to, const Value& v) {
  to.reset();
  if (!v.word()) assign(to.emplace(), v);
}

}  // namespace pvol
