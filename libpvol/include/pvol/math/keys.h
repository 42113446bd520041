// What users can set, described once: a table of rows for each struct, from which scene files,
// command lines, their help, reports, manuals and studies follow.
//
//   struct Fog {
//     double thickness = 1;
//     Kind kind = Kind::dry;             // an enumeration with names, see names.h
//   };
//   template <std::same_as<Fog> F>       // a template so that only who asks for it compiles it
//   constexpr auto keys(const F&) {
//     return std::to_array<Key<F>>({
//         key<&F::thickness>({.key = "thickness", .metavar = "X", .limits =
//         number(Range::above(0)),
//                               .help = "Thickness in world units"}),
//         key<&F::kind>({.key = "kind", .help = "What it is made of"}),
//     });
//   }
//
// A row for more than one member, or for one that is not plain, has functions of its own instead
// (`size` in render/options.h). A member of a closed set of kinds brings the keys of its kind
// (`phase` in volume/medium.h).
#pragma once

#include <concepts>
#include <functional>
#include <type_traits>

#include "pvol/math/limits.h"

namespace pvol {

/// What a key does to pictures.
enum class Effect {
  picture,  ///< its value says what the picture shows
  cost,     ///< the same picture on average, in another time or with other noise
  field,    ///< another field, and so another picture: no error, but not the same
  bias,     ///< every value but the default makes pictures biased
};

/// The description of a key, whatever it belongs to.
struct Description {
  const char* key;             ///< in scene files; the flag of micro_bounds is --micro-bounds
  const char* metavar = "";    ///< stands for the value in help; of words see metavar_of
  Limits limits{};             ///< names and true or false follow from the member's type
  const char* help = "";       ///< a sentence without its full stop, with the unit
  const char* otherwise = "";  ///< the default as help puts it, where its value would not tell
  Effect effect = Effect::picture;
  bool required = false;       ///< in a section of a scene
  bool in_scenes = true;       ///< false: no picture depends on it, so scenes do not have it
  const char* goes_with = "";  ///< another key, to which this one adds; "" is none
  const char* of_value = "";   ///< ... and the value that the other one must have
  const char* factor = "";     ///< what a study of trade-offs calls it; "" is left out of them
  const char* sweep = "";      ///< values for it, as on the command line, with blanks between
};

/// --micro-bounds.
[[nodiscard]] std::string flag_of(const Description& about);

/// The row's own, or of a few short words "auto|on|off", of others "NAME", of sets "NAME,...".
[[nodiscard]] std::string metavar_of(const Description& about);

/// A row bound to a thing: reading and writing it take no more than this.
struct Entry {
  Description about;
  std::function<Value()> get;                ///< nothing where there is nothing to write
  std::function<void(const Value&)> assign;  ///< of what the limits allow; empty for constants

  /// The value, or the word for none.
  [[nodiscard]] Value value() const;
  /// Sets what the limits allow; for all else says what was expected and changes nothing.
  [[nodiscard]] std::optional<Refusal> set(const Value& value) const;
};
using Entries = std::vector<Entry>;

/// The help with the words, or ends of the range, that the metavar does not show, and the default
/// in brackets: "Deepest octree level (0 to 23) [auto: no limit]". The entry is that of
/// a thing with its defaults.
[[nodiscard]] std::string help_of(const Entry& entry);

/// A row of the table of T.
template <class T>
struct Key {
  Description about;
  Value (*get)(const T&) = nullptr;
  void (*set)(T&, const Value&) = nullptr;
  Entries (*inside)(T&) = nullptr;  ///< in place of the rest: entries of a part
  Entries (*inside_constant)(const T&) = nullptr;
};

namespace detail {
template <class T, class M>
T owner_of(M T::*);
template <class T, class M>
M member_of(M T::*);
template <class M>
inline constexpr bool kIsSet = false;
template <class Enum>
inline constexpr bool kIsSet<SetOf<Enum>> = true;
}  // namespace detail

/// The row of a plain member.
template <auto kMember>
[[nodiscard]] constexpr auto key(Description about) {
  using T = decltype(detail::owner_of(kMember));
  using M = decltype(detail::member_of(kMember));
  if constexpr (HasNames<M>) about.limits.words = kWords<M>;
  if constexpr (detail::kIsSet<M>) about.limits = set_of<typename M::Item>().or_word("none");
  if constexpr (std::is_same_v<M, bool>) about.limits = flag();
  return Key<T>{about, [](const T& t) { return to_value(t.*kMember); },
                [](T& t, const Value& v) { assign(t.*kMember, v); }};
}

/// A row that stands for the keys of a member's kind, see `entries` of a variant.
template <auto kMember>
[[nodiscard]] constexpr auto keys_of_kind() {
  using T = decltype(detail::owner_of(kMember));
  const auto inside = [](auto& t) { return entries(t.*kMember); };
  return Key<T>{{.key = ""}, nullptr, nullptr, inside, inside};
}

/// The rows of a thing, bound to it. It must outlive them and stay where it is.
template <class T>
[[nodiscard]] Entries entries(T& thing) {
  Entries all;
  for (const Key<std::remove_const_t<T>>& row : keys(std::as_const(thing))) {
    if (row.inside) {
      Entries part;
      if constexpr (std::is_const_v<T>) {
        part = row.inside_constant(thing);
      } else {
        part = row.inside(thing);
      }
      all.insert(all.end(), part.begin(), part.end());
      continue;
    }
    Entry& e =
        all.emplace_back(Entry{row.about, [&thing, get = row.get] { return get(thing); }, {}});
    if constexpr (!std::is_const_v<T>) {
      e.assign = [&thing, set = row.set](const Value& v) { set(thing, v); };
    }
  }
  return all;
}

// Closed sets of kinds are variants. Each kind has a name, `static constexpr const char* kName`,
// and rows of its own; where no name is given, a kind is known by the first of its keys.

/// The rows of the kind that it is.
template <class... Kinds>
[[nodiscard]] Entries entries(std::variant<Kinds...>& thing) {
  return std::visit([](auto& kind) { return entries(kind); }, thing);
}
template <class... Kinds>
[[nodiscard]] Entries entries(const std::variant<Kinds...>& thing) {
  return std::visit([](const auto& kind) { return entries(kind); }, thing);
}

template <class... Kinds>
[[nodiscard]] const char* kind_name(const std::variant<Kinds...>& thing) {
  return std::visit([](const auto& kind) { return std::decay_t<decltype(kind)>::kName; }, thing);
}

/// One of each kind, with its defaults.
template <class Variant>
[[nodiscard]] std::vector<Variant> all_kinds() {
  return []<class... Kinds>(std::type_identity<std::variant<Kinds...>>) {
    return std::vector<Variant>{Kinds{}...};
  }(std::type_identity<Variant>{});
}

/// The entry of a key, or null.
[[nodiscard]] const Entry* find_key(const Entries& all, std::string_view key);
/// Those of `all` but this one.
[[nodiscard]] Entries without(Entries all, std::string_view key);
/// Those of `a`, then those of `b`.
[[nodiscard]] Entries joined(Entries a, const Entries& b);

/// Throws Error for the first value out of its limits, in the name of `what`.
void require_limits(const std::string& what, const Entries& all);

/// Values that are right by themselves, but not together: what was expected of one of the keys. To
/// blame is the first of them that was given.
struct Misfit {
  std::vector<const char*> keys;
  std::string expected;
};

}  // namespace pvol
