#include "usda/usda_where.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "pvol/error.h"

namespace pvol::formats::detail {

std::string UsdWhere::text() const {
  return fmt::format("{}:{}", file ? file->string() : "", line);
}

void fail_at(const UsdWhere& where, const std::string& found, const std::string& expected) {
  throw Error(
      fmt::format("{}:{}: found {}; expected {}", where.text(), where.column, found, expected));
}

std::string usd_shown(std::string_view text) {
  constexpr std::size_t kMost = 80;
  std::string all(text.substr(0, kMost));
  std::ranges::replace_if(
      all, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, '?');
  return text.size() > kMost ? all + "..." : all;
}

}  // namespace pvol::formats::detail
