// Names of enumerations, as users write them: each stands once, beside its enumeration.
//
//   enum class Fruit { apple, pear };
//   constexpr auto names(Fruit) {
//     return std::to_array<Named<Fruit>>({{Fruit::apple, "apple"}, {Fruit::pear, "pear"}});
//   }
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

namespace pvol {

template <class Enum>
struct Named {
  Enum value;
  const char* name;
};

template <class Enum>
concept HasNames = requires(Enum value) {
  names(value);
};

template <HasNames Enum>
[[nodiscard]] constexpr const char* name(Enum value) {
  for (const Named<Enum>& n : names(value)) {
    if (n.value == value) return n.name;
  }
  return "";
}

/// The value of a name; nothing for one that is unknown.
template <HasNames Enum>
[[nodiscard]] constexpr std::optional<Enum> find_named(std::string_view text) {
  for (const Named<Enum>& n : names(Enum{})) {
    if (n.name == text) return n.value;
  }
  return std::nullopt;
}

/// All names, in their order.
template <HasNames Enum>
[[nodiscard]] std::vector<std::string_view> all_names() {
  std::vector<std::string_view> all;
  for (const Named<Enum>& n : names(Enum{})) all.emplace_back(n.name);
  return all;
}

/// Some of an enumeration's values, of which there are at most 32.
template <HasNames Enum>
class SetOf {
 public:
  using Item = Enum;
  constexpr SetOf() = default;
  constexpr SetOf(std::initializer_list<Enum> values) {
    for (const Enum v : values) add(v);
  }
  [[nodiscard]] static constexpr SetOf all() {
    SetOf s;
    for (const Named<Enum>& n : names(Enum{})) s.add(n.value);
    return s;
  }

  constexpr void add(Enum v) { bits_ |= bit(v); }
  constexpr void add(SetOf others) { bits_ |= others.bits_; }
  constexpr void remove(Enum v) { bits_ &= ~bit(v); }
  [[nodiscard]] constexpr bool has(Enum v) const { return (bits_ & bit(v)) != 0; }
  [[nodiscard]] constexpr bool empty() const { return bits_ == 0; }
  friend constexpr bool operator==(SetOf, SetOf) = default;

 private:
  [[nodiscard]] static constexpr std::uint32_t bit(Enum v) { return std::uint32_t{1} << int(v); }
  std::uint32_t bits_ = 0;
};

}  // namespace pvol
