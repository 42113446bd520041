// The bodies of a recipe's file: shapes, named bodies, trees of them, and where they stand.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "pvol/form/body.h"
#include "toml/toml_table.h"

namespace pvol::formats {

/// Most forms and perturbations in all bodies of a file together, each use of a named one counted:
/// a few kB can double a body again and again.
inline constexpr std::size_t kMostQuadrics = 1 << 16;

/// Reads body tables ([[form]], [[cut]], [[form.part]] ...) and keeps the named ones,
/// [[body.NAME]].
class BodyReader {
 public:
  /// Reads the named bodies of the file; `root` must outlive the reader.
  explicit BodyReader(const TomlTable& root);

  [[nodiscard]] Body read(const TomlTable& table);
  [[nodiscard]] std::vector<Body> read_all(const TomlTable& parent, std::string_view key);

 private:
  const TomlTable* named_;  // [body], or null
  std::map<std::string, Body> done_;
  std::vector<std::string> open_;  // names that are being read, each used by the one before it
  std::size_t quadrics_ = 0;

  Body read_used(const TomlTable& table);
  Body read_tree(const TomlTable& table);
};

/// A shape of a mask, with the factor that makes its values about distances from the surface, and
/// its steepness.
[[nodiscard]] Quadric read_mask(const TomlTable& table);

}  // namespace pvol::formats
