// Names of grids, which programs write in capitals or not.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace pvol::formats::detail {

[[nodiscard]] inline bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

}  // namespace pvol::formats::detail
