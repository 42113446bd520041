// Places in usda text, and what is said of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "file/import_notes.h"

namespace pvol::formats::detail {

struct UsdWhere {
  std::shared_ptr<const std::filesystem::path> file{};
  std::size_t line = 0, column = 0;
  [[nodiscard]] std::string text() const;  ///< "scene.usda:12"
};

/// Throws Error: "<file>:<line>:<column>: found <found>; expected <expected>".
[[noreturn]] void fail_at(const UsdWhere& where, const std::string& found,
                          const std::string& expected);

/// Names and paths of a file for messages: 80 characters at most, none that a terminal might take
/// for an order.
[[nodiscard]] std::string usd_shown(std::string_view text);

}  // namespace pvol::formats::detail
