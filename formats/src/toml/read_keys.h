// Sections of a scene by the tables of their keys: what is there is checked and set.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "pvol/formats/scene_file.h"
#include "toml/toml_table.h"

namespace pvol::formats {

/// Those that scenes may have.
[[nodiscard]] std::vector<std::string_view> key_names(const Entries& entries);

/// Sets what the table has of these keys. Throws Error, with the place and what is expected, for
/// values out of range, for required keys that are missing, and for keys that are not `allowed`,
/// which by default are those of the entries.
void read_keys(const TomlTable& table, const Entries& entries,
               const std::vector<std::string_view>& allowed);
void read_keys(const TomlTable& table, const Entries& entries);

/// Throws Error, if there is a misfit, and blames the first of its keys that the table has.
void refuse_misfit(const TomlTable& table, const std::optional<Misfit>& misfit);

/// Whether it comes from the command line's --set.
[[nodiscard]] bool is_set(const TomlValue& member);
[[nodiscard]] bool is_set(const TomlTable& table, std::string_view key);

/// Of a closed set the kind whose first key is there, where there is one: first of those that the
/// command line set.
template <class Variant>
void choose_kind(const TomlTable& table, Variant& thing) {
  for (const bool by_set : {true, false}) {
    for (Variant& kind : all_kinds<Variant>()) {
      const char* const key = entries(kind).front().about.key;
      if (by_set ? !is_set(table, key) : !table.has(key)) continue;
      thing = std::move(kind);
      return;
    }
  }
}

/// Without the keys of the file that belong to another kind, where the command line chose one by
/// `key`.
template <class Variant>
[[nodiscard]] TomlTable of_chosen_kind(TomlTable table, std::string_view key,
                                       const std::vector<std::string_view>& allowed) {
  if (!is_set(table, key)) return table;
  std::vector<Variant> kinds = all_kinds<Variant>();
  const auto is_known = [&](const std::string& name) {
    return std::ranges::any_of(
        kinds, [&](Variant& kind) { return find_key(entries(kind), name) != nullptr; });
  };
  std::erase_if(table.members, [&](const TomlValue& m) {
    return !is_set(m) && is_known(m.key) &&
           std::ranges::find(allowed, std::string_view(m.key)) == allowed.end();
  });
  return table;
}

}  // namespace pvol::formats
