// Checked reading of TOML, for scenes and recipes: every message says where, what was found and
// what was expected.
//
//   const TomlTable root = parse_toml_file("cloud.toml");
//   root.allow_only({"recipe", "form"});
//   const TomlTable& recipe = *root.table("recipe");
//   recipe.allow_only({"name", "voxel", "offset"});
//   recipe.require({"voxel"});
//   const double voxel = *recipe.number("voxel", Range::above(0));
//   const Vec3d offset = recipe.vector("offset").value_or(Vec3d{});
//   for (const TomlTable* form : root.tables("form")) ...
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"

namespace pvol::formats {

struct TomlValue;

/// One table, with getters that return nothing for a key that is absent and throw Error for a value
/// of another type or out of range.
struct TomlTable {
  std::string name;   ///< dotted path from the root, e.g. "camera" or "sun[1]"; the root's is empty
  std::string where;  ///< "cloud.toml:3:7", or "--set camera.fov=20"; the root's is the file
  std::vector<TomlValue> members;  ///< in order of their keys

  /// Throws Error for the first key that is not listed, naming those that are.
  void allow_only(const std::vector<std::string_view>& keys) const;
  /// Throws Error for the first listed key that is absent.
  void require(const std::vector<std::string_view>& keys) const;

  [[nodiscard]] const TomlValue* find(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const { return find(key) != nullptr; }

  /// A value within limits (pvol/math/limits.h).
  [[nodiscard]] std::optional<Value> take(std::string_view key, const Limits& limits) const;

  // The same for the types that recipes have.
  [[nodiscard]] std::optional<std::int64_t> integer(std::string_view key, std::int64_t lo,
                                                    std::int64_t hi) const;
  [[nodiscard]] std::optional<double> number(std::string_view key, Range range = {}) const;
  [[nodiscard]] std::optional<std::string> string(std::string_view key) const;
  /// A string that is one of `words`.
  [[nodiscard]] std::optional<std::string> word(std::string_view key,
                                                const std::vector<std::string_view>& words) const;
  /// An array of `count` numbers.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key,
                                                           std::size_t count) const;
  /// An array of `width` numbers, or an array of such arrays.
  [[nodiscard]] std::optional<std::vector<std::vector<double>>> rows(std::string_view key,
                                                                     std::size_t width) const;
  /// An array of three numbers.
  [[nodiscard]] std::optional<Vec3d> vector(std::string_view key) const;
  /// The same that is not zero.
  [[nodiscard]] std::optional<Vec3d> direction(std::string_view key) const;
  /// One number for all three components, or an array of three.
  [[nodiscard]] std::optional<Vec3d> number_or_vector(std::string_view key, Range range = {}) const;

  /// A table, or null where the key is absent.
  [[nodiscard]] const TomlTable* table(std::string_view key) const;
  /// An array of tables ([[key]]), or one table taken as an array of one; empty where absent.
  [[nodiscard]] std::vector<const TomlTable*> tables(std::string_view key) const;

  /// "cloud.toml:3:7: camera.fov is 200; expected <expected>", for the value of `key`; where that
  /// is absent, "cloud.toml:3:1: [camera] has no fov; expected <expected>".
  [[noreturn]] void fail(std::string_view key, const std::string& expected) const;
};

using TomlArray = std::vector<TomlValue>;

/// A date or a time, which keys of any text take as what it says; messages name it.
struct TomlDate {
  std::string text;  ///< by RFC 3339
};

struct TomlValue {
  std::string key;        ///< in its table; empty in an array
  std::string name;       ///< dotted path from the root, e.g. "camera.fov" or "camera.up[2]"
  std::string key_where;  ///< place of the key, as TomlTable::where
  std::string where;      ///< place of the value
  std::variant<bool, std::int64_t, double, std::string, TomlDate, TomlArray, TomlTable> value;

  [[nodiscard]] std::string text() const;  ///< as messages show it: 200, "fog", an array of 2
};

/// Throws Error with file, line and column for text that is not TOML, for tables that nest more
/// than 256 levels deep and keys of more than 4096 bytes with those of their tables, and for files
/// that cannot be read or have more than 64 MiB.
[[nodiscard]] TomlTable parse_toml_file(const std::filesystem::path& file);

/// The same for text in memory, which messages call `source`.
[[nodiscard]] TomlTable parse_toml(std::string_view text, const std::string& source);

/// Applies "section.key=value", the value in TOML syntax; one that is not TOML and does not begin
/// with a quote or bracket is taken as a string. Replaces the key or adds it, with its sections; in
/// an array of tables it changes the first one, which is added where there is none. Throws Error
/// that names the text.
void apply_set(TomlTable& root, const std::string& set);

/// Numbers as TOML floats that read back as the same double; the same float after rounding.
[[nodiscard]] std::string toml_number(double value);
[[nodiscard]] std::string toml_number(float value);

/// A string in TOML's quotes, with escapes.
[[nodiscard]] std::string toml_string(std::string_view text);

/// Any of these, and arrays of them.
[[nodiscard]] std::string toml_text(const Value& value);

}  // namespace pvol::formats
