// Names of grids: as programs write them, and as messages list them.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>
#include <string>
#include <string_view>

#include "pvol/formats/vdb.h"

namespace pvol::formats::detail {

/// Whether names are the same, in capitals or not.
[[nodiscard]] inline bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

/// "density (float), v (vec3s)", or "none".
[[nodiscard]] inline std::string listed(std::span<const GridEntry> grids) {
  std::string text;
  for (const GridEntry& g : grids) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", g.name, g.type);
  }
  return text.empty() ? "none" : text;
}

}  // namespace pvol::formats::detail
