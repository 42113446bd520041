// From toml++'s nodes to ours; the only file that sees toml++.
#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <charconv>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "toml/toml_depth.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

constexpr std::uintmax_t kLargestText = std::uintmax_t{64} << 20;  // hand-written text, with room
constexpr std::size_t kLongestPath = 4096;  // of the keys to a value: each value has its name

/// How places in a text are called; `outer` is the place of the table around, for tables that only
/// dotted keys imply and that have no place of their own.
using Place = std::function<std::string(const toml::source_region&, const std::string& outer)>;

TomlTable convert_table(const toml::table& table, std::string name, std::string where,
                        const Place& place);

TomlValue convert(const toml::node& node, std::string name, const std::string& outer,
                  const Place& place) {
  TomlValue value;
  value.where = place(node.source(), outer);
  value.name = std::move(name);
  node.visit([&](const auto& v) {
    using Node = std::decay_t<decltype(v)>;
    if constexpr (toml::is_table<Node>) {
      value.value = convert_table(v, value.name, value.where, place);
    } else if constexpr (toml::is_array<Node>) {
      TomlArray items;
      for (const toml::node& item : v) {
        const std::string item_name = fmt::format("{}[{}]", value.name, items.size() + 1);
        items.push_back(convert(item, item_name, value.where, place));
      }
      value.value = std::move(items);
    } else if constexpr (toml::is_date<Node> || toml::is_time<Node> || toml::is_date_time<Node>) {
      std::ostringstream text;
      text << v;
      value.value = TomlDate{text.str()};
    } else {
      value.value = v.get();
    }
  });
  return value;
}

TomlTable convert_table(const toml::table& table, std::string name, std::string where,
                        const Place& place) {
  TomlTable result{std::move(name), std::move(where), {}};
  for (const auto& [key, node] : table) {
    const std::string key_name =
        (result.name.empty() ? "" : result.name + ".") + std::string(key.str());
    if (key_name.size() > kLongestPath) {
      throw Error(fmt::format("{}: a key of {} bytes, its tables included; expected at most {}",
                              place(key.source(), result.where), key_name.size(), kLongestPath));
    }
    TomlValue value = convert(node, key_name, result.where, place);
    value.key = key.str();
    value.key_where = place(key.source(), result.where);
    result.members.push_back(std::move(value));
  }
  return result;
}

/// Numbers and lists of numbers as TOML wants them: ".1" and "5." with all their digits.
std::string with_all_digits(const std::string& text) {
  constexpr std::string_view kNumeric = "0123456789.+-eE_[], \t";
  if (text.find_first_not_of(kNumeric) != std::string::npos) return text;
  const auto is_digit = [&](std::size_t i) {
    return i < text.size() && text[i] >= '0' && text[i] <= '9';
  };
  std::string full;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '.' && (i == 0 || !is_digit(i - 1))) full += '0';
    full += text[i];
    if (text[i] == '.' && !is_digit(i + 1)) full += '0';
  }
  return full;
}

std::string too_deep() {
  return fmt::format("tables and arrays nest more than {} levels deep; expected fewer",
                     detail::kDeepestToml);
}

/// What is wrong; of names of files with backslashes, and of a section that becomes a list, also
/// what to do.
std::string description(const toml::parse_error& e) {
  std::string text(e.description());
  if (text.find("unicode scalar") != text.npos || text.find("escape sequence") != text.npos) {
    text += "; a backslash between \" begins an escape: write names of files with /, or between '";
  }
  if (text.find("as array-of-tables") != text.npos) {
    text += "; where there are several, the first is in double brackets as well, as in [[volume]]";
  }
  return text;
}

/// The value after '=', or a string where it is a bare word.
TomlValue parse_value(const std::string& text, const std::string& name, const std::string& where) {
  const Place place = [&](const toml::source_region&, const std::string&) { return where; };
  const std::string line = "value = " + with_all_digits(text);
  if (detail::find_too_deep(line) != 0) throw Error(where + ": " + too_deep());
  try {
    const toml::table parsed = toml::parse(line);
    if (parsed.size() == 1) return convert(*parsed.get("value"), name, where, place);
  } catch (const toml::parse_error& e) {
    constexpr std::string_view kNeverBare = "\"'[{";
    if (text.empty() || kNeverBare.find(text.front()) != std::string_view::npos) {
      throw Error(where + ": the value is not valid TOML: " + description(e));
    }
  }
  TomlValue value;
  value.name = name;
  value.where = where;
  value.value = text;
  return value;
}

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(kBlank) - first + 1));
}

/// "a.b" to {"a", "b"}; empty where a part is.
std::vector<std::string> split_path(std::string_view path) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    parts.push_back(trimmed(path.substr(begin, end - begin)));
    if (parts.back().empty()) return {};
    begin = end + 1;
  }
  return parts;
}

/// The member `key` of a table, added (as false) where it is absent.
TomlValue& member(TomlTable& table, const std::string& key, const std::string& where) {
  const auto at = std::lower_bound(
      table.members.begin(), table.members.end(), key,
      [](const TomlValue& value, const std::string& wanted) { return value.key < wanted; });
  if (at != table.members.end() && at->key == key) return *at;
  TomlValue added;
  added.key = key;
  added.name = (table.name.empty() ? "" : table.name + ".") + key;
  added.key_where = added.where = where;
  return *table.members.insert(at, std::move(added));
}

/// "volume[2]" as "volume" and 2; without a number it is the first.
std::pair<std::string, std::size_t> split_number(const std::string& key, const std::string& where) {
  const std::size_t bracket = key.find('[');
  if (bracket == std::string::npos) return {key, 1};
  std::size_t number = 0;
  if (key.back() != ']') {
    throw Error(where + ": expected a number from 1 in brackets at the end of " + key);
  }
  const char* end = key.data() + key.size() - 1;
  const auto read = std::from_chars(key.data() + bracket + 1, end, number);
  if (read.ec != std::errc() || read.ptr != end || number == 0) {
    throw Error(where + ": expected a number from 1 in the brackets of " + key);
  }
  return {key.substr(0, bracket), number};
}

/// The table of this name in a table, added where it is absent; of an array of tables the one of
/// its number.
TomlTable& section(TomlTable& table, const std::string& numbered, const std::string& where) {
  const auto [key, number] = split_number(numbered, where);
  const bool absent = !table.has(key);
  TomlValue& value = member(table, key, where);
  if (absent) value.value = TomlTable{value.name, where, {}};
  if (auto* array = std::get_if<TomlArray>(&value.value)) {
    const std::string name = value.name + "[1]";
    if (array->empty()) array->push_back({"", name, "", where, TomlTable{name, where, {}}});
    if (number > array->size()) {
      throw Error(fmt::format("{}: there is no {}[{}]; expected a number up to {}", where,
                              value.name, number, array->size()));
    }
    if (auto* found = std::get_if<TomlTable>(&(*array)[number - 1].value)) return *found;
  } else if (number > 1) {
    throw Error(fmt::format("{}: {} is a table, not a list of tables", where, value.name));
  }
  if (auto* found = std::get_if<TomlTable>(&value.value)) return *found;
  throw Error(where + ": " + value.name + " is " + value.text() + " and has no keys");
}

}  // namespace

TomlTable parse_toml(std::string_view text, const std::string& source) {
  const Place place = [&](const toml::source_region& region, const std::string& outer) {
    if (region.begin.line == 0) return outer;
    return fmt::format("{}:{}:{}", source, region.begin.line, region.begin.column);
  };
  if (const std::size_t line = detail::find_too_deep(text)) {
    throw Error(fmt::format("{}:{}: {}", source, line, too_deep()));
  }
  try {
    return convert_table(toml::parse(text), "", source, place);
  } catch (const toml::parse_error& e) {
    throw Error(place(e.source(), source) + ": not valid TOML: " + description(e));
  }
}

TomlTable parse_toml_file(const std::filesystem::path& file) {
  refuse_folder(file, "a TOML file");
  std::error_code ignored;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error(file.string() + ": cannot be read; check the name and its permissions");
  if (std::filesystem::is_regular_file(file, ignored) &&
      std::filesystem::file_size(file, ignored) > kLargestText) {
    throw Error(file.string() + ": has more than 64 MiB; expected a TOML file");
  }
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw Error(file.string() + ": reading failed; check the disk");
  return parse_toml(text, file.string());
}

void apply_set(TomlTable& root, const std::string& set) {
  const std::string where = "--set " + set;
  const std::size_t equals = set.find('=');
  const std::vector<std::string> path = equals == std::string::npos
                                            ? std::vector<std::string>{}
                                            : split_path(std::string_view(set).substr(0, equals));
  const std::string text = equals == std::string::npos ? "" : trimmed(set.substr(equals + 1));
  if (path.empty() || text.empty()) {
    throw Error(where + ": expected SECTION.KEY=VALUE, e.g. medium.g=0.5");
  }
  if (path.size() > detail::kDeepestToml) throw Error("--set: " + too_deep());
  TomlTable* table = &root;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) table = &section(*table, path[i], where);
  TomlValue& target = member(*table, path.back(), where);
  TomlValue value = parse_value(text, target.name, where);
  value.key = target.key;
  value.key_where = where;
  target = std::move(value);
}

}  // namespace pvol::formats
