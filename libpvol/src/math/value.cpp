#include "pvol/math/value.h"

#include <array>
#include <charconv>
#include <limits>

#include "pvol/error.h"

namespace pvol {
namespace {

template <class T>
std::string shortest(T value) {
  std::array<char, 64> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

}  // namespace

std::optional<std::int64_t> Value::whole() const {
  const auto* v = std::get_if<std::int64_t>(&data);
  return v ? std::optional(*v) : std::nullopt;
}

std::optional<double> Value::number() const {
  if (const auto* v = std::get_if<double>(&data)) return *v;
  if (const auto* v = std::get_if<float>(&data)) return double(*v);
  if (const auto* v = std::get_if<std::int64_t>(&data)) return double(*v);
  return std::nullopt;
}

std::string number_text(double value) { return shortest(value); }
std::string number_text(float value) { return shortest(value); }

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 < items.size() ? ", " : " or ";
    text += items[i];
  }
  return text;
}

std::string plain_text(const Value& value, char separator) {
  struct Shown {
    char separator;
    std::string operator()(std::monostate) const { return ""; }
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return shortest(v); }
    std::string operator()(double v) const { return shortest(v); }
    std::string operator()(float v) const { return shortest(v); }
    std::string operator()(const std::string& v) const { return v; }
    std::string operator()(const Value::List& v) const {
      std::string text;
      for (const Value& item : v) {
        if (&item != &v.front()) text += separator;
        text += plain_text(item);
      }
      return text;
    }
  };
  return std::visit(Shown{separator}, value.data);
}

Value to_value(std::uint64_t v) {
  if (v <= std::uint64_t(std::numeric_limits<std::int64_t>::max())) return std::int64_t(v);
  throw Error(std::to_string(v) + " is too large to be written; expected a number below 2^63");
}

}  // namespace pvol
