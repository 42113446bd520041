#include "toml/read_keys.h"

#include <fmt/format.h>

namespace pvol::formats {

std::vector<std::string_view> key_names(const Entries& entries) {
  std::vector<std::string_view> names;
  for (const Entry& e : entries) {
    if (e.about.in_scenes) names.emplace_back(e.about.key);
  }
  return names;
}

void read_keys(const TomlTable& table, const Entries& entries,
               const std::vector<std::string_view>& allowed) {
  table.allow_only(allowed);
  for (const Entry& e : entries) {
    const Description& about = e.about;
    if (!table.has(about.key)) {
      if (!about.required) continue;
      if (about.limits.shape == Limits::Shape::file) table.fail(about.key, expected(about.limits));
      table.require({about.key});
    }
    e.assign(*table.take(about.key, about.limits));
  }
  for (const Entry& e : entries) {
    const Description& about = e.about;
    if (*about.goes_with == 0 || !table.has(about.key)) continue;
    if (find_key(entries, about.goes_with)->value() == Value(about.of_value)) continue;
    table.fail(about.key, fmt::format("{} = \"{}\" beside it", about.goes_with, about.of_value));
  }
}
void read_keys(const TomlTable& table, const Entries& entries) {
  read_keys(table, entries, key_names(entries));
}

void refuse_misfit(const TomlTable& table, const std::optional<Misfit>& misfit) {
  if (!misfit) return;
  for (const char* key : misfit->keys) {
    if (table.has(key)) table.fail(key, misfit->expected);
  }
  table.fail(misfit->keys.front(), misfit->expected);
}

bool is_set(const TomlValue& member) { return member.key_where.starts_with("--set "); }
bool is_set(const TomlTable& table, std::string_view key) {
  const TomlValue* found = table.find(key);
  return found != nullptr && is_set(*found);
}

}  // namespace pvol::formats
